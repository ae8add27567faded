"""Boxes made elsewhere come in as the points inside."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from pointbrush.formats.boxes.figures import FrameBox, points_of
from pointbrush.formats.boxes.registry import read_boxes
from pointbrush.formats.tables.corrections import Corrections
from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.serving import with_labels
from tests.waiting import PATIENCE

CAR, TREE = np.array([5.0, 2.0, 1.0]), np.array([-4.0, 3.0, 2.0])
YAW = 0.5
UP = np.array([0.0, 0.0, 1.0])


def scene(frame: int) -> np.ndarray:
    """Ground, a car of 4 x 2 x 1.5 m turned by YAW, a tree: 300, 200 and 100 points."""
    rng = np.random.default_rng(frame)
    ground = np.c_[rng.uniform(-10, 10, (300, 2)), rng.normal(0, 0.02, 300)]
    c, s = np.cos(YAW), np.sin(YAW)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    car = (rng.uniform(-0.49, 0.49, (200, 3)) * [4, 2, 1.5]) @ turn.T + CAR
    tree = rng.uniform(-0.49, 0.49, (100, 3)) * [1, 1, 3] + TREE
    return np.concatenate([ground, car, tree]).astype(np.float32)


def xyz(values: np.ndarray) -> dict[str, float]:
    return dict(zip("xyz", (float(v) for v in values), strict=True))


def labelcloud(folder: Path) -> None:
    for k in range(2):
        objects = [
            {
                "name": name,
                "centroid": xyz(center),
                "dimensions": dict(zip(("length", "width", "height"), size, strict=True)),
                "rotations": {"x": 0, "y": 0, "z": np.degrees(turn)},
            }
            for name, center, size, turn in (
                ("car", CAR, (4, 2, 1.5), YAW),
                ("tree", TREE, (1, 1, 3), 0.0),
            )
        ]
        (folder / f"{k:06d}.json").write_text(json.dumps({"objects": objects}))


def sustechpoints(folder: Path) -> None:
    for k in range(2):
        boxes = [
            {
                "obj_type": name,
                "obj_id": number,
                "psr": {
                    "position": xyz(center),
                    "scale": xyz(np.array(size)),
                    "rotation": xyz(np.array([0, 0, turn])),
                },
            }
            for name, number, center, size, turn in (
                ("car", "4", CAR, (4, 2, 1.5), YAW),
                ("tree", "9", TREE, (1, 1, 3), 0.0),
            )
        ]
        (folder / f"{k:06d}.json").write_text(json.dumps(boxes))


def supervisely(folder: Path) -> None:
    figures = [
        {
            "objectKey": key,
            "geometry": {
                "position": xyz(center),
                "dimensions": xyz(np.array(size)),
                "rotation": xyz(np.array([0, 0, turn])),
            },
        }
        for key, center, size, turn in (
            ("a", CAR, (4, 2, 1.5), YAW),
            ("b", TREE, (1, 1, 3), 0.0),
        )
    ]
    objects = [{"key": "a", "classTitle": "car"}, {"key": "b", "classTitle": "tree"}]
    frames = [{"index": k, "figures": figures} for k in range(2)]
    (folder / "annotation.json").write_text(json.dumps({"objects": objects, "frames": frames}))


T_CAM_VELO = np.array([[0, -1, 0, 0.1], [0, 0, -1, -0.2], [1, 0, 0, -0.3], [0, 0, 0, 1.0]])


def kitti_tracking(folder: Path) -> None:
    lines = []
    for k in range(2):
        for number, name, center, (length, width, height), turn in (
            (3, "Car", CAR, (4, 2, 1.5), YAW),
            (0, "Tree", TREE, (1, 1, 3), 0.0),
        ):
            x, y, z = T_CAM_VELO[:3, :3] @ center + T_CAM_VELO[:3, 3]
            place = f"{x} {y + height / 2} {z} {-turn - np.pi / 2}"
            lines.append(f"{k} {number} {name} 0 0 0 0 0 0 0 {height} {width} {length} {place}")
        lines.append(f"{k} -1 DontCare -1 -1 -10 1 1 2 2 -1 -1 -1 -1000 -1000 -1000 -10")
    (folder / "0000.txt").write_text("\n".join(lines))
    row = " ".join(str(v) for v in T_CAM_VELO[:3].ravel())
    (folder / "calib.txt").write_text(f"R_rect 1 0 0 0 1 0 0 0 1\nTr_velo_cam {row}\n")


FORMATS = {
    "labelcloud": (labelcloud, ["car", "tree"]),
    "sustechpoints": (sustechpoints, ["car 4", "tree 9"]),
    "supervisely": (supervisely, ["car 1", "tree 2"]),
    "kitti-tracking": (kitti_tracking, ["Car 3", "Tree 1"]),
}


@pytest.fixture
def workspace(tmp_path: Path) -> Iterator[Workspace]:
    import_frames(
        (PointFrame(scene(k)) for k in range(2)),
        tmp_path / "ws" / "sequences" / "drive",
        RecordingInfo("drive", "Drive", 10.0),
    )
    opened = Workspace(with_labels(Settings(workspace=tmp_path / "ws")))
    yield opened
    opened.close()


def test_boxes_of_every_format_come_in(workspace: Workspace, tmp_path: Path) -> None:
    for name, (write, expected) in FORMATS.items():
        folder = tmp_path / name
        folder.mkdir()
        write(folder)
        job = workspace.imports.begin_labels("drive", folder, "me", no_ground=True)
        job = workspace.runner.wait(job.id, PATIENCE)
        assert job.state == "done", (name, job.error)
        assert job.result["matched"] == 2
        names = {0: ""} | {label.id: label.name for label in workspace.labels.palette("drive")}
        for frame in range(2):
            made = np.zeros(600, np.uint16)
            values = workspace.labels.values("drive", frame)
            made[workspace.recording("drive")[frame].source_index] = values.label
            found = np.array([names[int(value)] for value in made])
            assert set(found[:300]) == {""}, name
            # The lowest of an object within reach of the ground may be left out with it.
            assert (found[300:500] == expected[0]).mean() > 0.9, name
            assert (found[500:] == expected[1]).mean() > 0.9, name
        workspace.labels.undo("drive", "me")


def test_a_point_in_two_boxes_goes_to_the_nearer_centre_and_ground_may_stay(
    tmp_path: Path,
) -> None:
    sustechpoints(tmp_path)
    (part,) = read_boxes(tmp_path / "000000.json", "sustechpoints")
    car, tree = part.boxes
    points = np.array([[5.0, 2.0, 1.0], [-4.0, 3.0, 2.0], [5.0, 2.0, 0.3], [50.0, 0, 0]])
    assert points_of((car, tree), points, UP, no_ground=False).tolist() == [0, 1, 0, -1]
    inner = FrameBox("inner", "", car.center + [1.0, 0, 0], np.full(3, 3.0), np.eye(3))
    near = car.center + np.array([[0.2, 0, 0], [0.9, 0, 0]])
    assert points_of((car, inner), near, UP, no_ground=False).tolist() == [0, 1]


def test_a_file_with_more_frames_than_the_recording_is_told_once(
    workspace: Workspace, tmp_path: Path
) -> None:
    kitti_tracking(tmp_path)
    path = tmp_path / "0000.txt"
    rows = path.read_text().splitlines()[:2]
    later = [f"{k}{row[1:]}" for k in range(2, 9) for row in rows]
    path.write_text("\n".join([*path.read_text().splitlines(), *later]))
    job = workspace.imports.begin_labels("drive", path, "me", dry_run=True)
    result = workspace.runner.wait(job.id, PATIENCE).result
    assert result["matched"] == 2
    assert result["unmatched_files"] == ["0000.txt (7 of 9 frames)"]


@pytest.mark.parametrize("unit", [1.0, 0.001])
def test_boxes_of_points_in_millimetres_are_in_their_unit_or_in_metres(
    tmp_path: Path, unit: float
) -> None:
    points, boxes = tmp_path / "room", tmp_path / "boxes"
    points.mkdir()
    boxes.mkdir()
    np.save(points / "000000.npy", scene(0) * 1000)
    labelcloud(boxes)
    (boxes / "000001.json").unlink()
    content = json.loads((boxes / "000000.json").read_text())
    for each in content["objects"]:
        for part in ("centroid", "dimensions"):
            each[part] = {axis: value / unit for axis, value in each[part].items()}
    (boxes / "000000.json").write_text(json.dumps(content))
    with closing(Workspace(with_labels(Settings(workspace=tmp_path / "workspace")))) as workspace:
        job = workspace.imports.begin([points], chosen=Corrections(scale=0.001))
        assert workspace.runner.wait(job.id, PATIENCE).state == "done"
        done = workspace.runner.wait(
            workspace.imports.begin_labels("room", boxes, "me").id, PATIENCE
        )
        assert done.state == "done", done.error
        assert sorted(done.result["labels"].values()) == [100, 200]
        told = "the boxes are in the units of the recording's files: 0.001 m each"
        assert done.result["warnings"] == ([told] if unit < 1 else [])


def drive_of(folder: Path, first: int, count: int) -> Workspace:
    """A workspace with the recording "drive" of files that are numbered from ``first``."""
    (folder / "drive").mkdir(parents=True)
    for k in range(first, first + count):
        np.save(folder / "drive" / f"{k:06d}.npy", scene(k))
    workspace = Workspace(with_labels(Settings(workspace=folder / "ws")))
    job = workspace.imports.begin([folder / "drive"], name="drive")
    assert workspace.runner.wait(job.id, PATIENCE).state == "done"
    return workspace


def tracking_of(folder: Path, rows: list[tuple[int, int, str]]) -> Path:
    """KITTI's tracking text with the car as frame, track and class of each row."""
    folder.mkdir()
    kitti_tracking(folder)
    car = (folder / "0000.txt").read_text().splitlines()[0].split()[3:]
    lines = (f"{frame} {track} {name} {' '.join(car)}" for frame, track, name in rows)
    (folder / "0000.txt").write_text("\n".join(lines))
    return folder


@pytest.mark.parametrize(
    ("numbers", "expected", "said"),
    [
        (range(7), [0, 1, 2], "by the numbers in the file names: the files are numbered 2 to 4"),
        ([3], [1], "by the numbers in the file names"),
        ([0, 1, 2], [0, 1, 2], "by position"),
    ],
)
def test_labels_of_a_drive_go_to_the_part_of_it_that_is_recorded(
    tmp_path: Path, numbers: Sequence[int], expected: list[int], said: str
) -> None:
    place = tracking_of(tmp_path / "label_02", [(k, 7, "Car") for k in numbers])
    with closing(drive_of(tmp_path, 2, 3)) as workspace:
        job = workspace.imports.begin_labels("drive", place, "me")
        result = workspace.runner.wait(job.id, PATIENCE).result or {}
        (box,) = workspace.labels.boxes.listing("drive").boxes
    assert sorted(box.poses) == expected
    assert said in " ".join(result["warnings"])


def test_a_track_of_two_classes_is_one_object(workspace: Workspace, tmp_path: Path) -> None:
    place = tracking_of(tmp_path / "label_02", [(0, 7, "Van"), (1, 7, "Car"), (1, 9, "Car")])
    lines = (place / "0000.txt").read_text()
    (place / "0000.txt").write_text(lines + "\n" + lines.splitlines()[0].replace("0 7", "2 7"))
    job = workspace.imports.begin_labels("drive", place / "0000.txt", "me")
    result = workspace.runner.wait(job.id, PATIENCE).result or {}
    boxes = workspace.labels.boxes.listing("drive").boxes
    assert sorted(sorted(box.poses) for box in boxes) == [[0, 1], [1]]
    names = {label.id: label.name for label in workspace.labels.palette("drive")}
    assert sorted(names[box.label] for box in boxes) == ["Car 9", "Van 7"]
    assert (
        "object 7 has several classes and is read as one object: Van in 2 frames, Car"
        in " ".join(result["warnings"])
    )


def test_numbers_that_each_class_counts_for_itself_stay_two_objects(
    workspace: Workspace, tmp_path: Path
) -> None:
    place = tracking_of(tmp_path / "label_02", [(0, 1, "Van"), (0, 1, "Car"), (1, 1, "Car")])
    job = workspace.imports.begin_labels("drive", place, "me")
    assert workspace.runner.wait(job.id, PATIENCE).state == "done"
    boxes = workspace.labels.boxes.listing("drive").boxes
    assert sorted(sorted(box.poses) for box in boxes) == [[0], [0, 1]]
