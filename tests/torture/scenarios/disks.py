"""The disk of a SQLite workspace is full, read-only or slow."""

from __future__ import annotations

import resource
import time

from tests.faults.server import ServerProcess, running
from tests.torture.authors import Authors, quiet
from tests.torture.framework import Arena, scenario
from tests.torture.machine import Ballast, limited, mounted, preloaded
from tests.waiting import eventually

SIZE = 24 * 2**20
FSYNC_MICROSECONDS = "150000"
BATCH_MICROSECONDS = "40000"
"""Time by which flushes are slower, so that authors wait for each other."""
MOST_BYTES = 4096
"""Size beyond which a file may not grow."""


def _settle(arena: Arena, authors: Authors, server: ServerProcess) -> None:
    authors.settle(server, arena.tally)
    quiet(server, arena.tally)


@scenario("SQLite's disk is sometimes full, while six authors edit", 2)
def disk_full(arena: Arena) -> None:
    """A file takes all the room, and goes again.

    Each commit takes so long that several edits wait for the next one: when that finds no room,
    all but the last of them are in the server's memory already.
    """
    slow = {"LD_PRELOAD": preloaded(arena.folder), "TORTURE_FSYNC": BATCH_MICROSECONDS}
    disk = arena.stack.enter_context(mounted(arena.folder / "disk", SIZE))
    authors = Authors(disk / "workspace", arena.seed)
    ballast = Ballast(disk)
    server = arena.stack.enter_context(running(disk / "workspace", **slow))
    for _ in arena.rounds():
        with authors.editing(lambda: [server.url]):
            time.sleep(arena.rng.uniform(0.2, 0.8))
            # The database's log has some room of its own: the disk is full when that is used up.
            eventually(lambda: ballast.fill() or authors.refused, every=0.05)
            time.sleep(arena.rng.uniform(0.2, 0.8))
            ballast.drop()
            time.sleep(arena.rng.uniform(0.2, 0.8))
        _settle(arena, authors, server)


@scenario("files cannot grow, as on a disk that turned read-only, while six authors edit", 1)
def disk_read_only(arena: Arena) -> None:
    """A limit of the process, since files that are open keep a disk from being read-only."""
    authors = Authors(arena.folder / "workspace", arena.seed)
    server = arena.stack.enter_context(running(arena.folder / "workspace"))
    for _ in arena.rounds():
        with authors.editing(lambda: [server.url]):
            time.sleep(arena.rng.uniform(0.2, 0.8))
            with limited(server.process.pid, resource.RLIMIT_FSIZE, MOST_BYTES):
                time.sleep(arena.rng.uniform(0.5, 1.0))
            time.sleep(arena.rng.uniform(0.2, 0.8))
        _settle(arena, authors, server)


@scenario("every flush to SQLite's disk takes 150 ms longer, while six authors edit", 1)
def disk_slow(arena: Arena) -> None:
    """A library between the server and the system delays fsync."""
    slow = {"LD_PRELOAD": preloaded(arena.folder), "TORTURE_FSYNC": FSYNC_MICROSECONDS}
    authors = Authors(arena.folder / "workspace", arena.seed)
    server = arena.stack.enter_context(running(arena.folder / "workspace", **slow))
    for _ in arena.rounds():
        with authors.editing(lambda: [server.url]):
            time.sleep(min(arena.rest(), 4.0))
        _settle(arena, authors, server)
