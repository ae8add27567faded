"""What happens in a workspace, for those who watch it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.jobs import Job
from pointbrush.labels import Commit
from pointbrush.tracking import FrameResult


@dataclass(frozen=True, eq=False)
class Provisional:
    """What a tracking run just found in a frame: stored numbers and a label for each."""

    sequence: str
    frame: int
    job: str
    numbers: NDArray[np.int64]
    labels: NDArray[np.uint16]
    found: FrameResult


@dataclass(frozen=True)
class Retracted:
    """A run's provisional findings are void: it failed, or was cancelled without keeping."""

    sequence: str
    job: str
    frames: tuple[int, ...]


@dataclass(frozen=True)
class SequencesChanged:
    """A sequence was imported, renamed or deleted."""

    sequence: str


Event = Commit | Job | Provisional | Retracted | SequencesChanged
