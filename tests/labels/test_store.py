from __future__ import annotations

import threading
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

import numpy as np
import pytest
from waiting import eventually

from pointbrush.errors import (
    BadInputError,
    ConflictError,
    LockedLabelError,
    NotFoundError,
)
from pointbrush.labels import Commit, GapError, Label, Write
from pointbrush.labels.classes.palette import Palette
from pointbrush.teamwork.store import WorkspaceStore

SEQ = "juggling"
N = 150_000


def paint(
    store: WorkspaceStore,
    indices: Sequence[int] | np.ndarray[Any, Any],
    label: int = 1,
    author: str = "ann",
    frame: int = 0,
    edit_id: str | None = None,
    **rules: Any,
) -> Commit:
    write = Write(np.asarray(indices), label=label, provenance=1, **rules)
    return store.apply(
        SEQ, edit_id=edit_id, author=author, kind="paint", writes={frame: write}, summary="paint"
    )


def labels_at(store: WorkspaceStore, indices: Sequence[int], frame: int = 0) -> list[int]:
    return store.values(SEQ, frame).label[list(indices)].tolist()


@pytest.fixture
def pins(store: WorkspaceStore) -> WorkspaceStore:
    """Labels 1, 2 and 3."""
    for name in ("pin 1", "pin 2", "pin 3"):
        store.create_label(SEQ, "setup", name=name, category="pin")
    return store


def test_a_stroke_changes_its_points_and_says_so(pins: WorkspaceStore) -> None:
    touched = [5, 6, 70_000, N - 1]
    commit = paint(pins, touched, label=2)
    assert (commit.changed, commit.repeated) == (4, False)
    delta = commit.frames[0]
    assert delta.indices.tolist() == touched
    assert delta.label.tolist() == [2] * 4
    assert delta.provenance.tolist() == [1] * 4
    values = pins.values(SEQ, 0)
    assert np.flatnonzero(values.label).tolist() == touched
    assert values.revision == commit.revision == pins.revision(SEQ) == 4
    assert pins.counts(SEQ) == {(0, 2): (4, 4)}
    assert [(c.frame, c.label, c.points, c.painted) for c in commit.cells] == [(0, 2, 4, 4)]


def test_values_of_a_part_of_a_frame(pins: WorkspaceStore) -> None:
    paint(pins, [65_535, 65_536, 131_072])
    part = pins.values(SEQ, 0, 65_535, 3)
    assert part.label.tolist() == [1, 1, 0]
    assert pins.values(SEQ, 0, 131_070, 10**9).label.tolist()[:4] == [0, 0, 1, 0]
    assert len(pins.values(SEQ, 0, N, 5).label) == 0
    assert len(pins.values(SEQ, 3).label) == 0


def test_the_same_edit_twice_applies_once(pins: WorkspaceStore) -> None:
    first = paint(pins, [1, 2, 3], edit_id="a")
    paint(pins, [2], label=2, author="bob")
    again = paint(pins, [1, 2, 3], edit_id="a")
    assert again.repeated
    assert (again.revision, again.changed) == (first.revision, first.changed)
    assert labels_at(pins, [1, 2, 3]) == [1, 2, 1]
    found = pins.find(SEQ, "a")
    assert found is not None
    assert found.revision == first.revision
    assert pins.find(SEQ, "b") is None


def test_locked_labels_keep_their_points_and_take_no_new_ones(pins: WorkspaceStore) -> None:
    paint(pins, [1, 2], label=1)
    pins.update_label(SEQ, "ann", 1, locked=True)
    assert paint(pins, [1, 2, 3], label=2).changed == 1
    assert paint(pins, [1, 2], label=0).changed == 0
    gone = Write(np.array([1, 9]), deleted=True)
    commit = pins.apply(
        SEQ, edit_id=None, author="ann", kind="delete", writes={0: gone}, summary=""
    )
    assert commit.changed == 1
    with pytest.raises(LockedLabelError, match="pin 1"):
        paint(pins, [5], label=1)
    with pytest.raises(LockedLabelError):
        pins.require_paintable(SEQ, 1)
    with pytest.raises(LockedLabelError):
        pins.delete_label(SEQ, "ann", 1)
    mixed = Write(np.array([1, 4]), label=np.array([1, 1], np.uint16))
    with pytest.raises(LockedLabelError):
        pins.apply(SEQ, edit_id=None, author="ann", kind="import", writes={0: mixed}, summary="")
    keeps = Write(np.array([1, 4]), label=np.array([1, 2], np.uint16))
    commit = pins.apply(
        SEQ, edit_id=None, author="ann", kind="import", writes={0: keeps}, summary=""
    )
    assert commit.changed == 1


def test_undo_never_changes_points_of_a_locked_label(pins: WorkspaceStore) -> None:
    paint(pins, [1, 2], label=1)
    pins.update_label(SEQ, "bob", 1, locked=True)
    revision = pins.revision(SEQ)
    with pytest.raises(LockedLabelError):
        pins.undo(SEQ, "ann")
    assert pins.revision(SEQ) == revision
    pins.update_label(SEQ, "bob", 1, locked=False)
    assert pins.undo(SEQ, "ann").changed == 2


def test_rules_look_at_the_state_of_the_commit(pins: WorkspaceStore) -> None:
    paint(pins, [1], label=1)
    tracked = Write(np.array([1, 2, 3]), label=2, provenance=2, only="not_painted")
    commit = pins.apply(
        SEQ, edit_id=None, author="run", kind="tracking", writes={0: tracked}, summary=""
    )
    assert commit.changed == 2
    assert labels_at(pins, [1, 2, 3]) == [1, 2, 2]
    assert paint(pins, [2, 3, 4], label=3, only="unlabeled").changed == 1
    assert pins.counts(SEQ) == {(0, 1): (1, 1), (0, 2): (2, 0), (0, 3): (1, 1)}


def test_deleted_points_do_not_count_and_come_back(pins: WorkspaceStore) -> None:
    paint(pins, [1, 2, 3])
    gone = Write(np.array([2, 3, 4]), deleted=True)
    commit = pins.apply(
        SEQ, edit_id=None, author="bob", kind="delete", writes={0: gone}, summary=""
    )
    assert commit.frames[0].label.tolist() == [1, 1, 0]
    assert commit.frames[0].deleted.all()
    assert pins.counts(SEQ) == {(0, 1): (1, 1)}
    pins.undo(SEQ, "ann")
    values = pins.values(SEQ, 0)
    assert not values.label.any()
    assert np.flatnonzero(values.deleted).tolist() == [2, 3, 4]
    pins.redo(SEQ, "ann")
    pins.undo(SEQ, "bob")
    assert pins.counts(SEQ) == {(0, 1): (3, 3)}
    assert not pins.values(SEQ, 0).deleted.any()


def test_bad_input_changes_nothing(pins: WorkspaceStore) -> None:
    revision = pins.revision(SEQ)
    for bad in (
        Write(np.array([2, 1]), label=1),
        Write(np.array([1, 1]), label=1),
        Write(np.array([-1]), label=1),
        Write(np.array([N]), label=1),
        Write(np.array([0.5]), label=1),
        Write(np.array([[1]]), label=1),
        Write(np.array([1]), label=70_000),
        Write(np.array([1]), label=1.5),
        Write(np.array([1]), label=np.array([1, 2])),
        Write(np.array([1]), provenance=5),
        Write(np.array([1]), label=1, only="some"),  # type: ignore[arg-type]
    ):
        with pytest.raises(BadInputError, match="expected"):
            pins.apply(SEQ, edit_id=None, author="a", kind="k", writes={0: bad}, summary="")
    for unknown in (Write(np.array([1]), label=9), Write(np.array([1]), label=np.array([9]))):
        with pytest.raises(NotFoundError):
            pins.apply(SEQ, edit_id=None, author="a", kind="k", writes={0: unknown}, summary="")
    with pytest.raises(NotFoundError):
        paint(pins, [1], frame=4)
    with pytest.raises(NotFoundError):
        pins.values(SEQ, -1)
    with pytest.raises(NotFoundError):
        pins.values("nothing", 0)
    with pytest.raises(BadInputError):
        paint(pins, [1], author="")
    late = (0, revision + 1)
    with pytest.raises(ConflictError, match="expected at most"):
        pins.apply(SEQ, edit_id=None, author="a", kind="k", writes={}, summary="", if_match=late)
    for nan in ({"frame": 0, "label": 1, "rmse": float("nan")}, {"label": 1}):
        with pytest.raises(BadInputError):
            pins.apply(SEQ, edit_id=None, author="a", kind="k", writes={}, summary="", tracks=[nan])
    assert pins.revision(SEQ) == revision
    assert not pins.values(SEQ, 0).label.any()


def test_an_edit_is_whole_or_not_at_all(pins: WorkspaceStore) -> None:
    pins.update_label(SEQ, "ann", 2, locked=True)
    writes = [(0, Write(np.arange(100), label=1)), (1, Write(np.arange(100), label=2))]
    with pytest.raises(LockedLabelError):
        pins.apply(SEQ, edit_id="w", author="a", kind="k", writes=writes, summary="")
    assert not pins.values(SEQ, 0).label.any()
    assert pins.counts(SEQ) == {}
    assert pins.find(SEQ, "w") is None


def test_later_writes_of_one_edit_win(pins: WorkspaceStore) -> None:
    writes = [
        (0, Write(np.arange(0, 10), label=1, provenance=1)),
        (0, Write(np.arange(5, 15), label=2, provenance=2)),
    ]
    commit = pins.apply(SEQ, edit_id=None, author="ann", kind="k", writes=writes, summary="")
    assert commit.changed == 15
    assert labels_at(pins, range(16)) == [1] * 5 + [2] * 10 + [0]
    pins.undo(SEQ, "ann")
    assert not pins.values(SEQ, 0).label.any()
    pins.redo(SEQ, "ann")
    assert labels_at(pins, range(16)) == [1] * 5 + [2] * 10 + [0]


def test_labels_of_an_import_are_part_of_its_edit(store: WorkspaceStore) -> None:
    commit = store.apply(
        SEQ,
        edit_id=None,
        author="ann",
        kind="import",
        writes=lambda palette: (
            [Label(palette.free_ids().take(("road", "ground"), 40), "road", "ground", "#ff00ff")],
            {1: Write(np.arange(5), label=40, provenance=3)},
        ),
        summary="",
    )
    assert commit.palette_changed
    assert store.counts(SEQ) == {(1, 40): (5, 0)}
    store.undo(SEQ, "ann")
    assert store.palette(SEQ) == []
    assert store.counts(SEQ) == {}
    store.redo(SEQ, "ann")
    assert [label.name for label in store.palette(SEQ)] == ["road"]
    assert store.counts(SEQ) == {(1, 40): (5, 0)}
    assert store.create_label(SEQ, "ann", name="x").id == 41


def test_a_label_id_keeps_its_meaning_over_undo_and_redo(store: WorkspaceStore) -> None:
    def add(author: str, name: str, points: range) -> None:
        def choose(palette: Palette) -> tuple[list[Label], dict[int, Write]]:
            number = palette.free_ids().take((name, ""), 40)
            write = Write(np.array(points), label=number, provenance=3)
            return [Label(number, name)], {0: write}

        store.apply(SEQ, edit_id=None, author=author, kind="import", writes=choose, summary="")

    def names(points: range) -> list[str]:
        called = {label.id: label.name for label in store.palette(SEQ)}
        return [called[number] for number in labels_at(store, points)]

    add("ann", "road", range(0, 10))
    store.undo(SEQ, "ann")
    add("bob", "building", range(5, 15))
    store.redo(SEQ, "ann")
    assert names(range(15)) == ["road"] * 5 + ["building"] * 10
    store.undo(SEQ, "ann")
    add("ann", "road", range(0, 10))
    assert {label.id: label.name for label in store.palette(SEQ)} == {40: "road", 41: "building"}


def test_a_distinct_label_has_a_name_and_a_colour_of_its_own(store: WorkspaceStore) -> None:
    for _ in range(3):
        store.create_label(SEQ, "ann", name="pin 1", color="#ff5d5d", distinct=True)
    store.create_label(SEQ, "bob", name="Pin 2", color="#FF5D5D", distinct=True)
    store.create_label(SEQ, "bob", name="pin 1", color="#ff5d5d")
    *distinct, asked = store.palette(SEQ)
    assert [label.name for label in distinct] == ["pin 1", "pin 2", "pin 3", "Pin 4"]
    assert len({label.color for label in distinct}) == 4
    assert (asked.name, asked.color) == ("pin 1", "#ff5d5d")


def test_since_brings_a_stale_copy_up_to_date(pins: WorkspaceStore) -> None:
    rng = np.random.default_rng(7)
    copies: dict[int, np.ndarray[Any, Any]] = {0: pins.values(SEQ, 0).label}
    for step in range(12):
        points = np.unique(rng.integers(0, N, 400))
        paint(pins, points, label=1 + step % 3, author="ann" if step % 2 else "bob")
        copies[pins.revision(SEQ)] = pins.values(SEQ, 0).label
        if step % 4 == 3:
            pins.undo(SEQ, "ann")
    pins.delete_label(SEQ, "bob", 2)
    now = pins.values(SEQ, 0).label
    for revision, copy in copies.items():
        for commit in pins.since(SEQ, revision):
            for delta in commit.frames.values():
                copy[delta.indices] = delta.label
        assert (copy == now).all()
    with pytest.raises(GapError):
        pins.since(SEQ, pins.revision(SEQ) + 1)


def test_subscribers_hear_each_commit_once_and_in_order(pins: WorkspaceStore) -> None:
    heard: list[Commit] = []
    unsubscribe = pins.subscribe(heard.append)
    first = pins.revision(SEQ) + 1

    def work(author: str) -> None:
        for number in range(10):
            paint(pins, [number], author=author, label=1 + number % 3)

    threads = [threading.Thread(target=work, args=(f"a{n}",)) for n in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    eventually(lambda: len(heard) >= 40)
    unsubscribe()
    paint(pins, [99])
    assert [commit.revision for commit in heard] == list(range(first, first + 40))


def test_a_failing_subscriber_fails_nobody(pins: WorkspaceStore) -> None:
    heard: list[Commit] = []

    def fail(_: Commit) -> None:
        raise RuntimeError("broken page")

    pins.subscribe(fail)
    pins.subscribe(heard.append)
    assert paint(pins, [1]).changed == 1
    eventually(lambda: len(heard) == 1)


def test_the_history_tells_who_what_and_where(pins: WorkspaceStore) -> None:
    paint(pins, [1, 2], edit_id="mine")
    paint(pins, [3], author="bob", frame=1)
    pins.undo(SEQ, "ann")
    lines = pins.edits(SEQ, limit=3)
    assert [(e.author, e.kind, e.points, e.frames, e.undone) for e in lines] == [
        ("ann", "undo", 2, (0,), False),
        ("bob", "paint", 1, (1,), False),
        ("ann", "paint", 2, (0,), True),
    ]
    assert lines[0].target == "mine"
    assert lines[0].time >= lines[1].time > datetime(2020, 9, 13, tzinfo=UTC)
    older = pins.edits(SEQ, before=lines[-1].revision)
    assert [e.summary for e in older] == [
        "create label 'pin 3'", "create label 'pin 2'", "create label 'pin 1'",
    ]  # fmt: skip
    undoable, redoable = pins.stacks(SEQ, "ann")
    assert undoable is None
    assert redoable is not None
    assert redoable.id == "mine"


def test_tracks_are_part_of_their_edit(pins: WorkspaceStore) -> None:
    def run(confidence: float, frames: range) -> None:
        tracks = [{"frame": f, "label": 1, "confidence": confidence, "pose": [1.0]} for f in frames]
        pins.apply(
            SEQ, edit_id=None, author="ann", kind="tracking", writes={}, summary="", tracks=tracks
        )

    def seen() -> list[tuple[int, float]]:
        return [(track["frame"], track["confidence"]) for track in pins.tracks(SEQ)]

    run(0.5, range(3))
    run(0.9, range(1, 4))
    newer = [(0, 0.5), (1, 0.9), (2, 0.9), (3, 0.9)]
    assert seen() == newer
    assert pins.undo(SEQ, "ann").tracks_changed
    assert seen() == [(0, 0.5), (1, 0.5), (2, 0.5)]
    pins.undo(SEQ, "ann")
    assert seen() == []
    pins.redo(SEQ, "ann")
    pins.redo(SEQ, "ann")
    assert seen() == newer
    pins.delete_label(SEQ, "ann", 1)
    assert seen() == []
    pins.undo(SEQ, "ann")
    assert seen() == newer


def test_reopening_gives_everything_back(url: str, pins: WorkspaceStore) -> None:
    rng = np.random.default_rng(1)
    for step in range(150):  # past a snapshot of the blocks
        paint(pins, np.unique(rng.integers(0, N, 50)), label=1 + step % 3)
    pins.undo(SEQ, "ann")
    before = pins.values(SEQ, 0)
    other = WorkspaceStore(url)
    after = other.values(SEQ, 0)
    assert (before.label == after.label).all()
    assert (before.provenance == after.provenance).all()
    assert other.counts(SEQ) == pins.counts(SEQ)
    assert other.palette(SEQ) == pins.palette(SEQ)
    assert other.redo(SEQ, "ann").changed > 0
    for _ in range(150):
        other.undo(SEQ, "ann")
    assert not other.values(SEQ, 0).label.any()
    with pytest.raises(ConflictError):
        other.undo(SEQ, "ann")
    other.close()


def test_forgetting_a_sequence(pins: WorkspaceStore) -> None:
    paint(pins, [1])
    pins.recordings.register(SEQ, [N, 70_000, 10, 0])
    with pytest.raises(ConflictError):
        pins.recordings.register(SEQ, [1])
    pins.recordings.forget(SEQ)
    pins.recordings.forget(SEQ)
    with pytest.raises(NotFoundError):
        pins.revision(SEQ)
    pins.recordings.register(SEQ, [5])
    assert pins.revision(SEQ) == 0
    assert pins.palette(SEQ) == []
    assert not pins.values(SEQ, 0).label.any()


def test_urls_that_are_no_database() -> None:
    for bad in ("nonsense", "sqlite://", "mysql://host/name"):
        with pytest.raises(BadInputError, match="expected"):
            WorkspaceStore(bad)
