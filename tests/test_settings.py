"""Options: one declaration, three ways in, in the right order."""

from __future__ import annotations

from pathlib import Path

import pytest

from pointbrush.errors import BadInputError
from pointbrush.settings import Settings, options


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


def test_every_option_is_in_the_readme_of_options() -> None:
    text = (Path(__file__).parent.parent / "docs" / "options.md").read_text()
    for option in options():
        assert f"`{option.name.replace('_', '-')}`" in text, option.name
        assert option.metadata["help"] in text, option.name
