"""Commands on a workspace while six authors edit it: backup, restore, move, check."""

from __future__ import annotations

import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

import httpx

from tests.faults.clients import SEQUENCE
from tests.faults.server import ServerProcess, running
from tests.forked import run
from tests.torture.authors import Authors, quiet
from tests.torture.framework import Arena, Tally, scenario

REFUSED = 1


def _require(tally: Tally, done: subprocess.CompletedProcess[str]) -> bool:
    """Count a command's end; returns whether it was good."""
    if done.returncode == 0:
        tally.answered += 1
    else:
        tally.count("differs", f"{done.args}: {done.stdout[-500:]} {done.stderr[-1500:]}")
    return done.returncode == 0


@scenario("backup, restore and check while six authors edit", 2)
def backup_while_editing(arena: Arena) -> None:
    """A backup is a moment of the journal: what it has is a replay of its first edits."""
    workspace, tally = arena.folder / "workspace", arena.tally
    authors = Authors(workspace, arena.seed)
    server = arena.stack.enter_context(running(workspace))
    for number in arena.rounds():
        target, other = arena.folder / f"backup-{number}", arena.folder / f"other-{number}"
        at = ("--workspace", str(workspace))
        with authors.editing(lambda: [server.url]):
            time.sleep(arena.rng.uniform(0.1, 0.5))
            _require(tally, run("check", *at))
            if _require(tally, run("backup", str(target), *at)):
                restored = ("restore", str(target), "--workspace", str(other))
                if _require(tally, run(*restored)):
                    _require(tally, run("check", "--workspace", str(other)))
        authors.settle(server, tally)
        if other.exists():
            _compare(server, other, tally)
        shutil.rmtree(target, ignore_errors=True)
        shutil.rmtree(other, ignore_errors=True)
    quiet(server, tally)


def _compare(server: ServerProcess, restored: Path, tally: Tally) -> None:
    """Compare a restored workspace's journal with the beginning of the original's."""
    with server.api() as api:
        wanted = {row["revision"]: row["id"] for row in _edits(api)}
    with running(restored) as other, other.api() as api:
        rows = _edits(api)
    for row in rows:
        if wanted.get(row["revision"]) != row["id"]:
            tally.count("differs", f"a restored edit that the original has not: {row}")
    if len(rows) != max(row["revision"] for row in rows):
        tally.count("lost", f"{len(rows)} edits of {rows[0]['revision']}")


def _edits(api: httpx.Client) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    before: dict[str, int] = {}
    while not found or found[-1]["revision"] > 1:
        query = {"limit": 1000, **before}
        rows = api.get(f"/sequences/{SEQUENCE}/edits", params=query).raise_for_status().json()
        if not rows:
            break
        found += rows
        before = {"before": rows[-1]["revision"]}
    return found


@scenario("move to PostgreSQL and back while six authors try to edit", 1)
def move_while_editing(arena: Arena) -> None:
    """It is refused beneath a running server, and takes everything when that has ended."""
    authors = Authors(arena.folder / "workspace", arena.seed)
    database = arena.postgres()
    for _ in arena.rounds():
        url = database.new_database()
        _moved(arena, authors, url, {}, {"POINTBRUSH_DATABASE": url})
        there = ("--database", url)
        _moved(arena, authors, "sqlite", {"POINTBRUSH_DATABASE": url}, {}, *there)


def _moved(
    arena: Arena,
    authors: Authors,
    target: str,
    before: dict[str, str],
    after: dict[str, str],
    *options: str,
) -> None:
    """Edit, try to move meanwhile, move, and look at the labels where they are then."""
    workspace, tally = arena.folder / "workspace", arena.tally
    move = ("move", target, "--workspace", str(workspace), *options)
    server = ServerProcess(workspace, **before)
    try:
        with authors.editing(lambda: [server.url]):
            time.sleep(0.5)
            done = run(*move)
        authors.settle(server, tally)
        quiet(server, tally)
        server.stop()
    finally:
        server.kill()
    if done.returncode == REFUSED:
        tally.refused += 1
        done = run(*move)
    _require(tally, done)
    with running(workspace, **after) as moved:
        authors.replay.database = after.get("POINTBRUSH_DATABASE", "") or _sqlite(workspace)
        authors.settle(moved, tally)
        moved.stop()


def _sqlite(workspace: Path) -> str:
    return f"sqlite:///{workspace / 'labels.sqlite'}"


@scenario("check --repair beside a server that six authors use", 1)
def repair_while_editing(arena: Arena) -> None:
    """It repairs or refuses; it never changes what was answered."""
    workspace, tally = arena.folder / "workspace", arena.tally
    authors = Authors(workspace, arena.seed)
    server = arena.stack.enter_context(running(workspace))
    for _ in arena.rounds():
        with authors.editing(lambda: [server.url]):
            time.sleep(arena.rng.uniform(0.1, 0.5))
            done = run("check", "--repair", "--workspace", str(workspace))
        if done.returncode == REFUSED:
            tally.refused += 1
        else:
            _require(tally, done)
        authors.settle(server, tally)
        _require(tally, run("check", "--workspace", str(workspace)))
    quiet(server, tally)
