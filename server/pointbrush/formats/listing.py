"""The frames of a recording before they are read."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from pointbrush.formats.options import Extras, ReadOptions
from pointbrush.frame import PointFrame


@dataclass(frozen=True, slots=True)
class FrameFile:
    """A file to read with ``read``, and what its folder tells of its frame."""

    read: Callable[[ReadOptions], Iterator[PointFrame]]
    known: Extras = field(default_factory=Extras)


@dataclass(frozen=True, slots=True)
class Listing:
    """The frames of a folder; ``count`` is None where a file holds an unknown number."""

    format: str
    frames: list[FrameFile]
    times: list[float] | None = None
    fps: float | None = None
    count: int | None = None
