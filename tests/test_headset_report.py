"""Reports of headsets: what they say in words, and that other files are refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from pointbrush.cli import main
from pointbrush.headset_report.model import LARGEST

GOLDEN = Path(__file__).parent / "golden"


@pytest.fixture
def report() -> dict[str, Any]:
    loaded: dict[str, Any] = json.loads((GOLDEN / "headset-vive.json").read_text())
    return loaded


def words(folder: Path, report: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> list[str]:
    path = folder / "report.json"
    path.write_text(json.dumps(report))
    assert main(["headset-report", str(path)]) == 0
    return [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("quest", "works right controller meta-quest-touch-plus, taken for touch"),
        ("vive", "works right controller: buttons 0 1 2 of 3 pressed, axes 0 1 of 2 leaned"),
        ("hands", "works right hand: joints 25 seen"),
    ],
)
def test_each_walk_in_words(name: str, line: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["headset-report", str(GOLDEN / f"headset-{name}.json")]) == 0
    lines = [" ".join(text.split()) for text in capsys.readouterr().out.splitlines()]
    assert line in lines
    assert "fails reference space unbounded" in lines
    tried = ("play the recording", "pulses that are felt", "paint", "erase", "switch the label")
    for task in (*tried, "undo", "step to another frame", "go somewhere"):
        by = {f"works {task}", f"works {task} by buttons"}
        assert by & set(lines), task


def test_what_was_not_tried_is_unknown_and_what_the_person_denies_fails(
    tmp_path: Path, report: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    verdicts = {task["name"]: task for task in report["tasks"]}
    verdicts["felt"]["verdict"] = "fails"
    verdicts["go"]["verdict"] = "unknown"
    report["session"]["features"] = [{"name": "layers", "granted": None}]
    report["inputs"][0] |= {"kind": "", "layout": "", "pressed": []}
    report["pictures"] |= {"told": 90, "count": 100, "late": 6}
    lines = words(tmp_path, report, capsys)
    for line in (
        "fails pulses that are felt",
        "unknown go somewhere",
        "unknown feature layers",
        "fails left unknown input htc-vive, taken for nothing",
    ):
        assert line in lines
    assert any(line.startswith("fails pictures in time 90/s told") for line in lines)
    report["pictures"] |= {"late": 5}
    assert any(
        line.startswith("works pictures in time") for line in words(tmp_path, report, capsys)
    )
    # Nobody could enter: the browser's reason, and nothing else.
    report |= {"session": None, "inputs": [], "pictures": None, "trouble": "No headset."}
    lines = words(tmp_path, report, capsys)
    assert "fails session No headset." in lines
    assert "unknown pictures in time" in lines


def test_hidden_characters_of_a_file_do_not_reach_the_terminal(
    tmp_path: Path, report: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    report["browser"] = "Chrome\x1b[2J\u202e"
    assert r"Chrome\x1b[2J\u202e" in words(tmp_path, report, capsys)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"{}", "expected a headset report of version 1, but format: Field required"),
        (b"\x89PNG", "expected a headset report of version 1, but the file: Invalid JSON"),
        (b" " * (LARGEST + 1), "expected a headset report, got more than 1,048,576 bytes"),
        (None, "expected a readable file (No such file or directory)"),
    ],
)
def test_other_files_are_refused_in_words(
    tmp_path: Path, content: bytes | None, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "other.json"
    if content is not None:
        path.write_bytes(content)
    assert main(["headset-report", str(path)]) == 1
    told = capsys.readouterr().err
    assert said in told
    assert len(told.splitlines()) == 1


def test_another_version_or_field_is_refused(
    tmp_path: Path, report: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "later.json"
    for change in ({"version": 2}, {"address": "192.168.1.5"}, {"made": 5}):
        path.write_text(json.dumps(report | change))
        assert main(["headset-report", str(path)]) == 1
        assert next(iter(change)) in capsys.readouterr().err
