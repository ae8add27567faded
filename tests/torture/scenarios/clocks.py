"""The wall clock jumps a day back and a month ahead, and is set right again."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import httpx

from pointbrush.teamwork.store import WorkspaceStore
from tests.faults.server import ServerProcess, running
from tests.serving import add_sequence, settings_in
from tests.torture.authors import Authors, quiet
from tests.torture.framework import Arena, Tally, scenario
from tests.torture.machine import preloaded

DAY = 86_400
JUMPS = (-DAY, 31 * DAY)
"""Seconds by which the clock is wrong."""
SPARE = "spare"
"""A recording that is deleted, and restored."""


@scenario("the clock jumps a day back and a month ahead: tokens, deleted recordings", 1)
def clock_jumps(arena: Arena) -> None:
    """What was deleted is there still when the clock is right again; so are tokens."""
    workspace, clock = arena.folder / "workspace", arena.folder / "clock"
    authors = Authors(workspace, arena.seed)
    add_sequence(settings_in(arena.folder), SPARE, frames=1, points=2_000)
    week = _token(workspace, time.time() + 7 * DAY)
    shifted = {"LD_PRELOAD": preloaded(arena.folder), "TORTURE_CLOCK": str(clock)}
    server = arena.stack.enter_context(running(workspace, **shifted))
    for _ in arena.rounds():
        kept = _delete(server)
        with authors.editing(lambda: [server.url]):
            for ahead in (*arena.rng.sample(JUMPS, len(JUMPS)), 0):
                clock.write_text(str(ahead))
                time.sleep(arena.rng.uniform(0.5, 1.5))
                _look(server, week, 401 if ahead > 7 * DAY else 200, arena.tally)
        _restore(server, kept, arena.tally)
        authors.settle(server, arena.tally)
    quiet(server, arena.tally)


def _token(workspace: Path, expires: float) -> str:
    store = WorkspaceStore(f"sqlite:///{workspace / 'labels.sqlite'}")
    try:
        return store.tokens.add("viewer", "gus", expires)
    finally:
        store.close()


def _look(server: ServerProcess, token: str, wanted: int, tally: Tally) -> None:
    """Look into the trash, which is tidied then, and try a token that is for a week."""
    with server.api() as api, server.api(token) as viewer:
        for call in (partial(api.get, "/sequences?deleted=true"), partial(api.get, "/jobs")):
            _require(call, 200, tally)
        _require(partial(viewer.get, "/sequences"), wanted, tally)


def _require(call: Callable[[], httpx.Response], wanted: int, tally: Tally) -> None:
    response = call()
    tally.status(response.status_code, response.text)
    if response.status_code != wanted:
        tally.count("differs", f"{response.url}: {wanted} expected, got {response.text}")


def _delete(server: ServerProcess) -> bytes:
    """Delete the recording; returns the annotation of its frame."""
    with server.api() as api:
        root = f"/sequences/{SPARE}"
        api.post(f"{root}/labels", json={"name": "pin"})
        stroke = {"label": 1, "radius": 0.3, "samples": [{"origin": [0.0, 0.0, 3.0]}]}
        api.post(f"{root}/frames/0/strokes", json=stroke).raise_for_status()
        kept = api.get(f"{root}/frames/0/annotation").raise_for_status().content
        api.delete(root).raise_for_status()
    return kept


def _restore(server: ServerProcess, kept: bytes, tally: Tally) -> None:
    with server.api() as api:
        response = api.post(f"/sequences/{SPARE}/restore")
        with tally.expect("lost"):
            assert tally.status(response.status_code, response.text), response.text
        found = api.get(f"/sequences/{SPARE}/frames/0/annotation").raise_for_status().content
        if found != kept:
            tally.count("differs", "the labels of a restored recording")
