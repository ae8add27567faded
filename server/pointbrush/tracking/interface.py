"""Interface of a tracking method: what it takes and gives.

Points are in stored order and local coordinates throughout; transforms name their direction.
Everything a method yields pickles, so that it can run in another process.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]
I64 = NDArray[np.int64]
Mask = NDArray[np.bool_]

State = Literal["painted", "tracked", "occluded", "lost"]
Overwrite = Literal["never", "tracked", "all"]

PAINTED = 1
"""Provenance of a point that a person painted."""


class PixelLattice(Protocol):
    """Pixels that a frame's points lie on, as ``sequences`` keeps them: ``Lattice`` is one."""

    @property
    def width(self) -> int:
        """Columns of the image."""

    @property
    def height(self) -> int:
        """Rows of the image."""

    @property
    def axis(self) -> int:
        """The axis of the frame along which the camera looks."""

    @property
    def sign(self) -> float:
        """1 where it looks to greater coordinates, else -1."""

    @property
    def tangent(self) -> tuple[float, float]:
        """Tangents of the first column and row, along the other two axes."""

    @property
    def pitch(self) -> tuple[float, float]:
        """Tangents from column to column and row to row."""

    @property
    def eye(self) -> tuple[float, float, float]:
        """The camera's place, local metres."""


class TrackFrame(Protocol):
    """One frame as tracking sees it; ``StoredFrame`` is one.

    ``xyz`` (N, 3) float32 metres; ``rgb`` (N, 3) uint8 or None; ``intensity`` (N,) float32 or
    None; ``kdtree`` over ``xyz``; ``viewpoint`` (3,) sensor position or None where unknown;
    ``pose`` (4, 4) ``T_world_frame`` or None where the sensor stands still; ``lattice`` the
    pixels of its camera, where the import found them, or None.
    """

    @property
    def xyz(self) -> F32:
        """(N, 3) positions."""

    @property
    def rgb(self) -> NDArray[np.uint8] | None:
        """(N, 3) colours."""

    @property
    def intensity(self) -> F32 | None:
        """(N,) intensities."""

    @property
    def kdtree(self) -> cKDTree:
        """The stored tree."""

    @property
    def viewpoint(self) -> F64 | None:
        """(3,) sensor position."""

    @property
    def pose(self) -> F64 | None:
        """``T_world_frame``."""

    @property
    def lattice(self) -> PixelLattice | None:
        """The camera's pixels, where the import found them."""


@dataclass(frozen=True, slots=True, eq=False)
class PositionsFrame:
    """A ``TrackFrame`` of positions alone, by which its sensor is told."""

    xyz: F32
    viewpoint: F64 | None
    pose: F64 | None = None
    lattice: PixelLattice | None = None
    rgb: None = None
    intensity: None = None

    @property
    def kdtree(self) -> cKDTree:
        """A tree made for this call."""
        from scipy.spatial import cKDTree as Tree

        return Tree(self.xyz, balanced_tree=False)


Frames = Callable[[int], TrackFrame]
"""Frame number → frame."""


@dataclass(frozen=True, slots=True, eq=False)
class Seed:
    """The points of ``label`` in the start frame: ``indices`` (M,) int64, stored order."""

    label: int
    indices: I64


@dataclass(frozen=True, slots=True, eq=False)
class FrameKnowledge:
    """Labels already written on a frame: (N,) arrays in stored order."""

    label: NDArray[np.uint16]
    provenance: NDArray[np.uint8]
    deleted: Mask


Known = Callable[[int], FrameKnowledge | None]
"""Frame number → what is known of it, None where nothing is."""


@dataclass(frozen=True, slots=True)
class KnownSensor:
    """Facts about a recording's sensor that hold for every run over it.

    ``at_rest``    all of the recording shows it at rest; else a run has to look for itself.
    ``place``      (x, y, z) of a camera that the recording does not tell, local metres, or None.
    ``placeless``  such a place was looked for, and there is none.
    """

    at_rest: bool = False
    place: tuple[float, float, float] | None = None
    placeless: bool = False


@dataclass(frozen=True, slots=True)
class TrackOptions:
    """Options of a run: what it may overwrite, and when it stops.

    ``overwrite``      which labelled points a run may take: "never" any, "tracked" those that
                       no one painted, "all".
    ``locked``         labels whose points are never taken.
    ``continue_lost``  go on looking after the first lost frame of a label.
    ``until_painted``  a label's run ends at the next frame where it is painted, so that a
                       correction re-tracks only up to what a person has confirmed.
    ``before``         frames before the start, the farthest first, whose labels a method may
                       learn from; it yields nothing for them.
    ``painted``        the frames in which a person painted, None where that is not known.
    ``read_ahead``     a method may prepare the next frame in a thread of its own.
    ``sensor``         what is known of the recording's sensor, so that a run need not find it.
    """

    overwrite: Overwrite = "tracked"
    locked: frozenset[int] = field(default_factory=frozenset)
    continue_lost: bool = False
    until_painted: bool = False
    before: tuple[int, ...] = ()
    painted: frozenset[int] | None = None
    read_ahead: bool = False
    sensor: KnownSensor = field(default_factory=KnownSensor)


@dataclass(frozen=True, slots=True, eq=False)
class TrackState:
    """Outcome of a label in one frame.

    ``pose`` (4, 4) float64 ``T_frame_start``; ``rmse`` metres over the inliers of the fit;
    ``inliers`` share 0..1 of the visible model that was found; ``confidence`` 0..1;
    ``points`` number of points assigned.
    """

    pose: F64
    rmse: float
    inliers: float
    confidence: float
    points: int
    state: State


@dataclass(frozen=True, slots=True, eq=False)
class FrameResult:
    """Result of a run in frame ``frame``.

    ``assignments``  label → sorted stored indices (int64); labels share no point.  The start
                     frame, and a label that is not found, have none.
    ``tracks``       label → state; a label that was stopped is absent.
    """

    frame: int
    assignments: Mapping[int, I64]
    tracks: Mapping[int, TrackState]


class Method(Protocol):
    """A way of carrying labels from frame to frame.

    ``track`` yields one FrameResult per entry of ``order``, ``order[0]`` (the start frame)
    first.  ``order`` ascends or descends; frames may be asked for in any order.  It must not
    raise on any frame content: what cannot be tracked is flagged.  Seeds are checked before.
    """

    def track(
        self,
        frames: Frames,
        order: Sequence[int],
        seeds: Sequence[Seed],
        known: Known,
        options: TrackOptions,
    ) -> Iterator[FrameResult]:
        """Carry ``seeds`` through ``order``; see the class."""
