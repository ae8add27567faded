"""Every export, brought into a copy without labels, gives back names, categories and points."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from pathlib import Path
from uuid import uuid4

import numpy as np
import pytest

from pointbrush.formats import EXPORTS
from pointbrush.labels import Label
from pointbrush.labels.classes.palette import default_color
from pointbrush.labels.classes.taxonomy import Category
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace

HOSTILE = [
    ("car", "car"), ("car", "car"), ("tree", ""), ("void", "unlabeled"), ("x" * 200, "y" * 200),
    ("b/a ä'\"#", "汽/-.0 ö"), (" _.", ""), ("0", "\"a b'"),
]  # fmt: skip
"""Names and categories of labels that exports have trouble with."""
INSTANCES = 300
FIRST = 1
"""Number in the name of the first file: frames do not count from it."""
OBJECTS = INSTANCES + len(HOSTILE)
OWNER = np.repeat(np.arange(OBJECTS + 1), 6)
"""Object of each point, 0 for scenery."""
SPACING = 3.0
"""Metres between the objects' centres, which are half a metre wide: boxes do not overlap."""


@pytest.fixture(scope="module")
def copies(tmp_path_factory: pytest.TempPathFactory) -> Callable[[], Path]:
    """Make workspaces that hold one recording of two frames, without labels."""
    rng = np.random.default_rng(0)
    side = int(np.ceil(np.sqrt(OBJECTS + 1)))
    middle = np.column_stack([OWNER % side, OWNER // side, np.zeros(len(OWNER))]) * SPACING
    xyz = (middle + rng.uniform(-0.25, 0.25, (len(OWNER), 3))).astype(np.float32)
    source, made = (tmp_path_factory.mktemp(name) for name in ("source", "made"))
    for step in range(2):
        np.save(source / f"{FIRST + step:06d}.npy", xyz + np.float32([0, 0, step]))
    with closing(Workspace(Settings(workspace=made))) as workspace:
        done = workspace.runner.wait(workspace.imports.begin([source], name="scan").id, 120)
        assert done.state == "done", done.error

    def copy() -> Path:
        place = tmp_path_factory.mktemp("copy") / "workspace"
        shutil.copytree(made, place)
        return place

    return copy


def painted(workspace: Workspace) -> None:
    """Label the objects of both frames, 300 instances of a category too, and delete some points."""
    workspace.labels.taxonomy.put([Category(60_000, "unlabeled", datasets={"semantickitti": 0})])
    wanted = HOSTILE + [(f"pin {number}", "pin") for number in range(1, INSTANCES + 1)]
    labels = [
        Label(number, name, category, default_color(number))
        for number, (name, category) in enumerate(wanted, start=1)
    ]
    workspace.labels.apply(
        "scan",
        edit_id=str(uuid4()),
        author="ann",
        kind="label",
        writes=lambda _: (labels, ()),
        summary="",
    )
    ids = [label.id for label in labels]
    label = np.array([0, *ids, *[0] * (OBJECTS - len(ids))], np.uint16)[OWNER]
    for frame in range(2):
        workspace.annotations.put("scan", frame, label, author="ann")
    workspace.labels.update_label("scan", "ann", ids[0], locked=True)
    workspace.labels.update_label("scan", "ann", ids[2], visible=False)
    deleted = np.zeros(len(OWNER), np.bool_)
    deleted[[0, 7, 11]] = True
    workspace.annotations.put("scan", 1, deleted, layer="deleted", author="ann")


Told = tuple[str, str]


def told(workspace: Workspace, frame: int) -> Iterator[tuple[Told, frozenset[int]]]:
    """Name and category of each label of a frame, with its points that are not deleted."""
    label = workspace.annotations.read("scan", frame)[0]
    alive = ~workspace.annotations.read("scan", frame, "deleted")[0]
    palette = {each.id: (each.name, each.category) for each in workspace.labels.palette("scan")}
    for number in np.unique(label[label > 0]).tolist():
        yield palette[number], frozenset(np.flatnonzero((label == number) & alive).tolist())


def by_category(found: Iterable[tuple[Told, frozenset[int]]]) -> set[frozenset[int]]:
    """Points of each category, or label without one."""
    points: dict[str, frozenset[int]] = {}
    for (name, category), of_label in found:
        points[category or name] = points.get(category or name, frozenset()) | of_label
    return set(points.values())


@pytest.mark.parametrize(
    "kind", sorted(k for k, made in EXPORTS.items() if not (made.whole_boxes or made.pictures))
)
def test_an_export_comes_back_into_a_copy(copies: Callable[[], Path], kind: str) -> None:
    one = copies()
    with closing(Workspace(Settings(workspace=one))) as workspace:
        painted(workspace)
        workspace.export("scan", kind, one / "out")
        before = [sorted(told(workspace, frame), key=repr) for frame in range(2)]
    with closing(Workspace(Settings(workspace=copies()))) as again:
        job = again.imports.begin_labels("scan", one / "out", "bob")
        done = again.runner.wait(job.id, 120)
        assert done.state == "done", done.error
        after = [sorted(told(again, frame), key=repr) for frame in range(2)]
    if kind == "openpcdet":  # boxes of classes, whose names are one word
        assert list(map(by_category, after)) == list(map(by_category, before))
    else:
        assert after == before
