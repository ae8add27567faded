"""Boxes of every format go out and come in again."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pointbrush.formats.boxes.conventions import CONVENTIONS
from pointbrush.formats.boxes.figures import FrameBox
from pointbrush.formats.boxes.registry import is_box_file, read_boxes
from pointbrush.formats.boxes.scene import (
    BoxTrack,
    Scene,
    SceneFrame,
    View,
    by_frame,
    label_of,
    tracked,
)
from pointbrush.formats.boxes.writing import ATTRIBUTES, BOX_WRITERS, HEADING, OBJECTS
from pointbrush.geometry.oriented_box import UNKNOWN_OCCLUSION, BoxPose, OrientedBox
from pointbrush.geometry.quaternions import quaternion_of, rotation_of

CLASSES = {1: "vehicle", 2: "pedestrian", 3: "vehicle"}
COLORS = {"vehicle": "#ff8800", "pedestrian": "#00ffaa"}
STAMP = 1533151603547590000
"""Nanoseconds of the first frame, as its file is called."""


def turned(yaw: float, roll: float, pitch: float) -> np.ndarray:
    c, s = np.cos([yaw, roll, pitch]), np.sin([yaw, roll, pitch])
    Rz = np.array([[c[0], -s[0], 0], [s[0], c[0], 0], [0, 0, 1]])
    Rx = np.array([[1, 0, 0], [0, c[1], -s[1]], [0, s[1], c[1]]])
    Ry = np.array([[c[2], 0, s[2]], [0, 1, 0], [-s[2], 0, c[2]]])
    return np.asarray(Rz @ Ry @ Rx)


angle = st.floats(-3.1, 3.1)
tilt = st.floats(-1.5, 1.5)
place = st.tuples(*[st.floats(-80, 80)] * 3)


@st.composite
def boxes(draw: st.DrawFn, upright: bool) -> list[OrientedBox]:
    made = []
    for label in draw(st.sets(st.sampled_from(sorted(CLASSES)), min_size=1)):
        poses = {}
        for frame in draw(st.sets(st.integers(0, 2), min_size=1)):
            roll, pitch = (0.0, 0.0) if upright else (draw(tilt), draw(tilt))
            R = turned(draw(angle), roll, pitch)
            level = draw(st.none() | st.integers(0, UNKNOWN_OCCLUSION))
            told = {} if level is None else {"occluded": float(level)}
            poses[frame] = BoxPose(np.array(draw(place)), quaternion_of(R), attributes=told)
        size = np.array(draw(st.tuples(*[st.floats(0.2, 20)] * 3)))
        known = draw(st.booleans())
        more = {"parked": True, "load": "sand"}
        made.append(OrientedBox(label, label, size, poses, more, heading_known=known))
    return made


def frames_of(made: list[OrientedBox], **more: Any) -> list[SceneFrame]:
    found = by_frame(made, CLASSES)
    return [
        SceneFrame(
            k, str(STAMP + k * 10**8), STAMP / 1e9 + k / 10, found.get(k, ()),
            tuple(range(len(found.get(k, ())))), **more,
        )
        for k in range(3)
    ]  # fmt: skip


def out(format: str, frames: list[SceneFrame], folder: Path) -> list[Path]:
    """Write frames to a folder; return the files that have boxes."""
    for name, content in BOX_WRITERS[format].write(iter(frames), Scene("drive", COLORS)):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    wanted, pattern = BOX_WRITERS[format].read_as
    found = [path for path in sorted(folder.rglob("*")) if path.match(pattern)]
    return [path for path in found if is_box_file(path, wanted)]


def back(format: str, frames: list[SceneFrame], folder: Path) -> list[BoxTrack]:
    """Write frames, read them, and tell their frames as an import does."""
    parts: dict[int, list[FrameBox]] = {}
    for path in out(format, frames, folder):
        for part in read_boxes(path, BOX_WRITERS[format].read_as[0]):
            known = [
                f.index
                for f in frames
                if part.frame in (f.index, f.name, f"{f.name}.pcd")
                or (part.time is not None and abs(part.time - f.time) < 1e-5)
                or (part.frame is None and part.time is None and path.stem in (f.stem, f.name))
            ]
            (index,) = known
            each = [box for box in part.boxes if isinstance(box, FrameBox)]
            parts.setdefault(index, []).extend(each)
    return tracked(sorted(parts.items()))


def told(attributes: Mapping[str, Any], box: OrientedBox | BoxTrack, frame: int) -> dict[str, Any]:
    """Attributes in a frame; an unknown occlusion is the same as none."""
    found = {**attributes, **box.poses[frame].attributes}
    return {k: v for k, v in found.items() if (k, v) != ("occluded", UNKNOWN_OCCLUSION)}


def nearest(found: list[BoxTrack], box: OrientedBox, frame: int) -> BoxTrack:
    here = [each for each in found if frame in each.poses]
    return min(here, key=lambda e: np.abs(e.poses[frame].centre - box.poses[frame].centre).max())


def require_same(format: str, made: list[OrientedBox], found: list[BoxTrack]) -> None:
    lost = BOX_WRITERS[format].lost
    for box in made:
        for frame, pose in box.poses.items():
            mine = nearest(found, box, frame)
            assert np.abs(mine.poses[frame].centre - pose.centre).max() < 1e-3
            assert np.abs(mine.size - box.size).max() < 1e-3
            R = rotation_of(mine.poses[frame].quaternion).T @ rotation_of(pose.quaternion)
            assert np.degrees(np.linalg.norm(R - np.eye(3)) / np.sqrt(2)) < 0.01
            assert mine.name == CLASSES[box.label]
            assert mine.heading_known == (HEADING in lost or box.heading_known)
            kept = told(mine.attributes, mine, frame)
            if "occluded" in " ".join(lost):
                assert kept == told({}, box, frame)
            else:
                assert kept == ({} if ATTRIBUTES in lost else told(box.attributes, box, frame))
            if OBJECTS not in lost:
                assert label_of(mine.key) == box.label
                assert set(mine.poses) == set(box.poses)


@pytest.mark.parametrize("format", BOX_WRITERS)
def test_boxes_come_back(format: str) -> None:
    upright = CONVENTIONS[BOX_WRITERS[format].convention].upright

    @settings(max_examples=8, deadline=None)
    @given(boxes(upright))
    def run(made: list[OrientedBox]) -> None:
        with tempfile.TemporaryDirectory() as folder:
            require_same(format, made, back(format, frames_of(made), Path(folder)))

    run()


def test_kitti_tells_the_picture_of_a_box() -> None:
    """Readme of KITTI's object devkit: truncated is the share that leaves the picture, alpha the
    angle as it is seen, from the side of the camera's ray."""
    ahead = np.eye(4)
    ahead[:3, :3] = [[0, -1, 0], [0, 0, -1], [1, 0, 0]]
    view = View(np.array([[100.0, 0, 200], [0, 100, 50], [0, 0, 1]]), ahead, 400, 100)
    poses = {
        0: BoxPose(np.array([10.0, 0, 0]), quaternion_of(np.eye(3))),
        1: BoxPose(np.array([10.0, -18.0, 0]), quaternion_of(np.eye(3))),
        2: BoxPose(np.array([-10.0, 0, 0]), quaternion_of(np.eye(3))),
    }
    made = [OrientedBox(1, 1, np.full(3, 2.0), poses)]
    wrote = dict(BOX_WRITERS["kitti-object"].write(frames_of(made, view=view), Scene("s", COLORS)))
    told = [wrote[f"label_2/{k:06d}.txt"].decode().split()[1:8] for k in range(3)]
    front, aside, behind = (list(map(float, each)) for each in told)
    near = 100 / 9  # pixels of a metre at the near face
    assert front == pytest.approx(
        [0, 3, -np.pi / 2, *(200 - near, 50 - near), *(200 + near, 50 + near)], abs=1e-4
    )
    left, right = 200 + 100 * 17 / 11, 200 + 100 * 19 / 9
    assert aside[0] == pytest.approx((right - 399) / (right - left), abs=1e-4)
    assert aside[3:] == pytest.approx([left, 50 - near, 399, 50 + near], abs=1e-4)
    assert aside[2] == pytest.approx(-np.pi / 2 - np.arctan2(18, 10), abs=1e-4)
    assert behind[3:] == [-1, -1, -1, -1]


def test_an_unknown_occlusion_is_written_as_unknown() -> None:
    """KITTI: occluded 3, and -1 for a truncation without a picture (devkit, ``writeLabels.m``).

    nuScenes: no token of a visibility.  The editors: no attribute.
    """
    pose = BoxPose(np.zeros(3), quaternion_of(np.eye(3)))
    for attributes in ({}, {"occluded": UNKNOWN_OCCLUSION}):
        made = frames_of([OrientedBox(1, 1, np.ones(3), {0: pose}, attributes)])[:1]

        def wrote(format: str, name: str) -> Any:
            text = dict(BOX_WRITERS[format].write(iter(made), Scene("s", COLORS)))[name].decode()  # noqa: B023
            return text.split() if name.endswith(".txt") else json.loads(text)

        assert wrote("kitti-object", "label_2/000000.txt")[1:4] == ["-1.0000", "3", "-10.000000"]
        assert wrote("kitti-tracking", "label_02/0000.txt")[3:6] == ["-1", "3", "-10.000000"]
        (row,) = wrote("nuscenes-boxes", "v1.0-pointbrush/sample_annotation.json")
        assert (row["visibility_token"], row["attribute_tokens"]) == ("", [])
        assert wrote("sustechpoints", f"label/{STAMP}.json")[0]["obj_attr"] == ""
        (item,) = wrote("datumaro", "annotations/default.json")["items"]
        assert item["annotations"][0]["attributes"] == {"track_id": 1}
        assert wrote("supervisely", "episode/annotation.json")["objects"][0]["tags"] == []
        (sample,) = wrote("segments", "release.json")["dataset"]["samples"]
        (frame,) = sample["labels"]["ground-truth"]["attributes"]["frames"]
        assert frame["annotations"][0]["attributes"] == {}


def test_levels_of_truncation_come_back(tmp_path: Path) -> None:
    shares = (0.0, 0.3, 1.0)
    poses = {
        frame: BoxPose(np.zeros(3), quaternion_of(np.eye(3)), attributes={"truncated": share})
        for frame, share in enumerate(shares)
    }
    frames = frames_of([OrientedBox(1, 1, np.ones(3), poses)])
    (track,) = back("kitti-tracking", frames, tmp_path)
    assert [told({}, track, frame)["truncated"] for frame in poses] == [0, 0.5, 1]
