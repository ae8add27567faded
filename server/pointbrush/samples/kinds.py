"""Sample recordings for users: frames, and the palette for their labels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from pointbrush.frame import PointFrame
from pointbrush.samples.aerial import CLASSES, aerial_tile
from pointbrush.samples.generating import generate
from pointbrush.samples.recording import LabelInfo, Lazy

MOST_TILES = 4


class Sample(Protocol):
    """A generated recording."""

    @property
    def name(self) -> str:
        """Its name."""

    @property
    def fps(self) -> float:
        """Frames a second."""

    @property
    def frames(self) -> Sequence[PointFrame]:
        """All frames, made on access."""

    @property
    def labels(self) -> Sequence[LabelInfo]:
        """The palette."""


@dataclass(frozen=True, slots=True)
class Aerial:
    """Tiles of land, one a frame, side by side."""

    seed: int
    count: int
    name: str = "Aerial"
    fps: float = 1.0
    labels: Sequence[LabelInfo] = CLASSES

    @property
    def frames(self) -> Sequence[PointFrame]:
        """The tiles, without their classes."""
        return Lazy(self.count, lambda i: replace(aerial_tile(self.seed + i), label=None))


def sample(kind: str, seed: int, frames: int) -> Sample:
    """Return a sample of a kind; raises BadInputError for an unknown one.

    ``frames``: number of frames, or of tiles of land, at most four.
    """
    if kind == "aerial":
        return Aerial(seed, min(frames, MOST_TILES))
    return generate(kind, seed=seed, frames=frames)
