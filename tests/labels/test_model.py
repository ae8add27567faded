"""Random interleavings of several people's edits, against a model that only replays."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from waiting import eventually

from pointbrush.errors import PointbrushError
from pointbrush.labels import Commit, Write, writer
from pointbrush.teamwork.store import WorkspaceStore
from tests.labels.label_model import Model
from tests.labels.random_edits import box_at, boxes_of, place_at

# Points on both sides of the border between two blocks.
PLACES = [0, 1, 2, 3, 65_534, 65_535, 65_536, 65_537]
SIZE = 65_540
FRAMES = 2
AUTHORS = ["ann", "bob", "cat"]

author = st.sampled_from(AUTHORS)
label = st.integers(1, 4)
frame = st.integers(0, FRAMES - 1)
place = st.sampled_from([0.0, 1.0, 2.0])
points = st.lists(
    st.tuples(st.integers(0, FRAMES - 1), st.sampled_from(PLACES)), unique=True, max_size=8
)
OPERATIONS = st.one_of(
    st.tuples(
        st.just("write"),
        author,
        points,
        st.none() | st.integers(0, 4),
        st.none() | st.integers(0, 3),
        st.sampled_from([None, None, None, True, False]),
        st.sampled_from(["any", "any", "labeled", "unlabeled", "not_painted"]),
        st.sampled_from([None, None, True, False]),
        st.none() | st.frozensets(st.integers(0, 4), max_size=2),
        st.sets(st.tuples(st.integers(0, FRAMES - 1), label), max_size=2),
    ),
    st.tuples(st.just("paint"), author, points, st.integers(0, 4)),
    st.tuples(st.just("undo"), author),
    st.tuples(st.just("undo"), author),
    st.tuples(st.just("redo"), author),
    st.tuples(st.just("create"), author, st.none() | label),
    st.tuples(st.just("change"), author, label, st.sampled_from(["x", "y"]), st.none()),
    st.tuples(st.just("change"), author, label, st.none(), st.booleans()),
    st.tuples(st.just("show"), author, label, st.booleans()),
    st.tuples(st.just("delete"), author, label),
    st.tuples(st.just("add_box"), author, label, frame, place),
    st.tuples(st.just("move_box"), author, label, frame, place),
    st.tuples(st.just("move_box"), author, label, frame, place),
    st.tuples(st.just("remove_box"), author, label),
)


class Pair:
    """The store, through two connections to it as of two servers, and the model."""

    def __init__(self, stores: list[WorkspaceStore], sequence: str) -> None:
        self.stores, self.sequence, self.model = stores, sequence, Model()
        stores[0].recordings.register(sequence, [SIZE] * FRAMES)
        self.copies = [np.zeros((FRAMES, SIZE, 3), np.int64) for _ in stores]
        self.boxes: list[dict[int, Any]] = [{} for _ in stores]
        self.heard: list[list[int]] = [[] for _ in stores]
        self.changed = [0] * FRAMES
        """The revision of each frame's last change."""

    def run(self, which: int, operation: tuple[Any, ...]) -> None:
        name, who, *rest = operation
        before = self.model.visible()
        expected, got = (
            _outcome(lambda: getattr(self, f"model_{name}")(who, *rest)),
            _outcome(lambda: getattr(self, f"store_{name}")(self.stores[which], who, *rest)),
        )
        assert got == expected, operation
        after = self.model.visible()
        for frame in {place[0] for place, _ in before.items() ^ after.items()}:
            self.changed[frame] = self.stores[which].revision(self.sequence)

    def model_write(self, who: str, where: Any, *rest: Any) -> None:
        *values, hidden, tracks = rest
        marked = dict.fromkeys(sorted(tracks), who)
        self.model.write(who, where, *values, tracks=marked, hidden=hidden)

    def model_paint(self, who: str, where: Any, number: int) -> None:
        self.model.write(who, where, number, 1, None)

    def model_undo(self, who: str) -> None:
        self.model.undo(who)

    def model_redo(self, who: str) -> None:
        self.model.redo(who)

    def model_create(self, who: str, number: int | None) -> None:
        self.model.create(who, "new", number)

    def model_change(self, who: str, number: int, name: str | None, locked: bool | None) -> None:
        given = {"name": name, "locked": locked}
        self.model.change(who, number, **{k: v for k, v in given.items() if v is not None})

    def model_show(self, who: str, number: int, visible: bool) -> None:
        self.model.change(who, number, visible=visible)

    def model_delete(self, who: str, number: int) -> None:
        self.model.delete(who, number)

    def model_add_box(self, who: str, number: int, frame: int, x: float) -> None:
        self.model.add_box(who, number, frame, x)

    def model_move_box(self, who: str, box: int, frame: int, x: float) -> None:
        self.model.move_box(who, box, frame, x)

    def model_remove_box(self, who: str, box: int) -> None:
        self.model.remove_box(who, box)

    def store_add_box(
        self, store: WorkspaceStore, who: str, number: int, frame: int, x: float
    ) -> None:
        store.boxes.add(self.sequence, who, box_at(number, frame, x))

    def store_move_box(
        self, store: WorkspaceStore, who: str, box: int, frame: int, x: float
    ) -> None:
        store.boxes.change(self.sequence, who, box, {"poses": {str(frame): place_at(x)}})

    def store_remove_box(self, store: WorkspaceStore, who: str, box: int) -> None:
        store.boxes.remove(self.sequence, who, box)

    def told_of_boxes(self, which: int) -> bool:
        """Whether the boxes that were told of, and read then, are all that changed."""
        heard = set()
        while self.heard[which]:
            heard.add(self.heard[which].pop())
        now = boxes_of(self.stores[which], self.sequence)
        copy = {box: state for box, state in self.boxes[which].items() if box not in heard}
        self.boxes[which] = copy | {box: now[box] for box in heard & now.keys()}
        return self.boxes[which] == now == self.model.boxes()

    def store_write(self, store: WorkspaceStore, who: str, where: Any, *rest: Any) -> None:
        number, provenance, deleted, only, living, hidden, tracks = rest
        writes = [
            (
                frame,
                Write(
                    np.array(sorted(p for f, p in where if f == frame), np.int64),
                    number,
                    provenance,
                    deleted,
                    only,
                    living,
                    hidden,
                ),
            )
            for frame in range(FRAMES)
        ]
        store.apply(
            self.sequence,
            edit_id=None,
            author=who,
            kind="paint",
            writes=writes,
            summary="",
            tracks=[{"frame": f, "label": n, "by": who} for f, n in sorted(tracks)],
        )

    def store_paint(self, store: WorkspaceStore, who: str, where: Any, number: int) -> None:
        self.store_write(store, who, where, number, 1, None, "any", None, None, ())

    def store_undo(self, store: WorkspaceStore, who: str) -> None:
        store.undo(self.sequence, who)

    def store_redo(self, store: WorkspaceStore, who: str) -> None:
        store.redo(self.sequence, who)

    def store_create(self, store: WorkspaceStore, who: str, number: int | None) -> None:
        store.create_label(self.sequence, who, name="new", id=number)

    def store_change(
        self, store: WorkspaceStore, who: str, number: int, name: str | None, locked: bool | None
    ) -> None:
        store.update_label(self.sequence, who, number, name=name, locked=locked)

    def store_show(self, store: WorkspaceStore, who: str, number: int, visible: bool) -> None:
        store.update_label(self.sequence, who, number, visible=visible)

    def store_delete(self, store: WorkspaceStore, who: str, number: int) -> None:
        store.delete_label(self.sequence, who, number)

    def compare(self) -> None:
        palette = self.model.palette()
        for which, (store, copy) in enumerate(zip(self.stores, self.copies, strict=True)):
            eventually(lambda which=which: self.told_of_boxes(which))
            seen = np.stack([self._values(store, frame) for frame in range(FRAMES)])
            found = {
                (frame, point): (seen[frame, point, 0], seen[frame, point, 1], bool(flag))
                for frame, point in itertools.product(range(FRAMES), PLACES)
                for flag in [seen[frame, point, 2]]
                if seen[frame, point].any()
            }
            assert found == self.model.visible()
            assert int(np.count_nonzero(seen.any(axis=2))) == len(found)
            # The deltas add up to the state; the store's own thread may still be telling of them.
            eventually(lambda copy=copy, seen=seen: bool((copy == seen).all()))
            shown = {
                one.id: (one.name, one.locked, one.visible) for one in store.palette(self.sequence)
            }
            fields = ("name", "locked", "visible")
            assert shown == {n: tuple(f[name] for name in fields) for n, f in palette.items()}
            assert store.counts(self.sequence) == self.model.counts()
            changed = [store.values(self.sequence, frame).changed for frame in range(FRAMES)]
            assert changed == self.changed
            tracks = {(t["frame"], t["label"]): t["by"] for t in store.tracks(self.sequence)}
            assert tracks == self.model.tracks()

    def _values(self, store: WorkspaceStore, frame: int) -> np.ndarray[Any, Any]:
        values = store.values(self.sequence, frame)
        return np.stack([values.label, values.provenance, values.deleted], axis=1).astype(np.int64)

    def hear(self, which: int) -> Callable[[Commit], None]:
        def heard(commit: Commit) -> None:
            if commit.sequence != self.sequence:
                return
            self.heard[which].extend(commit.boxes)
            for frame, delta in commit.frames.items():
                values = np.stack([delta.label, delta.provenance, delta.deleted], axis=1)
                self.copies[which][frame][delta.indices] = values

        return heard


def _outcome(work: Callable[[], object]) -> type[Exception] | None:
    try:
        work()
    except PointbrushError as error:
        return type(error)
    return None


@pytest.fixture
def stores(url: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[WorkspaceStore]]:
    # Snapshots all the time, and one of the two can keep but a single block in memory.
    monkeypatch.setattr(writer, "SNAPSHOT_EVERY", 3)
    opened = [WorkspaceStore(url), WorkspaceStore(url, cache_bytes=1)]
    yield opened
    for store in opened:
        store.close()


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(st.lists(st.tuples(st.integers(0, 1), OPERATIONS), min_size=4, max_size=40))
def test_any_interleaving_is_a_replay_without_what_was_undone(
    stores: list[WorkspaceStore], operations: list[tuple[int, tuple[Any, ...]]]
) -> None:
    pair = Pair(stores, f"s{next(NUMBERS)}")
    unsubscribe = [store.subscribe(pair.hear(n)) for n, store in enumerate(stores)]
    for name in ("one", "two", "three"):
        pair.model.create("ann", name, None)
        stores[0].create_label(pair.sequence, "ann", name=name)
    for step, (which, operation) in enumerate(operations):
        pair.run(which, operation)
        if step % 5 == 4:
            pair.compare()
    pair.compare()
    assert stores[0].check(pair.sequence) == []
    for stop in unsubscribe:
        stop()


NUMBERS = itertools.count()
