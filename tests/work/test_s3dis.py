"""Rooms of S3DIS come in with the labels of their objects, at once or later."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest

from pointbrush.database.job import Job
from pointbrush.formats.tables.corrections import Corrections
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.serving import with_labels
from tests.waiting import PATIENCE

OBJECTS = ("ceiling_1", "chair_1", "chair_2", "bookcase_tall_12")
COUNT = 50
"""Points of each object, and of none."""


def room(folder: Path, seed: int = 0) -> list[str]:
    """Write a room with its objects, and points of none; the name of each point's label."""
    rng = np.random.default_rng(seed)
    which = rng.permutation(np.repeat(np.arange(len(OBJECTS) + 1), COUNT))
    xyz = rng.uniform(-20, 20, (len(which), 3))
    lines = [
        f"{x:.3f} {y:.3f} {z:.3f} {k} 20 30\n" for (x, y, z), k in zip(xyz, which, strict=True)
    ]
    (folder / "Annotations").mkdir(parents=True)
    (folder / f"{folder.name}.txt").write_text("".join(lines))
    (folder / "Annotations" / ".DS_Store").write_bytes(b"\0")
    for k, name in enumerate(OBJECTS):
        own = [line for line, each in zip(lines, which, strict=True) if each == k]
        (folder / "Annotations" / f"{name}.txt").write_text("".join(rng.permutation(own)))
    called = [*(name.replace("_1", " 1").replace("_2", " 2") for name in OBJECTS), ""]
    return [called[k] for k in which]


@pytest.fixture
def workspace(tmp_path: Path) -> Iterator[Workspace]:
    opened = Workspace(with_labels(Settings(workspace=tmp_path / "workspace")))
    yield opened
    opened.close()


def bring(workspace: Workspace, *paths: Path, scale: float = 1.0) -> Job:
    job = workspace.imports.begin(list(paths), name="Home", chosen=Corrections(scale=scale))
    done = workspace.runner.wait(job.id, PATIENCE)
    assert done.state == "done", done.error
    return done


def names(workspace: Workspace, sequence: str, frames: int = 1) -> Sequence[list[str]]:
    known = {label.id: label.name for label in workspace.labels.palette(sequence)} | {0: ""}
    return [
        [known[n] for n in workspace.annotations.read(sequence, frame)[0].tolist()]
        for frame in range(frames)
    ]


def test_a_room_comes_in_with_its_objects(workspace: Workspace, tmp_path: Path) -> None:
    expected = room(tmp_path / "office_1")
    done = bring(workspace, tmp_path / "office_1")
    assert names(workspace, "home") == [expected]
    assert done.result["warnings"] == []
    categories = {label.name: label.category for label in workspace.labels.palette("home")}
    assert categories["bookcase_tall 12"] == "bookcase_tall"


@pytest.mark.parametrize("scale", [1.0, 0.001])
def test_objects_of_rooms_that_are_there_come_in_later(
    workspace: Workspace, tmp_path: Path, scale: float
) -> None:
    expected = [room(tmp_path / "area" / f"office_{k}", seed=k) for k in range(2)]
    texts = [tmp_path / "area" / f"office_{k}" / f"office_{k}.txt" for k in range(2)]
    kept = [path.rename(tmp_path / path.name) for path in texts]
    bring(workspace, *kept, scale=scale)
    second = tmp_path / "area" / "office_1" / "Annotations"
    for place, wanted in (
        (second, [[""] * len(expected[0]), expected[1]]),
        (tmp_path / "area", expected),
    ):
        done = workspace.runner.wait(
            workspace.imports.begin_labels("home", place, "ann").id, PATIENCE
        )
        assert done.state == "done", done.error
        assert names(workspace, "home", 2) == wanted


def test_points_of_objects_that_the_room_does_not_have_are_counted(
    workspace: Workspace, tmp_path: Path
) -> None:
    expected = room(tmp_path / "office_1")
    chair = tmp_path / "office_1" / "Annotations" / "chair_1.txt"
    chair.write_text(chair.read_text() + "99 99 99 1 2 3\n")
    done = bring(workspace, tmp_path / "office_1")
    lost = f"1 of {4 * COUNT + 1} points of objects are not among the points of the room"
    assert done.result["warnings"] == [f"office_1.txt: {lost}"]
    assert names(workspace, "home") == [expected]


def test_a_damaged_object_is_named(workspace: Workspace, tmp_path: Path) -> None:
    room(tmp_path / "office_1")
    chair = tmp_path / "office_1" / "Annotations" / "chair_1.txt"
    chair.write_text(f"1 2 3 4 5 6\n{chair.read_text()}1 two 3 4 5 6\n")
    job = workspace.imports.begin([tmp_path / "office_1"], name="Home")
    done = workspace.runner.wait(job.id, PATIENCE)
    assert done.state == "failed"
    assert f"chair_1.txt line {COUNT + 2}: expected a number" in str(done.error)
