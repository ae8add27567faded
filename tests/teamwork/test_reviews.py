"""The log of reviews, on both databases: durable, per import, gone with its recording."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from itertools import pairwise
from pathlib import Path
from threading import Thread

import pytest

from pointbrush.errors import NotFoundError
from pointbrush.teamwork.reviews import Review
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.work.backups.backup import make_backup
from pointbrush.workspace import Workspace
from tests.old_workspace import EXPECTED, old_workspace

SEQUENCE = "juggling"


def test_decisions_come_back_in_their_order(store: WorkspaceStore, url: str) -> None:
    store.create_label(SEQUENCE, "ada", name="pin")
    wanted = [
        Review(0, 3, state="review"),
        Review(
            1, 1, label=1, state="rejected", note="the neck\nis missing", place=(1.0, -2.5, 3.0)
        ),
        Review(0, 1, assignee="grace"),
        Review(None, None, label=1, state="accepted"),
    ]
    for review in wanted:
        store.reviews.add(SEQUENCE, "x", "ada", review)
    with closing(WorkspaceStore(url)) as again:
        found = again.reviews.entries(SEQUENCE)
    assert [(e.number, e.author, e.revision) for e in found] == [(n, "ada", 1) for n in range(1, 5)]
    fields = ("first", "last", "label", "state", "note", "place", "assignee")
    assert [[getattr(e, f) for f in fields] for e in found] == [
        [getattr(e, f) for f in fields] for e in wanted
    ]
    assert all(a.time <= b.time for a, b in pairwise(found))


def test_two_people_who_decide_at_once_lose_nothing(store: WorkspaceStore) -> None:
    def decide(author: str) -> None:
        for frame in range(4):
            store.reviews.add(SEQUENCE, "x", author, Review(frame, frame, state="review"))

    people = [Thread(target=decide, args=(name,)) for name in ("ada", "grace", "joan")]
    for person in people:
        person.start()
    for person in people:
        person.join()
    found = store.reviews.entries(SEQUENCE)
    assert [entry.number for entry in found] == list(range(1, 13))


def test_they_belong_to_their_import_and_go_with_it(store: WorkspaceStore) -> None:
    store.recordings.register("other", [5], "a" * 16)
    store.reviews.add("other", "a" * 16, "ada", Review(0, 0, state="accepted"))
    with pytest.raises(NotFoundError, match="imported again"):
        store.reviews.add("other", "b" * 16, "ada", Review(0, 0, state="accepted"))
    store.recordings.forget("other")
    with pytest.raises(NotFoundError):
        store.reviews.entries("other")
    store.recordings.register("other", [5], "c" * 16)
    assert store.reviews.entries("other") == []


@pytest.fixture(params=["sqlite", "postgresql"])
def old(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Workspace]:
    postgres = request.param == "postgresql"
    url = str(request.getfixturevalue("postgres_url")) if postgres else ""
    with closing(Workspace(old_workspace(tmp_path, url))) as workspace:
        yield workspace


def test_a_workspace_of_before_is_reviewed_and_backed_up_with_that(
    old: Workspace, tmp_path: Path
) -> None:
    frames = len(EXPECTED["sequences"]["ball"]["points"])
    assert old.reviewing.overview("ball").counts["open"] == frames
    old.reviewing.put("ball", "ada", Review(0, 1, state="accepted"))
    make_backup(old.labels, old.library, tmp_path / "backup")
    restored = old.restore_from_backup(tmp_path / "backup", "ball")
    assert old.reviewing.overview(restored).counts["accepted"] == 2
    assert old.listing.problems("ball") == []
