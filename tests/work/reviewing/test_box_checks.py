"""Suspicious boxes: each kind is found where it was put, and nothing in sound ones."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from pointbrush.frame import PointFrame
from pointbrush.geometry.oriented_box import AttributeValue, BoxPose, OrientedBox
from pointbrush.labels import Write
from pointbrush.sequences import RecordingInfo, import_frames, open_sequence
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.work.reviewing.checking import Checker

FRAMES, GROUND, CAR = 6, 3000, 500
SIZE = np.array([4.0, 2.0, 1.5])


def scene(frame: int) -> PointFrame:
    """A car of 500 points on a street, half a metre farther in each frame."""
    rng = np.random.default_rng(frame)
    street = np.column_stack([rng.uniform(-10, 10, (GROUND, 2)), rng.normal(0, 0.01, GROUND)])
    car = rng.uniform(-0.48, 0.48, (CAR, 3)) * SIZE + [0.5 * frame, 0, 0.75]
    return PointFrame(np.concatenate([street, car]).astype(np.float32))


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("checked") / "street"
    import_frames(map(scene, range(FRAMES)), folder, RecordingInfo("street", "street", 1.0))
    return folder


@pytest.fixture
def store(tmp_path: Path, recording: Path) -> WorkspaceStore:
    opened = open_sequence(recording)
    store = WorkspaceStore(f"sqlite:///{tmp_path / 'labels.sqlite'}")
    store.recordings.register("street", opened.manifest.points)
    for name in ("car", "van"):
        store.create_label("street", "ann", name=name)
    writes = {
        frame: Write(np.flatnonzero(opened[frame].source_index >= GROUND), label=1, provenance=1)
        for frame in range(FRAMES)
    }
    store.apply(
        "street", edit_id=None, author="ann", kind="paint", writes=writes, summary="",
        boxes=[box()],
    )  # fmt: skip
    return store


def box(
    label: int = 1,
    offsets: Mapping[int, tuple[float, float, float]] | None = None,
    size: np.ndarray = SIZE,
    attributes: Mapping[str, AttributeValue] | None = None,
) -> OrientedBox:
    """The car's box, where its frames are not told otherwise."""
    away = offsets or {}
    poses = {
        frame: BoxPose(
            np.array([0.5 * frame, 0, 0.75]) + away.get(frame, (0.0, 0.0, 0.0)),
            np.array([0.0, 0.0, 0.0, 1.0]),
        )
        for frame in (range(FRAMES) if offsets is None else offsets)
    }
    return OrientedBox(0, label, size, poses, attributes or {})


def found(store: WorkspaceStore, recording: Path) -> list[tuple[str, int | None, int | None]]:
    checked = Checker(store).check(open_sequence(recording), range(FRAMES))
    kinds = [each for each in checked.findings if each.kind.startswith("box")]
    return [(each.kind, each.first, each.last) for each in kinds]


def test_sound_boxes_are_not_suspicious(store: WorkspaceStore, recording: Path) -> None:
    assert found(store, recording) == []


def test_a_box_that_jumps_and_one_that_turns_about(store: WorkspaceStore, recording: Path) -> None:
    about = {"centre": [1.0, 0.0, 0.75], "quaternion": [0.0, 0.0, 1.0, 0.0]}
    store.boxes.change("street", "ann", 1, {"poses": {"2": about}})
    assert found(store, recording) == [("box_jump", 2, 3)]
    store.undo("street", "ann")
    there = {"centre": [5.0, 0.0, 0.75]}
    store.boxes.change("street", "ann", 1, {"poses": {"3": there}})
    assert ("box_jump", 3, 4) in found(store, recording)


def test_boxes_off_the_ground_and_beside_their_points(
    store: WorkspaceStore, recording: Path
) -> None:
    raised = {"centre": [1.0, 0.0, 1.25]}
    store.boxes.change("street", "ann", 1, {"poses": {"2": raised}})
    assert found(store, recording) == [("box_ground", 2, 2), ("box_outside", 2, 2)]


def test_boxes_without_points_unless_they_are_hidden(
    store: WorkspaceStore, recording: Path
) -> None:
    high = {4: (0.0, 0.0, 9.0)}
    made = store.boxes.add("street", "ann", box(2, high)).box.id
    assert found(store, recording) == [("box_empty", 4, 4)]
    store.boxes.change("street", "ann", made, {"poses": {"4": {"attributes": {"occluded": 2}}}})
    assert found(store, recording) == []


def test_boxes_that_overlap_and_those_of_two_sizes(store: WorkspaceStore, recording: Path) -> None:
    beside = store.boxes.add("street", "ann", box(2, {1: (0.0, 2.05, 0.0)})).box.id
    store.boxes.change("street", "ann", beside, {"attributes": {"occluded": 3}})
    assert found(store, recording) == []
    store.boxes.change("street", "ann", beside, {"poses": {"1": {"centre": [0.5, 1.5, 0.75]}}})
    assert found(store, recording) == [("box_overlap", 1, 1)]
    store.boxes.remove("street", "ann", beside)
    store.boxes.add("street", "ann", box(1, {5: (0, 0, 0)}, SIZE * 1.3))
    assert {kind for kind, *_ in found(store, recording)} >= {"box_size", "box_overlap"}


def test_boxes_whose_front_is_unknown(store: WorkspaceStore, recording: Path) -> None:
    store.boxes.change("street", "ann", 1, {"heading_known": False})
    assert found(store, recording) == [("box_heading", 0, 0)]
