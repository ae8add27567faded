"""Limits of reading files, and options for callers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, NotFoundError, TooLargeError
from pointbrush.formats.tables.corrections import Corrections
from pointbrush.frame import DepthCamera


@dataclass(frozen=True, slots=True)
class Limits:
    """Bounds of reading, checked before memory is allocated.

    With ``roots`` (resolved folders), no file outside them is read, also not by a link.
    """

    max_points: int = 500_000_000
    max_files: int = 200_000
    max_unpacked_bytes: int = 64 * 2**30
    max_archive_ratio: int = 200
    native_memory: int = 4 * 2**30
    native_stall_seconds: float = 60.0
    roots: tuple[Path, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Extras:
    """Data of a frame other than its points; the fields are as in PointFrame."""

    pose: NDArray[np.float64] | None = None
    viewpoint: NDArray[np.float64] | None = None
    timestamp: float | None = None
    camera: DepthCamera | None = None
    pixel: NDArray[np.uint32] | None = None


class UndecidedColorsError(Exception):
    """The colours of a file have an undecided range in the recording; ``high``: the greatest."""

    def __init__(self, kind: str, high: float) -> None:
        super().__init__(f"{kind} colours up to {high}")
        self.kind, self.high = kind, high


@dataclass(frozen=True, slots=True)
class ColorRange:
    """Greatest value of a colour in all files of a recording; None if not decided yet.

    ``whole`` for integers of more than 8 bits (255 or 65535), ``real`` for floats (1 or 255).
    """

    whole: int | None = None
    real: float | None = None

    def whole_for(self, high: int) -> int:
        """Return ``whole``; raises UndecidedColorsError."""
        if self.whole is None:
            raise UndecidedColorsError("whole", high)
        return self.whole

    def real_for(self, high: float) -> float:
        """Return ``real``; raises UndecidedColorsError."""
        if self.real is None:
            raise UndecidedColorsError("real", high)
        return self.real


@dataclass(frozen=True, slots=True)
class ReadOptions:
    """Options of reading a file.

    ``known``: data of the frame from the folder (a line of poses.txt, a time in its name); the
    file's own data take precedence.  ``colors``: range of colours in the recording; None: each
    file's own.  ``chosen``: the user's corrections.  ``columns_found`` is called with the columns
    of each file and their meanings, "" for columns that are left out.  ``class_number`` returns the
    number of a class by file and name if labels are words, the same in all files of a recording.
    """

    known: Extras = field(default_factory=Extras)
    limits: Limits = field(default_factory=Limits)
    colors: ColorRange | None = None
    chosen: Corrections = field(default_factory=Corrections)
    columns_found: Callable[[Mapping[str, str]], None] | None = None
    class_number: Callable[[str, str], int] | None = None

    @property
    def drop_invalid(self) -> bool:
        """Whether NaN and infinite points are left out instead of raising."""
        return self.chosen.drop_invalid


def require_count(name: str, count: int, limits: Limits) -> None:
    """Raise TooLargeError when ``count`` points exceed the limit, BadInputError below zero."""
    if count < 0:
        raise BadInputError(f"{name}: expected a number of points of 0 or more, got {count}")
    if count > limits.max_points:
        raise TooLargeError(f"{name}: expected at most {limits.max_points:,} points, got {count:,}")


def read_bytes(path: Path) -> bytes:
    """All bytes of a file; raises NotFoundError, or BadInputError when unreadable or empty."""
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise NotFoundError(f"{path}: expected a file, it does not exist") from None
    except OSError as error:
        raise BadInputError(f"{path}: expected a readable file, {error.strerror}") from None
    if not data:
        raise BadInputError(f"{path.name}: expected points, got an empty file (0 bytes)")
    return data
