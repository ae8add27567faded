"""Edits that wait for a recording are committed together, and each is answered for itself."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from sqlalchemy import event, exc
from waiting import eventually

from pointbrush.errors import LockedLabelError, UnavailableError
from pointbrush.labels import Commit, Write, journal
from pointbrush.labels.draft import Draft
from pointbrush.labels.state import SequenceState
from pointbrush.teamwork.store import WorkspaceStore

SEQUENCE = "juggling"


def in_turn(
    store: WorkspaceStore, threads: ThreadPoolExecutor, *edits: tuple[str, int]
) -> list[Future[Commit]]:
    """Paint edits of a label each, which wait for the recording's lock in this order."""
    with store._open_recordings.knowing(SEQUENCE) as state:
        waiting = []
        for number, (edit, label) in enumerate(edits, start=1):
            waiting.append(threads.submit(paint, store, edit, label))
            eventually(lambda number=number: queued(store, state) == number)
        return waiting


def paint(store: WorkspaceStore, edit: str, label: int) -> Commit:
    writes = {0: Write(np.arange(len(edit) * 100), label=label, provenance=1)}
    return store.apply(
        SEQUENCE, edit_id=edit, author=edit, kind="paint", writes=writes, summary=edit
    )


def queued(store: WorkspaceStore, state: SequenceState) -> int:
    """Edits that wait for a recording's lock."""
    return len(store._writer._waiting.get(state, ()))


def test_edits_that_wait_share_a_transaction(store: WorkspaceStore) -> None:
    store.create_label(SEQUENCE, "ann", name="open")
    store.create_label(SEQUENCE, "ann", name="locked", locked=True)
    begun: list[Any] = []
    event.listen(store.database.engine, "begin", begun.append)
    before = store.revision(SEQUENCE)
    edits = [("a", 1), ("bb", 2), ("ccc", 1), ("a", 1), ("dddd", 1)]
    with ThreadPoolExecutor(len(edits)) as threads:
        waiting = in_turn(store, threads, *edits)
        with pytest.raises(LockedLabelError):
            waiting.pop(1).result()
        done = [one.result() for one in waiting]
    assert [commit.edit for commit in done] == ["a", "ccc", "a", "dddd"]
    assert [commit.revision - before for commit in done] == [1, 2, 1, 3]
    assert [commit.repeated for commit in done] == [False, False, True, False]
    assert len(begun) == 1
    assert store.check(SEQUENCE) == []


def test_a_commit_that_fails_is_everybodys_and_leaves_nothing(
    store: WorkspaceStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    store.create_label(SEQUENCE, "ann", name="open")
    before, append = store.revision(SEQUENCE), journal.append

    def away(*given: Any) -> None:
        append(*given)
        if given[2].id == "bb":
            raise UnavailableError("the database is away")

    with ThreadPoolExecutor(2) as threads, monkeypatch.context() as patch:
        patch.setattr(journal, "append", away)
        for one in in_turn(store, threads, ("a", 1), ("bb", 1)):
            with pytest.raises(UnavailableError):
                one.result()
    assert store.revision(SEQUENCE) == before
    assert not store.values(SEQUENCE, 0).label.any()
    assert paint(store, "a", 1).revision == before + 1
    assert store.check(SEQUENCE) == []


def test_a_database_that_goes_away_as_an_edit_is_drafted_fails_all_in_words(
    store: WorkspaceStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    store.create_label(SEQUENCE, "ann", name="open")
    before, write = store.revision(SEQUENCE), Draft.write

    def lost(draft: Draft, frame: int, wanted: Write) -> None:
        if len(wanted.indices) == len("bb") * 100:
            raise exc.OperationalError("SELECT", {}, Exception("server closed the connection"))
        write(draft, frame, wanted)

    with ThreadPoolExecutor(3) as threads, monkeypatch.context() as patch:
        patch.setattr(Draft, "write", lost)
        for one in in_turn(store, threads, ("a", 1), ("bb", 1), ("ccc", 1)):
            with pytest.raises(UnavailableError):
                one.result()
    assert store.revision(SEQUENCE) == before
    assert paint(store, "bb", 1).revision == before + 1
    assert store.check(SEQUENCE) == []
