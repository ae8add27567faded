"""One edit of most of a large frame: in little memory, told without listing its points."""

from __future__ import annotations

import tracemalloc
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from waiting import eventually

from pointbrush.labels import GapError, Write
from pointbrush.labels import draft as packed_changes
from pointbrush.labels import effect as effects
from pointbrush.labels.packing import BLOCK
from pointbrush.teamwork.store import WorkspaceStore

BLOCKS = 24
POINTS = BLOCKS * BLOCK + 1_000
PIECE = 4 * BLOCK


@pytest.fixture
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[WorkspaceStore]:
    monkeypatch.setattr(packed_changes, "OPEN_POINTS", 3 * BLOCK)
    monkeypatch.setattr(effects, "LISTED_POINTS", 2 * BLOCK)
    url = f"sqlite:///{tmp_path / 'labels.sqlite'}"
    with closing(WorkspaceStore(url, cache_bytes=8 << 20)) as opened:
        opened.recordings.register("scan", [POINTS])
        for name in ("a", "b", "c"):
            opened.create_label("scan", "setup", name=name)
        yield opened


def wanted(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 4, POINTS).astype(np.uint16)


def put(store: WorkspaceStore, label: np.ndarray, **fields: str) -> int:
    def pieces() -> Iterator[tuple[int, Write]]:
        for first in range(0, POINTS, PIECE):
            part = label[first : first + PIECE]
            yield 0, Write(np.arange(first, first + len(part)), label=part, provenance=3)

    return store.apply(
        "scan", edit_id=fields.get("edit_id"), author="me", kind="import", writes=pieces(),
        summary="all of it",
    ).changed  # fmt: skip


def shown(store: WorkspaceStore) -> np.ndarray:
    return store.values("scan", 0).label


def test_it_is_stored_undone_and_redone_like_a_small_one(store: WorkspaceStore) -> None:
    first, second = wanted(1), wanted(2)
    assert put(store, first) == POINTS
    put(store, second)
    np.testing.assert_array_equal(shown(store), second)
    assert store.counts("scan")[0, 2][0] == np.count_nonzero(second == 2)
    store.undo("scan", "me")
    np.testing.assert_array_equal(shown(store), first)
    store.undo("scan", "me")
    assert not shown(store).any()
    store.redo("scan", "me")
    store.redo("scan", "me")
    np.testing.assert_array_equal(shown(store), second)
    store.delete_label("scan", "me", 2)
    np.testing.assert_array_equal(shown(store), np.where(second == 2, 0, second))
    assert store.check("scan") == []


def test_who_listens_is_told_to_read_the_frame_whole(store: WorkspaceStore) -> None:
    heard = []
    store.subscribe(heard.append)
    put(store, wanted(3), edit_id="e")
    eventually(lambda: heard)
    again = store.apply(
        "scan", edit_id="e", author="me", kind="import", writes={}, summary="sent twice"
    )
    for commit in (heard[-1], again):
        assert dict(commit.frames) == {0: None}
        assert commit.changed == POINTS
        assert {cell.label: cell.points for cell in commit.cells if cell.label} == {
            label: int(np.count_nonzero(wanted(3) == label)) for label in (1, 2, 3)
        }
    few = store.apply(
        "scan", edit_id=None, author="me", kind="paint", summary="",
        writes={0: Write(np.array([5, POINTS - 1]), deleted=True)},
    )  # fmt: skip
    delta = few.frames[0]
    assert delta is not None
    assert delta.indices.tolist() == [5, POINTS - 1]
    assert next(iter(store.since("scan", 3))).frames == {0: None}


def test_it_takes_the_memory_of_a_few_blocks(store: WorkspaceStore) -> None:
    label = wanted(4)
    put(store, wanted(5))
    tracemalloc.start()
    try:
        put(store, label)
        store.undo("scan", "me")
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    # Unpacked, the changes alone are 24 bytes a point, and as much again on the way.
    assert most < 20 * POINTS


def test_gaps_are_still_gaps(store: WorkspaceStore) -> None:
    with pytest.raises(GapError):
        store.since("scan", 99)
