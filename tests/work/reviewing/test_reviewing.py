"""Checks of a recording in a workspace: found, placed, looked at again, settled."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from pointbrush.cli import main
from pointbrush.errors import BadInputError
from pointbrush.settings import Settings
from pointbrush.teamwork.reviews import Review
from pointbrush.work.exporting import source_columns
from pointbrush.workspace import Workspace
from tests.serving import add_sequence, settings_in

SEQUENCE = "wall"
FRAMES = 5


@pytest.fixture
def settings(tmp_path: Path) -> Settings:
    chosen = settings_in(tmp_path)
    add_sequence(chosen, SEQUENCE, frames=FRAMES, points=2000)
    return chosen


@pytest.fixture
def workspace(settings: Settings) -> Iterator[Workspace]:
    opened = Workspace(settings)
    yield opened
    opened.close()


def paint(workspace: Workspace, frame: int, near: tuple[float, float], label: int) -> None:
    """Give a label to the points within 40 cm of a place of the wall."""
    columns = np.concatenate(
        [part["xyz"] for part in source_columns(workspace.recording(SEQUENCE), frame, ("xyz",))]
    )
    annotation = workspace.annotations.read(SEQUENCE, frame)[0].copy()
    annotation[np.linalg.norm(columns[:, :2] - near, axis=1) < 0.4] = label
    workspace.annotations.put(SEQUENCE, frame, annotation, author="ada")


def told(workspace: Workspace) -> list[tuple[str, int | None, int | None, bool]]:
    found = workspace.reviewing.checks(SEQUENCE).findings
    return [(each.kind, each.first, each.last, each.settled) for each in found]


def test_a_slip_is_found_accepted_and_found_again_when_the_frame_changes(
    workspace: Workspace,
) -> None:
    label = workspace.labels.create_label(SEQUENCE, "ada", name="pin").id
    for frame in range(FRAMES):
        paint(workspace, frame, (-1.0, 0.0), label)
    assert told(workspace) == []
    paint(workspace, 2, (1.5, 0.5), label)
    ((kind, first, last, settled), *_) = told(workspace)
    assert (kind, first, last, settled) == ("stray", 2, 2, False)
    (finding,) = workspace.reviewing.checks(SEQUENCE, "2:3").findings
    assert finding.place is not None
    assert np.linalg.norm(np.subtract(finding.place[:2], (1.5, 0.5))) < 0.3
    workspace.reviewing.put(SEQUENCE, "ada", Review(2, 2, state="accepted"))
    assert ("stray", 2, 2, True) in told(workspace)
    paint(workspace, 2, (0.3, -1.5), label)
    assert ("stray", 2, 2, False) in told(workspace)
    with pytest.raises(BadInputError, match="frames"):
        workspace.reviewing.checks(SEQUENCE, "3:99")


def test_a_label_without_points_is_settled_by_accepting_the_label(workspace: Workspace) -> None:
    label = workspace.labels.create_label(SEQUENCE, "ada", name="pin").id
    assert told(workspace) == [("few", None, None, False)]
    workspace.reviewing.put(SEQUENCE, "ada", Review(None, None, label=label, state="accepted"))
    assert told(workspace) == [("few", None, None, True)]


def test_the_command_lists_them(settings: Settings, capsys: pytest.CaptureFixture[str]) -> None:
    opened = Workspace(settings)
    for _ in range(2):
        label = opened.labels.create_label(SEQUENCE, "ada", name="pin").id
    paint(opened, 1, (0.0, 0.0), label)
    opened.close()
    assert main(["check-labels", SEQUENCE, "--workspace", str(settings.workspace)]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "palette: “pin” has no points in any frame",
        "frame 1: 2 labels are called “pin”",
        "2 suspicious",
    ]
