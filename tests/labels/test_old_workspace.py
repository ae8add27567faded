"""A workspace of the first version opens with everything in it, on both databases."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.old_workspace import EXPECTED, make_older, old_workspace


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
