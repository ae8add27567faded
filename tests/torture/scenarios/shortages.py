"""The process may open too few files, or have too little memory, now and then."""

from __future__ import annotations

import resource
import time
from contextlib import ExitStack, suppress

import httpx

from tests.faults.server import ServerProcess, running
from tests.serving import add_sequence, settings_in
from tests.torture.authors import Authors, quiet
from tests.torture.framework import Arena, scenario
from tests.torture.librarian import Librarian
from tests.torture.machine import address_space, descriptors, limited
from tests.torture.scenarios.crowds import connected
from tests.waiting import eventually

STRANGERS = 60
"""Connections that are made while there are no files for them."""
MOST_SPARE = 8
"""Files that the process may open beside those that it has open."""
LARGE = "large"
LARGE_POINTS = 1_000_000
"""Points of a frame whose answers take more memory than there is."""
SPARE_MEMORY = (2 << 20, 40 << 20)
"""Bytes that the process may still take: fewest, most."""
PATHS = (
    "frames/0/points",
    "frames/0/points?format=npz",
    "frames/0/annotation",
    "labels",
    "export?format=npz",
)


@scenario("too few file descriptors, during edits, imports and stray connections", 1)
def too_few_files(arena: Arena) -> None:
    """The limit of the process is lowered to what it has open, and raised again."""
    authors, librarian = Authors(arena.folder / "workspace", arena.seed), Librarian(arena, 50_000)
    server = arena.stack.enter_context(running(arena.folder / "workspace"))
    process = server.process.pid
    for _ in arena.rounds():
        with (
            authors.editing(lambda: [server.url]),
            librarian.importing(lambda: server.url),
            ExitStack() as held,
        ):
            time.sleep(arena.rng.uniform(0.2, 1.0))
            spare = arena.rng.randrange(MOST_SPARE)
            with limited(process, resource.RLIMIT_NOFILE, descriptors(process) + spare):
                for _ in range(arena.rng.choice((0, STRANGERS))):
                    held.enter_context(connected(server))
                time.sleep(arena.rng.uniform(0.5, 2.0))
            time.sleep(arena.rng.uniform(0.2, 1.0))
        authors.settle(server, arena.tally)
        librarian.settle(server)
    quiet(server, arena.tally)


@scenario("too little memory, during edits, imports and reads", 1)
def too_little_memory(arena: Arena) -> None:
    """The address space of the process is limited to little more than it has, and free again."""
    authors, librarian = Authors(arena.folder / "workspace", arena.seed), Librarian(arena, 50_000)
    add_sequence(settings_in(arena.folder), LARGE, frames=1, points=LARGE_POINTS)
    server = arena.stack.enter_context(running(arena.folder / "workspace"))
    process = server.process.pid
    _work_in_peace(authors, server)
    for _ in arena.rounds():
        with (
            authors.editing(lambda: [server.url]),
            librarian.importing(lambda: server.url),
            server.api() as api,
        ):
            time.sleep(arena.rng.uniform(1.0, 2.0))
            space = address_space(process) + arena.rng.randint(*SPARE_MEMORY)
            with limited(process, resource.RLIMIT_AS, space):
                end = time.monotonic() + arena.rng.uniform(0.5, 2.0)
                while time.monotonic() < end:
                    path = f"/sequences/{LARGE}/{arena.rng.choice(PATHS)}"
                    with suppress(httpx.TransportError):  # an answer that breaks off is seen
                        answer = api.get(path)
                        arena.tally.status(answer.status_code, answer.text[:500], away=True)
            time.sleep(arena.rng.uniform(0.2, 1.0))
        assert server.process.poll() is None, f"the server has ended: {server.process.poll()}"
        authors.settle(server, arena.tally)
        librarian.settle(server)
    quiet(server, arena.tally)


def _work_in_peace(authors: Authors, server: ServerProcess) -> None:
    """Have all libraries loaded that work needs: what fails to load once may do so ever after."""
    with authors.editing(lambda: [server.url]), server.api() as api:
        for path in PATHS:
            api.get(f"/sequences/{LARGE}/{path}").raise_for_status()
        asked = [one.asked for one in authors.people]
        eventually(
            lambda: any(
                each.answer is not None
                for edits in asked
                for each in edits
                if each.edit["kind"] == "track"
            )
        )
