"""A workspace of schema 0010 opens with everything in it, on both databases."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from sqlalchemy import text

from pointbrush.database.database import Database
from pointbrush.formats.tables.datasets import SEMANTIC_KITTI
from pointbrush.formats.tables.numbering import KITTI_NUMBERS
from pointbrush.labels import Category
from pointbrush.sequences.storage.manifest import VERSION
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.old_workspace import EXPECTED, make_older, old_workspace

CATEGORY = "INSERT INTO categories (number, name, color) VALUES (:n, :name, :color)"
NUMBER = (
    "INSERT INTO dataset_numbers (dataset, category, number) VALUES ('semantickitti', :n, :there)"
)


@pytest.fixture(params=["sqlite", "postgresql"])
def settings(request: pytest.FixtureRequest, tmp_path: Path) -> Settings:
    postgres = request.param == "postgresql"
    url = str(request.getfixturevalue("postgres_url")) if postgres else ""
    return old_workspace(tmp_path, url)


@pytest.fixture
def old(settings: Settings) -> Iterator[Workspace]:
    with closing(Workspace(settings)) as workspace:
        yield workspace


def counted(labels: NDArray[np.uint16]) -> dict[str, int]:
    numbers, counts = np.unique(labels, return_counts=True)
    return {str(label): int(count) for label, count in zip(numbers, counts, strict=True)}


def told(workspace: Workspace, sequence: str) -> dict[str, Any]:
    store = workspace.labels
    manifest = workspace.recording(sequence).manifest
    values = [store.values(sequence, frame) for frame in range(manifest.frames)]
    return {
        "identity": manifest.identity,
        "points": list(manifest.points),
        "revision": store.revision(sequence),
        "palette": [
            [label.id, label.name, label.category, label.color, label.locked, label.visible]
            for label in store.palette(sequence)
        ],
        "annotation": [counted(v.label) for v in values],
        "deleted": [int(v.deleted.sum()) for v in values],
        "edits": [[e.revision, e.author, e.kind, e.summary] for e in store.edits(sequence)],
        "tracks": len(store.tracks(sequence)),
    }


def test_everything_is_there(old: Workspace) -> None:
    for sequence, expected in EXPECTED["sequences"].items():
        assert told(old, sequence) == expected
        assert old.listing.problems(sequence) == []
        # Imports of before left class names out, and have none after a change either.
        old.update_sequence(sequence, fps=5.0)
        assert old.recording(sequence).manifest.classes == []
    assert [entry.damaged for entry in old.listing.all()] == [None, None]
    valid = [old.labels.tokens.check(secret) is not None for secret in EXPECTED["secrets"].values()]
    assert valid.count(False) == 1


def test_undo_goes_on(old: Workspace) -> None:
    before = old.annotations.read("ball", 1)[0]
    author = next(edit.author for edit in old.labels.edits("ball") if edit.kind == "tracking")
    old.labels.undo("ball", author)
    assert not np.array_equal(old.annotations.read("ball", 1)[0], before)
    old.labels.redo("ball", author)
    np.testing.assert_array_equal(old.annotations.read("ball", 1)[0], before)


def test_labels_belong_to_their_import_from_then_on(old: Workspace) -> None:
    known = {row.id: row.identity for row in old.labels.recordings.live()}
    assert known == {name: told["identity"] for name, told in EXPECTED["sequences"].items()}


def test_a_workspace_of_the_version_before_opens_with_its_trash_and_tokens(
    settings: Settings,
) -> None:
    with closing(Workspace(settings)) as workspace:
        workspace.update_sequence("ball", fps=5.0)  # so that this version writes a manifest
        workspace.deletion.delete("hall")
        author = next(
            edit.author for edit in workspace.labels.edits("ball") if edit.kind == "tracking"
        )
        workspace.labels.undo("ball", author)
        before = told(workspace, "ball")
        secret = workspace.labels.tokens.add("annotator", "new", None)
    make_older(settings, "0011", 6, ("dataset", "palette"))
    with closing(Workspace(settings)) as workspace:
        assert told(workspace, "ball") == before
        assert [entry.labels_missing for entry in workspace.listing.all()] == [None]
        assert workspace.labels.tokens.check(secret) is not None
        workspace.labels.redo("ball", author)
        workspace.deletion.restore("hall")
        assert told(workspace, "hall") == EXPECTED["sequences"]["hall"]
        tracked = EXPECTED["sequences"]["ball"]["annotation"]
        assert told(workspace, "ball")["annotation"] == tracked
        assert [workspace.listing.problems(name) for name in EXPECTED["sequences"]] == [[], []]


def test_classes_of_before_keep_their_labels_and_free_official_numbers(settings: Settings) -> None:
    """Classes that the version before renamed, and numbers that it gave to the wrong ones."""
    words = ("car", "building", "scooter", "fence", "trunk", "Baum")
    with closing(Workspace(settings)) as workspace:
        store = workspace.labels
        for word in words:
            store.create_label("ball", "ann", name=f"a {word}", category=word)
        store.update_label("ball", "ann", store.palette("ball")[-1].id, color="#010203")
        store.create_label("ball", "ann", name="late", category="vehicle")
    make_older(settings, "0020", VERSION, ())
    rows = [
        # Imported, then renamed; its labels were counted as a class of their own after that.
        (10, "vehicle", "", 10), (65000, "car", "", 65000),
        (50, "building", "", 50), (51, "scooter", "", 51), (52, "fence", "", 65535),
        (70, "Baum", "#00ff00", 70), (71, "trunk", "", 71),
    ]  # fmt: skip
    with closing(Database(settings.database_url)) as database, database.write() as connection:
        for number, name, color, there in rows:
            values = {"n": number, "name": name, "color": color, "there": there}
            connection.execute(text(CATEGORY), values)
            connection.execute(text(NUMBER), values)
    with closing(Workspace(settings)) as workspace:
        store = workspace.labels
        categories = {label.name: label.category for label in store.palette("ball")}
        assert (categories["a car"], categories["late"]) == ("vehicle", "vehicle")
        numbers = store.taxonomy.exported(store.palette("ball"), KITTI_NUMBERS)
        there = numbers.datasets["semantickitti"]
        assert (there["vehicle"], there["building"], there["trunk"]) == (10, 50, 71)
        assert (there["fence"], there["Baum"]) == (65535, 70)  # given for ever
        assert there["scooter"] not in SEMANTIC_KITTI.classes
        assert numbers.own | {"scooter": 51, "vehicle": 10} == numbers.own
        store.undo("ball", "ann")
        store.undo("ball", "ann")
        vehicle = numbers.own["vehicle"]
        store.taxonomy.put([Category(vehicle, "Auto")])
        store.redo("ball", "ann")
        store.redo("ball", "ann")
        categories = {label.name: label.category for label in store.palette("ball")}
        assert (categories["a car"], categories["late"]) == ("Auto", "Auto")
        assert workspace.listing.problems("ball") == []


def test_a_class_of_the_first_version_is_renamed(old: Workspace) -> None:
    number = old.labels.taxonomy.numbers(["toy"])["toy"]
    old.labels.delete_label("ball", "ann", 1)
    old.labels.taxonomy.put([Category(number, "plaything")])
    old.labels.undo("ball", "ann")
    assert [label.category for label in old.labels.palette("ball")] == ["plaything", ""]
    assert old.labels.taxonomy.numbers(["plaything"]) == {"plaything": number}
