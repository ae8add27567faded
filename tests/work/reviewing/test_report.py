"""The report: effort from the times of edits, plots, tables."""

from __future__ import annotations

import csv
import io
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from pointbrush.cli import main
from pointbrush.labels import EditInfo
from pointbrush.teamwork.reviews import Review
from pointbrush.values.kinds import time_of
from pointbrush.work.reviewing.report.gather import effort_of, to_csv
from pointbrush.work.reviewing.report.html import duration, to_html
from pointbrush.work.reviewing.report.plots import MOST, columns
from pointbrush.workspace import Workspace
from tests.serving import add_sequence, settings_in

SEQUENCE = "wall"
FRAMES = 4
IDENTITY = np.eye(4).ravel().tolist()


def edit(time: float, kind: str, *frames: int, author: str = "ada") -> EditInfo:
    return EditInfo(f"{time}", int(time), author, time_of(time), kind, "", 1, frames, False)


def test_time_goes_to_the_frames_of_the_next_edit() -> None:
    found = effort_of([
        edit(1000, "paint", 0),
        edit(1010, "erase", 0),
        edit(1012, "label"),
        edit(1030, "paint", 1, 2),
        edit(9000, "undo", 1),
    ])  # fmt: skip
    told = {key: (each.seconds, each.strokes, each.edits) for key, each in found.items()}
    assert told == {
        (0, "ada"): (15.0, 2, 2),
        (None, "ada"): (2.0, 0, 1),
        (1, "ada"): (14.0, 1, 2),
        (2, "ada"): (9.0, 1, 1),
    }


def test_people_work_side_by_side_and_machines_do_not_count() -> None:
    found = effort_of([
        edit(0, "paint", 0),
        edit(5, "paint", 0, author="grace"),
        edit(30, "tracking", 1, 2, 3),
        edit(40, "paint", 0),
    ])  # fmt: skip
    assert {key: each.seconds for key, each in found.items()} == {
        (0, "ada"): 45.0,
        (0, "grace"): 5.0,
    }


def test_long_recordings_are_drawn_in_columns_that_can_be_seen() -> None:
    values = np.full(10 * MOST, np.nan)
    values[:10] = 1.0
    drawn = columns(values)
    assert len(drawn) == MOST
    assert drawn[0] == 1.0
    assert np.isnan(drawn[1:]).all()


@pytest.mark.parametrize(
    ("seconds", "told"), [(0, "0 s"), (89, "89 s"), (90, "2 min"), (11_100, "3 h 05 min")]
)
def test_durations_in_words(seconds: float, told: str) -> None:
    assert duration(seconds) == told


@pytest.fixture
def workspace(tmp_path: Path) -> Iterator[Workspace]:
    settings = settings_in(tmp_path)
    add_sequence(settings, SEQUENCE, frames=FRAMES, points=1000)
    with closing(Workspace(settings)) as opened:
        label = opened.labels.create_label(SEQUENCE, "ada", name='=<b>"pin"').id
        stroke = {"label": label, "radius": 0.4, "samples": [{"origin": [0, 0, 3]}]}
        opened.strokes.apply(SEQUENCE, 1, stroke, "grace")
        track = {"label": label, "frame": 2, "confidence": 0.75, "state": "tracked"}
        opened.labels.apply(
            SEQUENCE, edit_id=None, author="ada", kind="tracking", writes={}, summary="",
            tracks=[{**track, "pose": IDENTITY, "rmse": 0, "inliers": 1, "points": 0, "start": 1}],
        )  # fmt: skip
        opened.reviewing.put(SEQUENCE, "joan", Review(0, 1, state="accepted", assignee="grace"))
        yield opened


def rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def test_tables_tell_frames_labels_and_people(workspace: Workspace) -> None:
    report = workspace.reviewing.report(SEQUENCE)
    frames = rows(to_csv(report, "frames"))
    assert [row["state"] for row in frames] == ["accepted", "accepted", "open", "open"]
    assert (frames[1]["assignee"], frames[1]["strokes"]) == ("grace", "1")
    assert [int(row["labelled"]) > 0 for row in frames] == [False, True, False, False]
    assert [row["confidence"] for row in frames] == ["", "", "0.750", ""]
    (label,) = rows(to_csv(report, "labels"))
    assert (label["name"], label["frames"]) == ('\'=<b>"pin"', "1")
    assert label["points"] == frames[1]["painted"]
    people = rows(to_csv(report, "people"))
    assert [(row["frame"], row["person"], row["strokes"]) for row in people] == [
        ("1", "grace", "1"),
        ("", "ada", "0"),
    ]


def test_the_page_is_whole_escaped_and_needs_nothing_else(workspace: Workspace) -> None:
    page = to_html(workspace.reviewing.report(SEQUENCE))
    tree = ET.fromstring(page.replace("<!doctype html>", "").replace('<meta charset="utf-8">', "")
                         .replace('<meta name="viewport" content="width=device-width, '
                                  'initial-scale=1">', ""))  # fmt: skip
    words = " ".join(tree.itertext())
    for told in ('=<b>"pin"', "2 of 4", "grace", "1 of 4", "Confidence over time"):
        assert told in words
    assert "<b>" not in page
    for elsewhere in ("http", "src=", "style=", "<script"):
        assert elsewhere not in page


def test_a_recording_without_labels_has_a_report_too(tmp_path: Path) -> None:
    settings = settings_in(tmp_path)
    add_sequence(settings, SEQUENCE, frames=1, points=10)
    chosen = ["--workspace", str(settings.workspace)]
    page, table = tmp_path / "report.html", tmp_path / "people.csv"
    assert main(["report", SEQUENCE, "--out", str(page), *chosen]) == 0
    assert "There are no labels yet" in page.read_text()
    assert main(["report", SEQUENCE, "--out", str(table), "--table", "people", *chosen]) == 0
    assert table.read_text() == "frame,person,seconds,strokes,edits\n"
    assert main(["report", SEQUENCE, "--out", str(tmp_path / "report.pdf"), *chosen]) == 1
