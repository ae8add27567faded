"""Six authors who edit at once, and the comparison of what is left with a replay."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx

from tests.faults.clients import ENDED, Person
from tests.faults.replay import Replay
from tests.faults.server import ServerProcess
from tests.faults.torture import invite, make_workspace
from tests.torture.framework import Tally
from tests.waiting import eventually

NAMES = ("ann", "bob", "cat", "dan", "eve", "fay")
EDIT_PAUSE = 0.0
"""Seconds between two edits of an author."""
PAUSE = 0.1
"""Seconds between two attempts to reach a server."""
FAR = 120.0


class Authors:
    """Six authors of one recording, at the servers whose addresses they are told."""

    def __init__(self, workspace: Path, seed: int, database: str = "") -> None:
        make_workspace(workspace)
        self.people = invite(workspace, seed, names=NAMES, database=database)
        for one in self.people:
            one.pause = EDIT_PAUSE
        self.replay = Replay(workspace, database)

    @property
    def refused(self) -> int:
        """Edits that were answered with 503 since the last comparison."""
        return sum(one.away for one in self.people)

    @contextmanager
    def editing(self, addresses: Callable[[], list[str]]) -> Iterator[None]:
        """All edit until the context ends, each at its server, or at one that is there."""
        stop = threading.Event()
        threads = [
            threading.Thread(target=self._work, args=(one, number, addresses, stop), daemon=True)
            for number, one in enumerate(self.people)
        ]
        for thread in threads:
            thread.start()
        try:
            yield
        finally:
            stop.set()
            for thread in threads:
                thread.join(FAR)
            stuck = [one.name for one, t in zip(self.people, threads, strict=True) if t.is_alive()]
            assert not stuck, f"authors without an answer for {FAR:.0f} s: {stuck}"

    @staticmethod
    def _work(
        one: Person, number: int, addresses: Callable[[], list[str]], stop: threading.Event
    ) -> None:
        for turn in itertools.count(number):
            if stop.is_set() or one.fault is not None:
                return
            found = addresses()
            if found:
                one.work(found[turn % len(found)], stop)  # until it is gone
            stop.wait(PAUSE)

    def settle(self, server: ServerProcess, tally: Tally) -> None:
        """Count what was answered, and compare all of it with what the server has."""
        with server.api() as api:
            eventually(lambda: at_rest(api), FAR, PAUSE)
            for one in self.people:
                new = [each for each in one.asked if each.revision is None]
                tally.answered += sum(each.answer is not None for each in new)
                tally.refused += one.away
                one.away = 0
                if one.fault is not None:
                    tally.count("errors", f"{one.name}: {one.fault!r}")
                    one.fault = None
            with tally.expect("lost"):
                self.replay.catch_up(api, self.people)
            with tally.expect("differs"):
                self.replay.compare(api)


def at_rest(api: httpx.Client) -> bool:
    """Return whether the server answers from its database, and no job is under way."""
    jobs = api.get("/jobs")
    return jobs.is_success and all(job["state"] in ENDED for job in jobs.json())


def quiet(server: ServerProcess, tally: Tally) -> None:
    """Count a traceback in a server's log, told with the line before it."""
    before, traceback, after = server.stderr.partition("Traceback")
    if traceback:
        tally.count("errors", f"{before.splitlines()[-1]}\n{traceback}{after}")
