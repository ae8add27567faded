"""Events of a workspace for subscribers."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pointbrush.database.job import Job
from pointbrush.labels import Commit
from pointbrush.work.loops.compiling import Progress, StepName

if TYPE_CHECKING:
    from pointbrush.tracking import FrameResult


@dataclass(frozen=True, eq=False)
class Provisional:
    """Provisional results of a tracking run in a frame: stored numbers and a label for each."""

    sequence: str
    frame: int
    job: str
    numbers: NDArray[np.int64]
    labels: NDArray[np.uint16]
    found: FrameResult


@dataclass(frozen=True)
class Retracted:
    """A run's provisional results are void: it failed, or was cancelled without keeping them."""

    sequence: str
    job: str
    frames: tuple[int, ...]


@dataclass(frozen=True)
class SequencesChanged:
    """A sequence was imported, renamed or deleted."""

    sequence: str


@dataclass(frozen=True)
class Prepared:
    """A frame is ready for the object tool: clicks use the whole frame."""

    sequence: str
    frame: int


@dataclass(frozen=True)
class ClassesRenamed:
    """Classes were renamed: labels of a sequence may show other categories."""

    sequence: str


@dataclass(frozen=True)
class Compiling:
    """A step of compiling loops advanced, or is done (share 1)."""

    step: StepName
    progress: Progress


Event = (
    ClassesRenamed
    | Commit
    | Compiling
    | Job
    | Prepared
    | Provisional
    | Retracted
    | SequencesChanged
)


class Listeners:
    """Subscribers to events; thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._listeners: list[Callable[[Event], None]] = []

    def add(self, listener: Callable[[Event], None]) -> Callable[[], None]:
        """Call ``listener`` at every event, from any thread; return a function that removes it."""
        with self._lock:
            self._listeners.append(listener)

        def undo() -> None:
            with self._lock:
                if listener in self._listeners:
                    self._listeners.remove(listener)

        return undo

    def notify(self, event: Event) -> None:
        """Notify all listeners."""
        with self._lock:
            listeners = list(self._listeners)
        for listener in listeners:
            listener(event)
