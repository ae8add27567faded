"""Seconds of each file of tests: the longest begin first, and `make quick` leaves them out."""

from __future__ import annotations

import json
from collections import Counter, defaultdict
from collections.abc import Mapping
from itertools import accumulate
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
FILE = TESTS / "seconds.json"
"""Seconds of each file of tests on one core, from `make measure`."""
ROOM_SECONDS = 12.0
"""Seconds that `make quick` spends on each folder, on its quickest files."""
ALWAYS_SLOW = ("e2e", "release")


def read() -> dict[str, float]:
    found: dict[str, float] = json.loads(FILE.read_text())
    return found


def slow(seconds: Mapping[str, float]) -> set[str]:
    """List what exceeds ROOM_SECONDS when a folder's files are taken from the quickest on."""
    rooms = defaultdict(list)
    for name, taken in seconds.items():
        rooms[str(Path(name).parent)].append((taken, name))
    return {
        name
        for room in map(sorted, rooms.values())
        for (_, name), total in zip(room, accumulate(taken for taken, _ in room), strict=True)
        if total > ROOM_SECONDS
    }


def arrange(items: list[pytest.Item]) -> None:
    """Mark the files that `make quick` leaves out, and begin with the longest.

    A long file that begins last would keep one worker while the other has nothing to do.
    """
    seconds = read()
    left_out = slow(seconds)

    def name(item: pytest.Item) -> str:
        return item.path.relative_to(TESTS).as_posix()

    for item in items:
        if name(item) in left_out or name(item).split("/")[0] in ALWAYS_SLOW:
            item.add_marker(pytest.mark.slow)
    items.sort(key=lambda item: -seconds.get(name(item), 0.0))


class Measuring:
    """A plugin: the seconds of each file go into FILE."""

    def __init__(self) -> None:
        self._taken: Counter[str] = Counter()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._taken[report.nodeid.split("::")[0].removeprefix("tests/")] += report.duration

    def pytest_sessionfinish(self) -> None:
        write({**read(), **self._taken})


def write(seconds: Mapping[str, float]) -> None:
    """Write FILE, without files that are gone and browser tests."""
    kept = {
        name: round(taken, 1)
        for name, taken in sorted(seconds.items())
        if (TESTS / name).is_file() and name.split("/")[0] not in ALWAYS_SLOW
    }
    FILE.write_text(json.dumps(kept, indent=0) + "\n")
