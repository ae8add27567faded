"""Options: one declaration, three ways in, in the right order."""

from __future__ import annotations

from pathlib import Path

import pytest

from pointbrush.cli import parser
from pointbrush.errors import BadInputError
from pointbrush.settings.command_sets import CLIENTS
from pointbrush.settings.documentation import DOCS, with_new_tables
from pointbrush.settings.settings import Settings, options


def test_command_line_over_environment_over_default() -> None:
    environment = {"POINTBRUSH_PORT": "9000", "POINTBRUSH_HOST": "127.0.0.2"}
    settings = Settings.load({"port": 9001, "host": None}, environment)
    assert (settings.port, settings.host, settings.workers) == (9001, "127.0.0.2", 2)


@pytest.mark.parametrize(
    ("text", "value"), [("1", True), ("true", True), ("0", False), ("", False)]
)
def test_flags_in_the_environment(text: str, value: bool) -> None:
    assert Settings.load({}, {"POINTBRUSH_TLS": text}).tls is value


@pytest.mark.parametrize("name", ["POINTBRUSH_PORT", "POINTBRUSH_TLS"])
def test_a_bad_value_names_its_variable(name: str) -> None:
    with pytest.raises(BadInputError, match=name):
        Settings.load({}, {name: "perhaps"})


@pytest.mark.parametrize(
    ("name", "text"), [("PORT", "65536"), ("PORT", "-1"), ("WORKERS", "0"), ("MAX_UPLOAD", "0")]
)
def test_a_number_out_of_its_range_is_refused(name: str, text: str) -> None:
    with pytest.raises(BadInputError, match=f"{name}: expected an integer from .* got {text}"):
        Settings.load({}, {f"POINTBRUSH_{name}": text})


def test_the_database_defaults_into_the_workspace(tmp_path: Path) -> None:
    assert Settings(workspace=tmp_path).database_url == f"sqlite:///{tmp_path}/labels.sqlite"


@pytest.mark.parametrize("command", ["import", "info", "serve", "track", "backup", "task"])
def test_flags_variables_and_docs_agree(
    command: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "1000")  # no help is broken into lines
    with pytest.raises(SystemExit, match="0"):
        parser().parse_args([command, "--help"])
    shown = capsys.readouterr().out.split()
    rows = {row.split("`")[1]: row for row in DOCS.read_text().splitlines() if row[:4] == "| `-"}
    assert rows.keys() == {option.flag for option in options()}
    for option in options():
        assert option.variable in rows[option.flag]
        assert option.definition.help in rows[option.flag]
        assert option.definition.client_help in rows[option.flag]
        help_text = option.help_in(command, CLIENTS) if option.taken_by(command) else None
        assert (option.flag in shown) == (help_text is not None), option.flag
        assert help_text is None or help_text in " ".join(shown)


def test_the_help_of_a_client_tells_of_its_own_token(capsys: pytest.CaptureFixture[str]) -> None:
    for command, words in (("labels", "your token for the server"), ("serve", "admin token")):
        with pytest.raises(SystemExit):
            parser().parse_args([command, "--help"])
        printed = capsys.readouterr().out
        assert words in printed
        assert ("a new one" in printed) == (command == "serve")


@pytest.mark.parametrize("command", ["info", "labels", "headset-report", "task"])
def test_storage_is_no_part_of_the_help_of_other_commands(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        parser().parse_args([command, "--help"])
    printed = capsys.readouterr().out
    assert "--sequence-cache" not in printed
    assert ("--workspace" in printed) == (command in ("info", "labels"))
    if command == "info":  # hidden flags work
        given = parser().parse_args(["info", "--database", "sqlite:///x"])
        assert given.database == "sqlite:///x"


def test_limits_of_a_server_are_flags() -> None:
    limits = ("--max-body", "--max-message", "--requests-per-second", "--wrong-tokens-per-minute")
    given = parser().parse_args(["serve", *(part for flag in limits for part in (flag, "7"))])
    assert (given.max_body, given.max_message, given.requests_per_second) == (7, 7, 7)


def test_the_page_of_options_is_fresh() -> None:
    text = DOCS.read_text(encoding="utf-8")
    assert text == with_new_tables(text), "run `python -m pointbrush.settings`"
