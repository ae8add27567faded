"""The labels of one sequence as a stroke sees them: many questions, few looks at the database."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from pointbrush.labels import reading
from pointbrush.labels.sessions import Sessions
from pointbrush.labels.state import NotInMemoryError
from pointbrush.labels.types import FrameValues, Label
from pointbrush.labels.writes import require_paintable

FRESH_SECONDS = 0.02
"""After a look at the database another one is made at the earliest."""


class View:
    """Labels of a sequence as this process knows them, its own commits included; thread-safe.

    Other processes' commits are seen after ``look``.  An edit that commits looks by itself.
    """

    def __init__(self, sessions: Sessions, sequence: str) -> None:
        """``sequence`` has just been looked at."""
        self._sessions, self._sequence = sessions, sequence
        self._looked = time.monotonic()

    def look(self) -> None:
        """Take in what other processes committed; raises NotFoundError, UnavailableError."""
        if time.monotonic() - self._looked > FRESH_SECONDS:
            with self._sessions.knowing(self._sequence):
                self._looked = time.monotonic()

    def values(self, frame: int, first: int, count: int | None) -> FrameValues:
        """Annotation of points [first, first + count) of a frame, as far as it has them."""
        try:
            with self._sessions.knowing(self._sequence, look=False) as state:
                return reading.values(None, state, frame, first, count)
        except NotInMemoryError:
            with self._sessions.reading(self._sequence) as (connection, state):
                return reading.values(connection, state, frame, first, count)

    def at(self, frame: int, numbers: NDArray[np.int64]) -> FrameValues:
        """Annotation of sorted point ``numbers`` (n,) of a frame."""
        try:
            with self._sessions.knowing(self._sequence, look=False) as state:
                return reading.at(None, state, frame, numbers)
        except NotInMemoryError:
            with self._sessions.reading(self._sequence) as (connection, state):
                return reading.at(connection, state, frame, numbers)

    def palette(self) -> dict[int, Label]:
        """The labels by their ids."""
        with self._sessions.knowing(self._sequence, look=False) as state:
            return state.palette

    def hidden(self) -> NDArray[np.bool_]:
        """For each label id 0..65535, whether the palette hides it."""
        with self._sessions.knowing(self._sequence, look=False) as state:
            return state.hidden

    def require_paintable(self, label: int, hidden: frozenset[int] | None = None) -> None:
        """Raise as ``LabelStore.require_paintable`` does."""
        require_paintable(self.palette(), label, hidden)
