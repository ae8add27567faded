"""PostgreSQL's answer to a commit is lost: the edit is looked for, and answered as it was made."""

from __future__ import annotations

from urllib.parse import urlsplit

import numpy as np
from postgres import PostgresServer, postgres_server  # noqa: F401  # a fixture

from pointbrush.labels import LabelStore, Write
from tests.torture.proxy import SlowProxy

COMMITTED = (b"INSERT 0 1\0", b"COMMIT\0")
"""What PostgreSQL answers to an edit and its commit."""


def test_an_edit_that_was_made_is_answered(
    postgres_server: PostgresServer,  # noqa: F811
) -> None:
    place = urlsplit(postgres_server.new_database())
    with SlowProxy(postgres_server.port) as proxy:
        url = place._replace(netloc=f"postgres@127.0.0.1:{proxy.port}").geturl()
        store = LabelStore(url)
        heard: list[int] = []
        store.subscribe(lambda commit: heard.append(commit.revision))
        store.register("wall", [100])
        assert not store.palette("wall")  # what is known of it is in memory from here on

        proxy.lost = COMMITTED
        label, made = store.create_label("wall", "ann", name="brick")
        proxy.lost = COMMITTED
        write = Write(np.arange(10), label=np.full(10, label.id, np.uint16), provenance=1)
        painted = store.apply(
            "wall", edit_id=None, author="ann", kind="paint", writes={0: write}, summary="paint"
        )
        proxy.lost = COMMITTED
        undone = store.undo("wall", "ann")

        assert (made.revision, painted.revision, painted.changed) == (1, 2, 10)
        assert (undone.revision, undone.changed, proxy.lost) == (3, 10, ())
        assert [one.name for one in store.palette("wall")] == ["brick"]
        assert not store.values("wall", 0).label.any()
        assert sorted(heard) == [1, 2, 3]
        store.close()
