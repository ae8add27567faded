"""Compiling Numba loops once per machine, grouped in steps by first use, with progress.

Each step has a file beside the compiled loops.  The process that compiles a step locks the file and
writes its progress to it; other processes wait, and continue if that process dies.  A changed loop
is compiled at its first run, independent of these files.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Literal, get_args

import pointbrush

StepName = Literal["objects", "things", "people", "imports", "example", "paper"]
"""Steps in the order of first use: object tool, tracking of things and people, then the others."""
STEPS: tuple[StepName, ...] = get_args(StepName)
PACKAGE = Path(pointbrush.__file__).parent
NOTE = "pointbrush-loops-{}.json"
RECORD_BYTES = 512
LOOK_SECONDS = 0.2
"""Polling interval for a step that another process compiles."""


@dataclass(frozen=True)
class Progress:
    """Progress of a step: a share, 0 to 1, and the estimated remaining seconds; None: unknown."""

    share: float
    seconds: float | None = None


Report = Callable[[Progress], None]
"""Callback with the progress of the awaited step; an error in it ends the wait."""
DONE = Progress(1.0, 0.0)


def progress_of(step: StepName) -> Progress:
    """Return the progress of a step on this machine; DONE if it is unknown."""
    if (path := _path(step)) is None:
        return DONE
    try:
        noted = json.loads(path.read_text(encoding="utf-8"))
        if noted.pop("stamp") == _stamp():
            return Progress(**noted)
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        pass  # not started, or being written
    return Progress(0.0)


def are_compiled(steps: Iterable[StepName] = STEPS) -> bool:
    """Return whether the loops of some steps are compiled; True if it is unknown."""
    return all(progress_of(step).share >= 1 for step in steps)


@contextlib.contextmanager
def hold(step: StepName) -> Iterator[Report | None]:
    """Lock a step and yield a function that stores its progress; None: another process has it."""
    path = _path(step)
    assert path is not None  # noqa: S101 – without a path every step counts as compiled
    with os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT, 0o644), "r+b") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield None
            return

        def note(progress: Progress) -> None:
            record = json.dumps({"stamp": _stamp(), **asdict(progress)})
            # A single write of constant length: readers see the last record or this one.
            os.pwrite(file.fileno(), record.ljust(RECORD_BYTES).encode(), 0)

        yield note


def _path(step: StepName) -> Path | None:
    """Return the path of a step's file; None if no folder for compiled loops is writable."""
    folder = _folder(os.environ.get("NUMBA_CACHE_DIR", ""))
    return None if folder is None else folder / NOTE.format(step)


@cache
def _folder(named: str) -> Path | None:
    folder = Path(named) if named else PACKAGE / "__pycache__"
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
    return folder if os.access(folder, os.W_OK) else None


def _stamp() -> str:
    return f"{pointbrush.__version__} {_numba()} {sys.version}"


@cache
def _numba() -> str:
    return version("numba")
