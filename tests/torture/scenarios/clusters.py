"""The Dask cluster that jobs run on is lost, and comes back."""

from __future__ import annotations

import time

import pytest

from tests.dask_cluster import DaskCluster
from tests.faults.server import running
from tests.torture.authors import Authors, quiet
from tests.torture.framework import Arena, scenario
from tests.torture.librarian import Librarian

LOSSES = (("worker",), ("worker", "scheduler"))
"""Parts that are lost together: a worker ends by itself when its scheduler does."""


@scenario("a Dask worker, or also the scheduler, is lost and returns, while six authors edit", 1)
def dask_lost(arena: Arena) -> None:
    """Their tracking runs and somebody's imports run on it."""
    pytest.importorskip("distributed")
    cluster = arena.stack.enter_context(DaskCluster())
    authors, librarian = Authors(arena.folder / "workspace", arena.seed), Librarian(arena)
    cluster.start("scheduler")
    cluster.start("worker")
    there = {"POINTBRUSH_SCHEDULER": cluster.address}
    server = arena.stack.enter_context(running(arena.folder / "workspace", **there))
    for _ in arena.rounds():
        with authors.editing(lambda: [server.url]), librarian.importing(lambda: server.url):
            for lost in LOSSES:
                time.sleep(arena.rng.uniform(0.5, 3.0))
                for part in lost:
                    cluster.kill(part)
                time.sleep(arena.rng.uniform(0.0, 3.0))
                for part in reversed(lost):
                    cluster.start(part)
            time.sleep(arena.rng.uniform(0.5, 2.0))
        authors.settle(server, arena.tally)
        librarian.settle(server)
    quiet(server, arena.tally)
