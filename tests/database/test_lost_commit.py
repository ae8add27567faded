"""PostgreSQL's answer to a commit is lost: what was written is looked for, and answered."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from urllib.parse import urlsplit

import numpy as np
import pytest

from pointbrush.database.job import Job
from pointbrush.errors import UnavailableError
from pointbrush.labels import Write
from pointbrush.teamwork.reviews import Review
from pointbrush.teamwork.store import WorkspaceStore
from tests.postgres import PostgresServer
from tests.torture.proxy import SlowProxy

COMMITTED = (b"INSERT 0 1\0", b"COMMIT\0")
"""What PostgreSQL answers to an edit and its commit."""


@pytest.fixture
def proxy(postgres_server: PostgresServer) -> Iterator[SlowProxy]:
    with SlowProxy(postgres_server.port) as running:
        yield running


@pytest.fixture
def url(postgres_server: PostgresServer, proxy: SlowProxy) -> str:
    place = urlsplit(postgres_server.new_labels())
    return place._replace(netloc=f"postgres@127.0.0.1:{proxy.port}").geturl()


def test_an_edit_that_was_made_is_answered(url: str, proxy: SlowProxy) -> None:
    with closing(WorkspaceStore(url)) as store:
        heard: list[int] = []
        store.subscribe(lambda commit: heard.append(commit.revision))
        store.recordings.register("wall", [100])
        assert not store.palette("wall")  # what is known of it is in memory from here on

        proxy.lost = COMMITTED
        label = store.create_label("wall", "ann", name="brick")
        proxy.lost = COMMITTED
        write = Write(np.arange(10), label=np.full(10, label.id, np.uint16), provenance=1)
        painted = store.apply(
            "wall", edit_id=None, author="ann", kind="paint", writes={0: write}, summary="paint"
        )
        proxy.lost = COMMITTED
        undone = store.undo("wall", "ann")

        assert (painted.revision, painted.changed) == (2, 10)
        assert (undone.revision, undone.changed, proxy.lost) == (3, 10, ())
        assert [one.name for one in store.palette("wall")] == ["brick"]
        assert not store.values("wall", 0).label.any()
        assert sorted(heard) == [1, 2, 3]


def test_what_may_not_be_written_twice_is_looked_for(url: str, proxy: SlowProxy) -> None:
    with closing(WorkspaceStore(url)) as store:
        store.recordings.register("wall", [100])

        proxy.lost = (b"COMMIT\0",)
        secret = store.tokens.add("annotator", "ann", None)
        assert store.tokens.check(secret) is not None

        proxy.lost = (b"COMMIT\0",)
        store.jobs.add(Job(kind="import", sequence="wall", owner="ann"))
        assert [job.owner for job in store.jobs.all()] == ["ann"]

        proxy.lost = (b"COMMIT\0",)
        told = store.reviews.add("wall", "", "ann", Review(0, 0, state="review", note="look"))
        assert store.reviews.entries("wall") == [told]
        assert proxy.lost == ()


def test_what_was_not_written_is_refused(url: str, proxy: SlowProxy) -> None:
    with closing(WorkspaceStore(url)) as store:
        proxy.lost = (b"INSERT 0 1\0",)
        with pytest.raises(UnavailableError):
            store.tokens.add("annotator", "ann", None)
        assert store.tokens.list() == []
