"""Labels of frames as files state them, before labels of the palette are chosen for them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.boxes.scene import BoxTrack
from pointbrush.formats.times.matching import FrameName
from pointbrush.labels.types import Only
from pointbrush.sequences.storage.manifest import Manifest
from pointbrush.work.imports.naming import Key


@dataclass(frozen=True, eq=False)
class FrameLabels:
    """Labels of a frame.

    ``rows`` (n,): labelled points, source order; ``key_index`` (n,): the place of each one's key in
    ``keys``.
    """

    frame: int
    file: str
    rows: NDArray[np.int64]
    key_index: NDArray[np.int64]
    keys: tuple[Key, ...]
    more_files: tuple[str, ...] = ()
    """Further files with labels of the frame, such as masks of other cameras."""
    only: Only = "any"
    """Points that may change, as in ``Write``."""
    doubtful: int = 0
    """Number of points that masks do not decide: at their borders, or cameras disagree."""


@dataclass(frozen=True, eq=False)
class FoundBoxes:
    """Boxes of objects with the keys of their labels; ``empty``: skipped boxes with a side of 0."""

    tracks: tuple[tuple[Key, BoxTrack], ...]
    empty: int = 0


@dataclass(frozen=True, eq=False)
class Unmatched:
    """A file without a matching frame."""

    file: str


def frame_names(manifest: Manifest) -> list[FrameName]:
    """Return the files and times that identify a recording's frames."""
    files = manifest.files or [""] * manifest.frames
    return [FrameName(*pair) for pair in zip(files, manifest.timestamps, strict=True)]
