"""Input and output types of the label store.

Points are numbered in *stored order* everywhere in this package.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pointbrush.errors import ConflictError
from pointbrush.values import labels as values
from pointbrush.values.edits import Edit, PastEdit

Only = Literal["any", "labeled", "unlabeled", "not_painted", "predictable"]
PAINTED = 1
"""Provenance of a point that a person painted; 0 is none."""
TRACKED = 2
"""Provenance of a point that tracking found."""
IMPORTED = 3
"""Provenance of a point with an imported label."""
PREDICTED = 4
"""Provenance of a point that a model labelled."""
FULL_CONFIDENCE = 255
"""Confidence of a certain prediction; 0 is none."""


class GapError(ConflictError):
    """The requested revision is too old for deltas; fetch whole annotations."""

    title = "Revision gap"


@dataclass(frozen=True, slots=True)
class Label(values.Label):
    """An entry of a sequence's palette.

    ``instance`` 0..65535 is the instance number in the imported file, 0 for a class without
    instances; None: not imported.  ``position`` is its index in the palette; labels without one
    follow by id.
    """

    category: str = ""
    color: str = "#808080"
    locked: bool = False
    visible: bool = True
    instance: int | None = None
    position: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Write:
    """Requested changes of an edit to points of one frame.

    ``indices``     (n,) strictly increasing point numbers.
    ``label``       a label id, (n,) uint16, or None: keep; 0 is unlabeled.
    ``provenance``  0..4, (n,) uint8, or None: keep.
    ``deleted``     bool, (n,) bool, or None: keep.
    ``only``        points that may change: all, labeled, unlabeled, not painted by a person, or
                    predictable (predicted, or unlabeled and not erased by a person).  Evaluated
                    when the edit commits.
    ``living``      True: only points that are not deleted; False: only deleted ones; None: both.
                    Evaluated when the edit commits.
    ``hidden``      None: also change hidden points.  Otherwise points of labels that the palette
                    hides when the edit commits are not changed, nor points of these labels, which
                    only its author hides (0: points without a label).
    ``confidence``  0..255, (n,) uint8, kept in 32 steps, beside a provenance; None: 0.
    """

    indices: NDArray[Any]
    label: ArrayLike | None = None
    provenance: ArrayLike | None = None
    deleted: ArrayLike | None = None
    only: Only = "any"
    living: bool | None = None
    hidden: frozenset[int] | None = None
    confidence: ArrayLike | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Delta:
    """Points of one frame with changed visible values, and their new values.

    ``indices`` (n,) uint32 sorted, ``label`` (n,) uint16, ``provenance`` (n,) uint8,
    ``deleted`` (n,) bool.
    """

    indices: NDArray[np.uint32]
    label: NDArray[np.uint16]
    provenance: NDArray[np.uint8]
    deleted: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.indices)


Deltas = Mapping[int, Delta | None]
"""Deltas by frame; None: so many points changed that reading all values is shorter."""


@dataclass(frozen=True, slots=True, eq=False)
class FrameValues:
    """A run of a frame's annotation: label (n,) uint16, provenance (n,) uint8, deleted (n,) bool.

    ``confidence`` (n,) uint8 of predicted points, 0 of others.  ``revision`` is the sequence's
    revision at the read, ``changed`` the revision of the frame's last change (0: none).
    """

    label: NDArray[np.uint16]
    provenance: NDArray[np.uint8]
    deleted: NDArray[np.bool_]
    confidence: NDArray[np.uint8]
    revision: int
    changed: int


@dataclass(frozen=True, slots=True)
class Cell:
    """Number of points of a frame with a label, and of painted points among them.

    Deleted points do not count.
    """

    frame: int
    label: int
    points: int
    painted: int


@dataclass(frozen=True, slots=True, eq=False)
class Commit(Edit):
    """One committed revision of a sequence.

    ``target`` is the edit that an undo or redo reverses; ``label`` is the label that it created or
    changed, after the edit, unless the commit is read from the journal; ``boxes`` are the ids of
    changed, created and removed boxes; ``repeated`` is True if this edit's id was committed before
    and nothing was done now.
    """

    sequence: str
    author: str
    kind: str
    summary: str
    time: float = 0.0
    target: str | None = None
    label: Label | None = None
    repeated: bool = False
    frames: Deltas = field(default_factory=dict)
    palette_changed: bool = False
    tracks_changed: bool = False
    boxes: tuple[int, ...] = ()
    cells: tuple[Cell, ...] = ()


@dataclass(frozen=True, slots=True)
class Progress:
    """Number of frames with labelled points, of labels with points, and of all labels.

    ``changed``: time of the last edit, seconds since the epoch, or None.
    """

    frames: int = 0
    used: int = 0
    labels: int = 0
    changed: float | None = None


@dataclass(frozen=True, slots=True)
class EditInfo(PastEdit):
    """A line of the history with the account of its author.

    ``target``: the edit that an undo or redo reverses.
    """

    target: str | None = None
