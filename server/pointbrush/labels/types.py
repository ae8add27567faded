"""Values that go into the label store and come out of it.

Points are numbered in *stored order* everywhere in this package.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pointbrush.errors import ConflictError

Only = Literal["any", "labeled", "unlabeled", "not_painted", "predictable"]
PAINTED = 1
"""Provenance of a point that a person painted; 0 is none."""
TRACKED = 2
"""Provenance of a point that tracking found."""
IMPORTED = 3
"""Provenance of a point whose label came in with it."""
PREDICTED = 4
"""Provenance of a point that a classifier taught by example has labelled."""


class GapError(ConflictError):
    """The wanted revision is too far back for deltas: fetch the annotations whole."""

    title = "Revision gap"


@dataclass(frozen=True, slots=True)
class Label:
    """An entry of a sequence's palette; ``id`` 1..65534, ``color`` "#rrggbb".

    ``instance`` 0..65535 is the number of an instance where it came from, 0 for a class without
    instances; None: it came from nowhere.  ``position`` is its place in the palette; labels
    without one follow by their ids.
    """

    id: int
    name: str
    category: str = ""
    color: str = "#808080"
    locked: bool = False
    visible: bool = True
    instance: int | None = None
    position: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Write:
    """Changes that an edit wants made to points of one frame.

    ``indices``     (n,) strictly increasing point numbers.
    ``label``       a label id, (n,) uint16, or None: keep; 0 is unlabeled.
    ``provenance``  0..4, (n,) uint8, or None: keep.
    ``deleted``     bool, (n,) bool, or None: keep.
    ``only``        which points may change: all, those with a label, without one, those that no
                    person painted, or those that have no label, or a predicted one, and that no
                    person erased.  Evaluated when the edit commits.
    ``living``      True: only points that are not deleted; False: only deleted ones; None: both.
                    Evaluated when the edit commits.
    ``hidden``      None: hiding does not matter.  Otherwise points of labels that the palette hides
                    when the edit commits keep, and of these that only its author hides (0: points
                    without a label).
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
    """Points of one frame whose visible values changed, and their values now.

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
"""Deltas by frame; None where so many points changed that reading all values is the shorter way."""


@dataclass(frozen=True, slots=True, eq=False)
class FrameValues:
    """A run of a frame's annotation: label (n,) uint16, provenance (n,) uint8, deleted (n,) bool.

    ``confidence`` (n,) uint8 of predicted points, 0 of others.
    ``revision`` is the sequence's at the moment of reading, ``changed`` that of the frame's last
    change until then (0: none).
    """

    label: NDArray[np.uint16]
    provenance: NDArray[np.uint8]
    deleted: NDArray[np.bool_]
    confidence: NDArray[np.uint8]
    revision: int
    changed: int


@dataclass(frozen=True, slots=True)
class Cell:
    """Number of points of a frame that have a label, and of those that a person painted.

    Deleted points do not count.
    """

    frame: int
    label: int
    points: int
    painted: int


@dataclass(frozen=True, slots=True, eq=False)
class Commit:
    """One committed revision of a sequence.

    ``revision`` is the sequence's after it and ``base`` the one before it; ``changed`` counts
    points whose visible value changed; ``target`` is the edit that an undo or redo was about;
    ``label`` is the one that it made or changed, as it left it, unless it is read from the journal;
    ``boxes`` are the ids of those that changed, came or went;
    ``repeated`` is True when this edit's id had been committed before and nothing was done now.
    """

    sequence: str
    edit_id: str
    revision: int
    author: str
    kind: str
    summary: str
    changed: int
    time: float = 0.0
    target: str | None = None
    label: Label | None = None
    repeated: bool = False
    frames: Deltas = field(default_factory=dict)
    palette_changed: bool = False
    tracks_changed: bool = False
    boxes: tuple[int, ...] = ()
    cells: tuple[Cell, ...] = ()

    @property
    def base(self) -> int:
        """The revision that the deltas apply to."""
        return self.revision - 1


@dataclass(frozen=True, slots=True)
class Progress:
    """Frames with labelled points, labels that have points somewhere, and labels in all.

    ``changed``: time of the last edit, seconds since the epoch, or None.
    """

    frames: int = 0
    used: int = 0
    labels: int = 0
    changed: float | None = None


@dataclass(frozen=True, slots=True)
class EditInfo:
    """A line of the history; ``time`` is seconds since the epoch.

    ``undone``: taken back by its author and not brought back; ``target``: the edit that an
    undo or redo was about.
    """

    id: str
    revision: int
    author: str
    time: float
    kind: str
    summary: str
    points: int
    frames: tuple[int, ...]
    undone: bool
    target: str | None = None
