"""Two processes on one database: each sees the other's commits, in order, each once."""

from __future__ import annotations

import threading
import time
from contextlib import closing
from pathlib import Path

import numpy as np
import psycopg
import pytest
from waiting import eventually

from pointbrush.database.database import Limits
from pointbrush.errors import NotFoundError
from pointbrush.labels import Commit, Write
from pointbrush.labels import open_recordings as sessions
from pointbrush.teamwork.store import WorkspaceStore
from tests import forked

SEQ = "juggling"
POINTS = [70_000, 100]


def edit(url: str, author: str) -> None:
    """Paint 20 times at another process."""
    with closing(WorkspaceStore(url)) as store:
        for number in range(20):
            write = Write(np.arange(number, number + 5), label=1 + number % 2, provenance=1)
            store.apply(
                SEQ,
                edit_id=None,
                author=author,
                kind="paint",
                writes={number % 2: write},
                summary=f"{time.time()}",
            )


@pytest.fixture
def here(url: str, store: WorkspaceStore) -> WorkspaceStore:
    store.recordings.forget(SEQ)
    store.recordings.register(SEQ, POINTS)
    store.create_label(SEQ, "ann", name="one")
    store.create_label(SEQ, "ann", name="two")
    return store


def test_an_id_that_the_other_gave_and_took_back_is_not_given_again(
    url: str, here: WorkspaceStore
) -> None:
    there = WorkspaceStore(url)
    for _ in range(5):
        there.palette(SEQ)
        gone = here.create_label(SEQ, "ann", name="three").id
        here.undo(SEQ, "ann")
        assert there.create_label(SEQ, "bob", name="four").id > gone
    there.close()


def test_processes_hear_each_other(url: str, here: WorkspaceStore) -> None:
    heard: list[Commit] = []
    here.subscribe(heard.append)
    first = here.revision(SEQ)
    with forked.calling(edit, url, "bob") as bob, forked.calling(edit, url, "cat") as cat:
        for number in range(20):
            write = Write(np.arange(number, number + 5), label=1, provenance=1)
            here.apply(SEQ, edit_id=None, author="ann", kind="paint", writes={0: write}, summary="")
        assert (bob.wait(), cat.wait()) == (0, 0)
    eventually(lambda: len(heard) >= 60)
    assert [commit.revision for commit in heard] == list(range(first + 1, first + 61))
    copies = [np.zeros(n, np.uint16) for n in POINTS]
    for commit in heard:
        for frame, delta in commit.frames.items():
            copies[frame][delta.indices] = delta.label
    for frame, copy in enumerate(copies):
        assert (here.values(SEQ, frame).label == copy).all()
    cells = {(c.frame, c.label): (c.points, c.painted) for commit in heard for c in commit.cells}
    assert {key: cell for key, cell in cells.items() if cell[0]} == here.counts(SEQ)
    assert here.check(SEQ) == []


def test_a_sequence_that_was_never_opened_here_is_heard_of_too(
    url: str, here: WorkspaceStore
) -> None:
    there = WorkspaceStore(url)
    heard: list[int] = []
    there.subscribe(lambda commit: heard.append(commit.revision))
    here.apply(SEQ, edit_id=None, author="a", kind="paint", writes={}, summary="")
    eventually(lambda: bool(heard))
    there.close()
    assert heard == [3]


def test_what_was_missed_is_told_before_what_is_committed_while_opening(
    url: str, here: WorkspaceStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    there = WorkspaceStore(url)
    heard: list[int] = []
    outbox = there._open_recordings.outbox
    outbox.subscribe(lambda commit: heard.append(commit.revision))  # but does not look by itself
    here.update_label(SEQ, "ann", 1, name="missed")
    edit = threading.Thread(target=there.update_label, args=(SEQ, "bob", 1), kwargs={"name": "x"})
    put = outbox.put

    def slow_put(commit: Commit) -> None:
        if edit.ident is None:
            edit.start()
            edit.join(0.5)  # it must wait until the sequence is open
        put(commit)

    monkeypatch.setattr(outbox, "put", slow_put)
    there.revision(SEQ)
    edit.join()
    there.close()
    assert heard == [3, 4]


def test_an_edit_reaches_the_other_process_soon(url: str, here: WorkspaceStore) -> None:
    there = WorkspaceStore(url)
    there.revision(SEQ)
    arrived = threading.Event()
    there.subscribe(lambda _: arrived.set())
    time.sleep(0.3)  # let its watcher connect
    started = time.monotonic()
    here.update_label(SEQ, "ann", 1, name="new")
    assert arrived.wait(5)
    assert time.monotonic() - started < 1
    there.close()


def test_rules_see_what_another_process_committed(url: str, here: WorkspaceStore) -> None:
    there = WorkspaceStore(url)
    there.values(SEQ, 0)
    here.apply(
        SEQ,
        edit_id="x",
        author="ann",
        kind="paint",
        writes={0: Write(np.arange(10), label=1, provenance=1)},
        summary="",
    )
    commit = there.apply(
        SEQ,
        edit_id=None,
        author="bob",
        kind="tracking",
        writes={0: Write(np.arange(20), label=2, provenance=2, only="not_painted")},
        summary="",
    )
    assert commit.changed == 10
    assert there.values(SEQ, 0).label[:20].tolist() == [1] * 10 + [2] * 10
    assert there.undo(SEQ, "ann").changed == 10
    assert here.values(SEQ, 0).label[:20].tolist() == [0] * 10 + [2] * 10
    assert there.find(SEQ, "x") is not None
    there.close()


def test_a_process_that_was_away_for_long(
    url: str, here: WorkspaceStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sessions, "GAP", 5)
    there = WorkspaceStore(url)
    there.values(SEQ, 0)
    heard: list[Commit] = []
    there._open_recordings.outbox.subscribe(heard.append)  # hears, but does not look by itself
    for number in range(10):
        here.apply(
            SEQ,
            edit_id=None,
            author="ann",
            kind="paint",
            writes={0: Write(np.arange(number, number + 2), label=1, provenance=1)},
            summary="",
        )
    here.delete_label(SEQ, "ann", 2)
    assert there.values(SEQ, 0).label.sum() == 11
    assert len(there.palette(SEQ)) == 1
    assert [commit.revision for commit in heard] == [13]
    here.update_label(SEQ, "ann", 1, name="x")
    assert there.palette(SEQ)[0].name == "x"
    assert [commit.revision for commit in heard] == [13, 14]
    there.close()


def test_a_sequence_made_anew_elsewhere(url: str, here: WorkspaceStore, tmp_path: Path) -> None:
    there = WorkspaceStore(url)
    assert there.revision(SEQ) == 2
    here.recordings.forget(SEQ)
    with pytest.raises(NotFoundError):
        there.values(SEQ, 0)
    here.recordings.register(SEQ, [7])
    assert there.revision(SEQ) == 0
    assert len(there.values(SEQ, 0).label) == 7
    there.close()


def test_a_commit_is_heard_of_though_it_could_not_be_read_at_first(labels_url: str) -> None:
    with (
        closing(WorkspaceStore(labels_url)) as here,
        closing(WorkspaceStore(labels_url, limits=Limits(statement_seconds=1))) as there,
    ):
        here.recordings.register(SEQ, POINTS)
        here.create_label(SEQ, "ann", name="one")
        heard: list[int] = []
        there.subscribe(lambda commit: heard.append(commit.revision))
        eventually(lambda: there.revision(SEQ) == 1 and heard == [1])
        with psycopg.connect(labels_url) as other:
            # Read by who catches up with a stroke, and not by who paints it.
            other.execute("LOCK TABLE labels IN ACCESS EXCLUSIVE MODE")
            write = Write(np.arange(5), label=1, provenance=1)
            here.apply(SEQ, edit_id=None, author="a", kind="paint", writes={0: write}, summary="")
            waits = (
                "SELECT 1 FROM pg_stat_activity "
                "WHERE query LIKE '%labels%' AND wait_event_type = 'Lock'"
            )
            with psycopg.connect(labels_url, autocommit=True) as watching:
                eventually(lambda: watching.execute(waits).fetchone() is not None)
                eventually(lambda: watching.execute(waits).fetchone() is None)
            assert heard == [1]
        # Nobody commits again.
        eventually(lambda: heard == [1, 2])
