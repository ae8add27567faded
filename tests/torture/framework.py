"""Scenarios of faults: what each came to, and the table of all.

A scenario is a function that is given an ``Arena`` and counts into its ``Tally``.  It is registered
by ``@scenario``, run for its share of the time, and skipped in words where this machine cannot.
"""

from __future__ import annotations

import io
import random
import shutil
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from tests.faults.server import ServerProcess, running
from tests.postgres import PostgresServer, postgres

NOTE = 3000
"""Characters of a long note's beginning and end that are told."""
BAD = ("lost", "differs", "errors")
"""Counts that must stay 0."""


@dataclass
class Tally:
    """Counts of one scenario."""

    times: int = 0
    """Faults that were made, or rounds."""
    answered: int = 0
    """Calls that were answered with success."""
    refused: int = 0
    """503 of the contract: a full disk, or a database or bucket that is away."""
    damaged: int = 0
    """500 that names a damaged frame, of recordings whose files were cut."""
    lost: int = 0
    """Answered edits that are not there."""
    differs: int = 0
    """Things that are not as what was answered says."""
    errors: int = 0
    """All other 5xx, and tracebacks in the log."""
    notes: list[str] = field(default_factory=list)

    @property
    def sound(self) -> bool:
        """Whether nothing was lost, differs or failed, and something was tried."""
        return self.times > 0 and not any(getattr(self, name) for name in BAD)

    @contextmanager
    def expect(self, count: str) -> Iterator[None]:
        """Count an assertion that fails inside as one of ``count``, and go on."""
        try:
            yield
        except AssertionError as error:
            last = traceback.extract_tb(error.__traceback__)[-1]
            self.count(count, str(error) or f"{last.filename}, line {last.lineno}: {last.line}")

    def count(self, count: str, note: str) -> None:
        """Count one thing that must not be."""
        assert count in BAD
        setattr(self, count, getattr(self, count) + 1)
        self.notes.append(
            f"{count}: {note if len(note) < 2 * NOTE else note[:NOTE] + ' … ' + note[-NOTE:]}"
        )

    def status(self, status: int, text: str, *, away: bool = False) -> bool:
        """Count an answer; returns whether it is a success.

        ``away``: a part that the server needs may be away, so that 503 is right.
        """
        if status < 300:
            self.answered += 1
        elif status == 503 and away:
            self.refused += 1
        elif status >= 500:
            self.count("errors", f"{status} {text}")
        return status < 300


class Arena:
    """Means of one scenario: a folder, random numbers, time, and services that end with it."""

    def __init__(
        self, folder: Path, seconds: float, seed: int, stack: ExitStack, fewest: int
    ) -> None:
        self.folder, self.seconds, self.seed, self.stack = folder, seconds, seed, stack
        self.fewest = fewest
        self.rng = random.Random(seed)
        self.tally = Tally()
        self._end = time.monotonic() + seconds

    def rounds(self) -> Iterator[int]:
        """Numbers of rounds until the time is up, at least ``fewest``; each is counted."""
        number = 0
        while number < self.fewest or time.monotonic() < self._end:
            self.tally.times += 1
            yield number
            number += 1

    def rest(self) -> float:
        """Return the seconds that are left, at least one."""
        return max(1.0, self._end - time.monotonic())

    def serve(self, workspace: Path, url: str, servers: int) -> list[ServerProcess]:
        """Start servers of one workspace, whose labels are at a database URL unless it is empty."""
        environment = {"POINTBRUSH_DATABASE": url} if url else {}
        return [self.stack.enter_context(running(workspace, **environment)) for _ in range(servers)]

    def postgres(self) -> PostgresServer:
        """Start a PostgreSQL server of the scenario's own."""
        return self.stack.enter_context(postgres())


Run = Callable[[Arena], None]


@dataclass(frozen=True)
class Scenario:
    """A kind of fault."""

    name: str
    what: str
    share: float
    """Part of the whole time that it is given, relative to the others."""
    run: Run


SCENARIOS: dict[str, Scenario] = {}


@contextmanager
def alongside(stop: threading.Event, targets: Iterable[Callable[[], None]]) -> Iterator[None]:
    """Run each target in a thread, all of them until the context ends and sets ``stop``."""
    stop.clear()
    threads = [threading.Thread(target=target, daemon=True) for target in targets]
    for thread in threads:
        thread.start()
    try:
        yield
    finally:
        stop.set()
        for thread in threads:
            thread.join(120)


def scenario(what: str, share: float = 1.0) -> Callable[[Run], Run]:
    """Register a function as the scenario of its name, told as ``what``."""

    def register(run: Run) -> Run:
        name = run.__name__.replace("_", "-")
        SCENARIOS[name] = Scenario(name, what, share, run)
        return run

    return register


@dataclass(frozen=True)
class Row:
    """A scenario and its outcome; ``skipped``: why it could not be run here."""

    scenario: Scenario
    tally: Tally
    seconds: float
    skipped: str = ""

    def __str__(self) -> str:
        tally = self.tally
        counts = (tally.times, tally.answered, tally.refused, tally.damaged)
        told = [f"{n:,}" for n in (*counts, tally.lost, tally.differs, tally.errors)]
        cells = [self.scenario.what, *told, f"{self.seconds:.0f} s"]
        if self.skipped:
            cells = [self.scenario.what, f"not here: {self.skipped}", *[""] * 7]
        return f"| {' | '.join(cells)} |"


HEAD = """\
| fault | rounds | answered | 503 | damaged | lost | differs | 5xx | time |
|---|---|---|---|---|---|---|---|---|"""


def run(chosen: Scenario, seconds: float, seed: int, fewest: int = 1) -> Row:
    """Run ``fewest`` rounds of a scenario or more, in a folder; what servers log is not printed.

    An assertion that it does not count itself is a difference.
    """
    started, skipped = time.monotonic(), ""
    folder = Path(tempfile.mkdtemp(prefix=f"torture-{chosen.name}-"))
    try:
        with redirect_stderr(io.StringIO()), ExitStack() as stack:
            arena = Arena(folder, seconds, seed, stack, fewest)
            try:
                with arena.tally.expect("differs"):
                    chosen.run(arena)
            except pytest.skip.Exception as reason:
                skipped = str(reason)
            except Exception:
                arena.tally.count("errors", traceback.format_exc()[-NOTE:])
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return Row(chosen, arena.tally, time.monotonic() - started, skipped)


def shares(chosen: Iterable[Scenario], seconds: float) -> dict[str, float]:
    """Divide the time among scenarios."""
    wanted = {each.name: each.share for each in chosen}
    whole = sum(wanted.values())
    return {name: seconds * share / whole for name, share in wanted.items()}
