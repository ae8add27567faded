"""Candidates for clicks on an object."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from pointbrush.values.base import Value

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class PointRuns(Value):
    """Base of values with runs of points of a frame."""

    __slots__ = ()
    runs: tuple[tuple[int, int], ...]

    @property
    def numbers(self) -> NDArray[np.int64]:
        """The numbers of its points (n,), source order."""
        import numpy as np

        parts = [np.arange(first, first + count) for first, count in self.runs]
        return np.concatenate(parts) if parts else np.empty(0, np.int64)


@dataclass(frozen=True, slots=True)
class Candidate(PointRuns):
    """Points that a click may select."""

    id: str
    """Id for the ``candidate`` of a stroke of shape ``object``."""
    level: int
    """Size of the part: 0 the smallest."""
    score: float
    """Estimated quality as an object, 0 to 1."""
    points: int
    """Number of its points."""
    runs: tuple[tuple[int, int], ...]
    """Runs of its points in source order: first number and length."""


@dataclass(frozen=True, slots=True)
class Candidates(Value):
    """At most six candidates, from part to group."""

    candidates: tuple[Candidate, ...]
    """The candidates, the smallest part first."""
    first: int
    """Index of the one to show first."""
    ready: bool
    """The whole frame is prepared; else candidates come from points near the clicks."""
