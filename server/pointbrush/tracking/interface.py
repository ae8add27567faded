"""Interface of a tracking method: inputs and results.

Points are in stored order and local coordinates throughout; transforms name their direction.
All results are picklable, so that a method can run in another process.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
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
USUAL_FPS = 5.0
"""Frames per second of a recording without a known rate."""


class PixelLattice(Protocol):
    """Pixel lattice of a frame's points; ``sequences`` has an implementation, ``Lattice``."""

    @property
    def width(self) -> int:
        """Number of columns of the image."""

    @property
    def height(self) -> int:
        """Number of rows of the image."""

    @property
    def axis(self) -> int:
        """The axis of the frame along which the camera looks."""

    @property
    def sign(self) -> float:
        """1 if it looks to greater coordinates, else -1."""

    @property
    def tangent(self) -> tuple[float, float]:
        """Tangents of the first column and row, along the other two axes."""

    @property
    def pitch(self) -> tuple[float, float]:
        """Tangents from column to column and row to row."""

    @property
    def eye(self) -> tuple[float, float, float]:
        """The camera's position, in local metres."""


class SensorPart(Protocol):
    """One sensor of a frame that has several; ``sequences`` has an implementation."""

    @property
    def sensor(self) -> int:
        """Number of the sensor in the recording."""

    @property
    def T_frame_sensor(self) -> F64:  # noqa: N802  (named for its direction)
        """(4, 4) its mount: its coordinates to local metres."""

    @property
    def lattice(self) -> PixelLattice | None:
        """Its pixels in its own coordinates, if the import found them."""


class TrackFrame(Protocol):
    """A frame for tracking; ``StoredFrame`` is an implementation.

    ``xyz`` (N, 3): float32 metres; ``rgb`` (N, 3): uint8 or None; ``intensity`` (N,): float32 or
    None; ``kdtree``: tree of ``xyz``; ``viewpoint`` (3,): sensor position, None if unknown;
    ``pose`` (4, 4): ``T_world_frame``, None for a sensor at rest; ``lattice``: pixels of its
    camera if the import found them, else None.  In a frame of several sensors, ``sensor`` (N,) is
    the number of each point's sensor, and ``parts`` has those sensors; else it is None.
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
        """The camera's pixels, if the import found them."""

    @property
    def sensor(self) -> NDArray[np.uint8] | None:
        """(N,) number of each point's sensor; None for one sensor."""

    @property
    def parts(self) -> Sequence[SensorPart]:
        """The sensors of a frame that has several; undefined for one sensor."""


@dataclass(frozen=True, eq=False)
class ArrayFrame:
    """A ``TrackFrame`` of arrays in memory."""

    xyz: F32
    viewpoint: F64 | None
    pose: F64 | None = None
    lattice: PixelLattice | None = None
    rgb: NDArray[np.uint8] | None = None
    intensity: F32 | None = None
    sensor: NDArray[np.uint8] | None = None
    parts: Sequence[SensorPart] = ()

    @cached_property
    def kdtree(self) -> cKDTree:
        """A tree built on first use."""
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
"""Function of the frame number: known labels of the frame, or None."""


@dataclass(frozen=True, slots=True)
class KnownSensor:
    """Properties of a recording's sensor, valid for all runs.

    ``at_rest``    the whole recording shows it at rest; if False, a run has to check.
    ``place``      estimated (x, y, z) of a camera without a recorded position, local metres, or
                   None.
    ``placeless``  the search for such a position failed.
    """

    at_rest: bool = False
    place: tuple[float, float, float] | None = None
    placeless: bool = False


@dataclass(frozen=True, slots=True)
class TrackOptions:
    """Options of a run.

    ``overwrite``      labelled points that a run may take: "never" none, "tracked" points not
                       painted by a person, "all".
    ``locked``         labels with points that are never taken.
    ``continue_lost``  continue the search after the first lost frame of a label.
    ``until_painted``  end a label's run at the next frame where it is painted, so that a
                       correction re-tracks only up to the next confirmed frame.
    ``before``         labelled frames before the start, the farthest first, as examples for a
                       method; it yields no results for them.
    ``painted``        the frames in which a person painted, None if unknown.
    ``read_ahead``     a method may prepare the next frame in a separate thread.
    ``sensor``         known properties of the recording's sensor, which a run need not estimate.
    ``fps``            frames per second of the recording.
    """

    overwrite: Overwrite = "tracked"
    locked: frozenset[int] = field(default_factory=frozenset)
    continue_lost: bool = False
    until_painted: bool = False
    before: tuple[int, ...] = ()
    painted: frozenset[int] | None = None
    read_ahead: bool = False
    sensor: KnownSensor = field(default_factory=KnownSensor)
    fps: float = USUAL_FPS


@dataclass(frozen=True, slots=True, eq=False)
class TrackState:
    """Outcome of a label in one frame.

    ``pose`` (4, 4): float64 ``T_frame_start``; ``rmse``: metres over the inliers of the fit;
    ``inliers``: share, 0 to 1, of the visible model that was found; ``confidence``: 0 to 1;
    ``points``: number of points assigned.
    """

    pose: F64
    rmse: float
    inliers: float
    confidence: float
    points: int
    state: State

    @staticmethod
    def painted(points: int, pose: F64) -> TrackState:
        """Return the outcome of a label that a person painted."""
        return TrackState(pose, 0.0, 1.0, 1.0, points, "painted")


@dataclass(frozen=True, slots=True, eq=False)
class FrameResult:
    """Result of a run in frame ``frame``.

    ``assignments``  label → sorted stored indices (int64), disjoint.  The start frame, and labels
                     that are not found, have none.
    ``tracks``       label → state; stopped labels are absent.
    """

    frame: int
    assignments: Mapping[int, I64]
    tracks: Mapping[int, TrackState]


class Method(Protocol):
    """A tracking method.

    ``track`` yields one FrameResult per entry of ``order``, ``order[0]`` (the start frame)
    first.  ``order`` ascends or descends; frames may be read in any order.  It must not raise for
    any frame content: labels that cannot be tracked are flagged.  Seeds are validated beforehand.
    """

    def track(
        self,
        frames: Frames,
        order: Sequence[int],
        seeds: Sequence[Seed],
        known: Known,
        options: TrackOptions,
    ) -> Iterator[FrameResult]:
        """Track ``seeds`` through ``order``; see the class."""
