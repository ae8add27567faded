"""Labels a point of Segments.ai's releases: ids of annotations, which have categories.

The layout is that of segments-ai/docs, reference/label-types.md.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.serving import with_labels
from tests.waiting import PATIENCE

POINTS = 12
IDS = [0, 3, 3, 1, 1, 1, 2, 2, 0, 3, 3, 3]
CATEGORIES = [{"id": 1, "name": "car"}, {"id": 4, "name": "road", "has_instances": False}]


@pytest.fixture
def workspace(tmp_path: Path) -> Iterator[Workspace]:
    rng = np.random.default_rng(5)
    xyz = [rng.normal(size=(POINTS, 3)).astype(np.float32) for _ in range(2)]
    rows = np.arange(POINTS, dtype=np.int64) + 1
    import_frames(
        [PointFrame(xyz[0]), PointFrame(xyz[1], rows=rows, dropped=1)],
        tmp_path / "ws" / "sequences" / "drive",
        RecordingInfo("drive", "Drive", 10.0),
    )
    opened = Workspace(with_labels(Settings(workspace=tmp_path / "ws")))
    yield opened
    opened.close()


def labelled(ids: Sequence[int], tracks: bool = False) -> dict[str, Any]:
    categories = {1: 1, 2: 1, 3: 4}
    annotations = [{"id": number, "category_id": kind} for number, kind in categories.items()]
    for each in annotations if tracks else ():
        each["track_id"] = each["id"] + 70
    return {"format_version": "0.1", "annotations": annotations, "point_annotations": ids}


def sample(name: str, attributes: Any, frames: Any = None) -> dict[str, Any]:
    label = attributes and {"label_status": "LABELED", "attributes": attributes}
    return {"name": name, "attributes": frames or {}, "labels": {"ground-truth": label}}


def release(path: Path, *samples: dict[str, Any]) -> Path:
    path.parent.mkdir(exist_ok=True)
    attributes = {"format_version": "0.1", "categories": CATEGORIES}
    dataset = {"task_attributes": attributes, "samples": samples}
    path.write_text(json.dumps({"name": "r", "dataset": dataset}))
    return path


def names(workspace: Workspace, path: Path) -> list[list[str]]:
    """Import labels; the name of each point's label in both frames."""
    job = workspace.imports.begin_labels("drive", path, "ann")
    done = workspace.runner.wait(job.id, PATIENCE)
    assert done.state == "done", done.error
    known = {label.id: label.name for label in workspace.labels.palette("drive")} | {0: ""}
    return [
        [known[n] for n in workspace.annotations.read("drive", frame)[0].tolist()]
        for frame in range(2)
    ]


def named(ids: Sequence[int], cars: Sequence[str]) -> list[str]:
    return [["", *cars, "road"][number] for number in ids]


def test_samples_are_frames_and_their_annotations_objects_of_them(
    workspace: Workspace, tmp_path: Path
) -> None:
    path = release(
        tmp_path / "in" / "release.json",
        sample("000000", labelled(IDS)),
        sample("000001", None),
        sample("000001", labelled([2, *IDS])),
        {"name": "000007", "labels": {}},
    )
    first, second = names(workspace, path)
    assert first == named(IDS, ["car 1", "car 2"])
    assert second == named(IDS, ["car 3", "car 4"])


@pytest.mark.parametrize("several", [False, True])
def test_objects_of_a_sequence_are_told_by_their_tracks(
    workspace: Workspace, tmp_path: Path, several: bool
) -> None:
    told: Any = {"frames": [labelled(IDS, tracks=True), labelled([0, *IDS], tracks=True)]}
    files: Any = {"frames": [{"name": "scan 0"}, {"name": "scan 1"}]}
    if several:
        image = {"name": "c", "task_type": "image-vector-sequence", "attributes": {"frames": []}}
        lidar = {"name": "l", "task_type": "pointcloud-segmentation-sequence"}
        told = {"sensors": [image, lidar | {"attributes": told}]}
        files = {"sensors": [image, lidar | {"attributes": files}]}
    path = release(tmp_path / "in" / "release.json", sample("drive", told, files))
    assert names(workspace, path) == [named(IDS, ["car 71", "car 72"])] * 2


@pytest.mark.parametrize(
    ("ids", "message"),
    [
        (IDS[1:], "expected labels of the 12 points of frame 0, got 11"),
        ([*IDS[1:], 9], "expected point_annotations with ids of annotations, got 9"),
        ([*IDS[1:], 1.5], "expected point_annotations of Segments.ai as a list of whole numbers"),
    ],
)
def test_labels_that_do_not_fit_are_refused(
    workspace: Workspace, tmp_path: Path, ids: list[int], message: str
) -> None:
    path = release(tmp_path / "in" / "release.json", sample("000000", labelled(ids)))
    job = workspace.imports.begin_labels("drive", path, "ann")
    done = workspace.runner.wait(job.id, PATIENCE)
    assert done.state == "failed"
    assert done.error is not None
    assert f"release.json: {message}" in done.error
    assert workspace.labels.palette("drive") == []
