"""PostgreSQL is killed, restarted and slow under one server or two."""

from __future__ import annotations

import time
from urllib.parse import urlsplit

from tests.faults.server import ServerProcess, running
from tests.torture.authors import Authors, quiet
from tests.torture.framework import Arena, scenario
from tests.torture.proxy import SlowProxy

SLOW = (0.002, 0.02, 0.1)
"""Seconds on the way of each block between server and database."""
HELD = 1.5


def _serve(arena: Arena, url: str, count: int) -> list[ServerProcess]:
    workspace = arena.folder / "workspace"
    return [
        arena.stack.enter_context(running(workspace, POINTBRUSH_DATABASE=url)) for _ in range(count)
    ]


def _killed(arena: Arena, servers: int) -> None:
    database = arena.postgres()
    url = database.new_labels()
    authors = Authors(arena.folder / "workspace", arena.seed, url)
    served = _serve(arena, url, servers)
    addresses = [server.url for server in served]
    for _ in arena.rounds():
        with authors.editing(lambda: addresses):
            time.sleep(arena.rng.uniform(0.3, 2.0))
            database.stop()
            time.sleep(arena.rng.uniform(0.0, 1.0))
            database.start()
            time.sleep(arena.rng.uniform(0.5, 1.5))
        for server in served:
            authors.settle(server, arena.tally)
    for server in served:
        quiet(server, arena.tally)


@scenario("PostgreSQL is killed and restarted while six authors edit", 2)
def postgres_killed(arena: Arena) -> None:
    """One server."""
    _killed(arena, 1)


@scenario("the same with two servers, and edits through both", 2)
def postgres_killed_two_servers(arena: Arena) -> None:
    """Two servers."""
    _killed(arena, 2)


@scenario("PostgreSQL is slow and sometimes silent, while six authors edit", 2)
def postgres_slow(arena: Arena) -> None:
    """A proxy delays every block between server and database."""
    database = arena.postgres()
    direct = database.new_labels()
    authors = Authors(arena.folder / "workspace", arena.seed, direct)
    proxy = arena.stack.enter_context(SlowProxy(database.port))
    place = urlsplit(direct)
    url = place._replace(netloc=f"postgres@127.0.0.1:{proxy.port}").geturl()
    (server,) = _serve(arena, url, 1)
    for _ in arena.rounds():
        with authors.editing(lambda: [server.url]):
            proxy.delay = arena.rng.choice(SLOW)
            time.sleep(arena.rng.uniform(1.0, 3.0))
            proxy.delay = HELD
            time.sleep(HELD)
            proxy.delay = 0.0
        authors.settle(server, arena.tally)
    quiet(server, arena.tally)
