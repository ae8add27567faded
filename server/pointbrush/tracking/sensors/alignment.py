"""Small corrections of the mounts of several sensors, from surfaces that they share.

Each sensor but the first is moved so that its surfaces fall on those of all others, in several
frames at once: robust least squares of distances from points to planes (Chen and Medioni 1992),
with the pairs of points renewed in each round (Besl and McKay 1992).  Pairs become shorter from
round to round; as this can end too early, the rounds are repeated until the mounts are settled.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import permutations

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from pointbrush.errors import ConflictError
from pointbrush.tracking.compute.grid import cells_of, means_of
from pointbrush.tracking.compute.rigid import inverse, transform
from pointbrush.tracking.interface import F64, I64


@dataclass(frozen=True, slots=True)
class AlignmentOptions:
    """Numbers of the registration."""

    cell_spacings: float = 1.5  # size of the cells whose means are compared, in point spacings
    least_cell_m: float = 0.025  # smallest size of a cell
    most_points: int = 6000  # points of a sensor in a frame that are compared
    neighbours: int = 20  # cells that define a normal
    flat_share: float = 0.06  # most variance along the normal, of all variance of a surface
    facing_cos: float = 0.1  # least cosine between the normal and the ray
    alike_cos: float = 0.75  # least cosine between the normals of a pair
    reach_cells: tuple[float, float] = (10.0, 2.0)  # longest pairs of the first and last rounds
    rounds: int = 25
    sweeps: int = 4  # times that all rounds are repeated at most, from the longest pairs on
    settled: float = 1e-3  # change of the mounts in a sweep, metres and radians, that is the last
    robust: float = 2.5  # standard deviations at which a pair has no weight
    least_pairs: int = 300  # pairs of a sensor in all frames, below which nothing overlaps
    correlated: float = 8.0  # ratio of the error of a correction to that of independent pairs
    most_error_m: float = 0.03  # largest standard error of a point at the scene's distance
    most_shift_m: float = 0.3  # largest correction that counts as small
    most_turn_deg: float = 10.0


@dataclass(frozen=True, eq=False)
class SensorPoints:
    """The points ``xyz`` (N, 3) of a ``sensor`` in a frame, in its coordinates, and its mount."""

    sensor: int
    T_frame_sensor: F64
    xyz: F64


@dataclass(frozen=True, slots=True, eq=False)
class Correction:
    """Correction of a sensor's mount, ``mount @ T``, and its effect.

    ``before`` and ``after``: median distances (m) of its points from the others' surfaces;
    ``pairs``: number of these points.
    """

    T: F64
    before: float
    after: float
    pairs: int

    @property
    def shift(self) -> float:
        """Metres by which the sensor moves."""
        return float(np.linalg.norm(self.T[:3, 3]))

    @property
    def turn(self) -> float:
        """Degrees by which the sensor turns."""
        return float(np.degrees(np.linalg.norm(Rotation.from_matrix(self.T[:3, :3]).as_rotvec())))


@dataclass(frozen=True, eq=False)
class _Surface:
    """Flat cells of a sensor in a frame, in its coordinates, with ``normal`` (C, 3) towards it."""

    sensor: int
    mount: F64
    xyz: F64
    normal: F64
    some: I64

    @cached_property
    def tree(self) -> cKDTree:
        """Tree of ``xyz``."""
        return cKDTree(self.xyz)

    @staticmethod
    def of(points: SensorPoints, size: float, options: AlignmentOptions) -> _Surface:
        """Return the surface of cells of ``size`` metres."""
        xyz = means_of(points.xyz, cells_of(points.xyz, size))
        count = min(options.neighbours, len(xyz))
        _, number = cKDTree(xyz).query(xyz, count)
        near = xyz[np.reshape(number, (len(xyz), count))]
        offset = near - near.mean(axis=1, keepdims=True)
        values, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", offset, offset))
        normal = axes[:, :, 0]
        ray = -xyz / np.maximum(np.linalg.norm(xyz, axis=1, keepdims=True), 1e-9)
        cosine = np.einsum("ij,ij->i", normal, ray)
        flat = values[:, 0] < options.flat_share * values.sum(axis=1)
        # An edge has neighbours along one axis only.
        flat &= values[:, 1] > options.flat_share * values.sum(axis=1)
        kept = np.flatnonzero(flat & (np.abs(cosine) > options.facing_cos))
        some = np.arange(0, len(kept), max(1, -(-len(kept) // options.most_points)))
        return _Surface(
            points.sensor,
            points.T_frame_sensor,
            xyz[kept],
            normal[kept] * np.sign(cosine[kept])[:, None],
            some,
        )


@dataclass(frozen=True, slots=True, eq=False)
class _Pairs:
    """Pairs of points ``a`` (P, 3) and ``b`` (P, 3) of two surfaces, in their coordinates."""

    one: _Surface
    other: _Surface
    a: F64
    b: F64
    normal: F64
    """(P, 3) normals of ``b``, in the frame's coordinates."""
    off: F64
    """(P,) metres of ``a`` in front of the plane at ``b``."""

    @property
    def rows(self) -> tuple[F64, F64]:
        """(P, 6) derivatives of ``off`` by turns and shifts of both sensors in their axes."""
        result = []
        for surface, at, sign in ((self.one, self.a, 1.0), (self.other, self.b, -1.0)):
            own = self.normal @ surface.mount[:3, :3]
            result.append(sign * np.hstack([np.cross(at, own), own]))
        return result[0], result[1]


@dataclass(eq=False)
class _Registration:
    """Surfaces of all sensors in each frame, and the corrections found so far."""

    frames: list[list[_Surface]]
    size: float
    options: AlignmentOptions
    T: dict[int, F64] = field(default_factory=dict)

    def pairs(self, reach: float) -> Iterator[_Pairs]:
        """Yield the pairs of each two sensors in each frame, at most ``reach`` metres long."""
        for frame in self.frames:
            for one, other in permutations(frame, 2):
                if len(other.xyz):
                    yield self._paired(one, other, reach)

    def _paired(self, one: _Surface, other: _Surface, reach: float) -> _Pairs:
        T_one, T_other = (s.mount @ self.T[s.sensor] for s in (one, other))
        a = one.xyz[one.some]
        world = transform(T_one, a)
        own = transform(inverse(T_other), world)
        near = np.asarray(other.tree.query(own, distance_upper_bound=reach)[1])
        found = np.flatnonzero(near < len(other.xyz))
        near, world = near[found], world[found]
        normal = other.normal[near] @ T_other[:3, :3].T
        facing = one.normal[one.some][found] @ T_one[:3, :3].T
        alike = np.einsum("ij,ij->i", normal, facing) > self.options.alike_cos
        b = other.xyz[near[alike]]
        off = np.einsum("ij,ij->i", world[alike] - transform(T_other, b), normal[alike])
        return _Pairs(one, other, a[found[alike]], b, normal[alike], off)

    def step(self, reach: float) -> tuple[F64, F64]:
        """Move the sensors by a step of least squares; return its matrix and its variance."""
        moved = sorted(self.T)[1:]
        size = 6 * len(moved)
        H, g, pairs = np.zeros((size, size)), np.zeros(size), list(self.pairs(reach))
        off = np.concatenate([each.off for each in pairs])
        sigma = 1.4826 * float(np.median(np.abs(off))) + 1e-6
        for each in pairs:
            ratio = np.clip(each.off / (self.options.robust * sigma), -1.0, 1.0)
            weight = (1.0 - ratio**2) ** 2
            rows = np.zeros((len(each.off), size))
            for surface, part in zip((each.one, each.other), each.rows, strict=True):
                if surface.sensor in moved:
                    at = 6 * moved.index(surface.sensor)
                    rows[:, at : at + 6] = part
            H += rows.T @ (weight[:, None] * rows)
            g += rows.T @ (weight * each.off)
        found = -np.linalg.solve(H + 1e-9 * np.trace(H) * np.eye(size), g)
        for sensor, (turn, shift) in zip(moved, found.reshape(-1, 2, 3), strict=True):
            D = np.eye(4)
            D[:3, :3], D[:3, 3] = Rotation.from_rotvec(turn).as_matrix(), shift
            self.T[sensor] = self.T[sensor] @ D
        return H, np.asarray(sigma**2)

    def residuals(self, reach: float) -> dict[int, tuple[float, int]]:
        """Return the median distance (m) of each sensor's pairs, and their number."""
        off: dict[int, list[F64]] = {sensor: [np.empty(0)] for sensor in self.T}
        for each in self.pairs(reach):
            off[each.one.sensor].append(np.abs(each.off))
        joined = {sensor: np.concatenate(each) for sensor, each in off.items()}
        return {n: (float(np.median(x)) if len(x) else 0.0, len(x)) for n, x in joined.items()}


def align_mounts(
    frames: Sequence[Sequence[SensorPoints]],
    names: Sequence[str],
    options: AlignmentOptions | None = None,
) -> list[Correction]:
    """Return the correction of each sensor's mount; that of the first one is the identity.

    ``names``: of all sensors, for errors.  Raises ConflictError for a sensor without shared
    surfaces, and for surfaces that do not determine its position.
    """
    options = options or AlignmentOptions()
    size = _cell_size(frames, options)
    surfaces = [[_Surface.of(p, size, options) for p in frame if len(p.xyz)] for frame in frames]
    identity = {number: np.eye(4) for number in range(len(names))}
    found = _Registration(surfaces, size, options, identity)
    first, last = (cells * size for cells in options.reach_cells)
    before = found.residuals(first)
    _require_overlap(found, first, names)
    for _ in range(options.sweeps):
        earlier = dict(found.T)
        for reach in np.geomspace(first, last, options.rounds):
            H, variance = found.step(float(reach))
        if max(np.abs(found.T[n] - earlier[n]).max() for n in found.T) < options.settled:
            break
    after = found.residuals(first)
    _require_determined(found, H, float(variance), names)
    corrections = [
        Correction(found.T[n], before[n][0], after[n][0], after[n][1]) for n in range(len(names))
    ]
    _require_small(corrections, names, options)
    return corrections


def _cell_size(frames: Sequence[Sequence[SensorPoints]], options: AlignmentOptions) -> float:
    """Return a size of cells (m) that hold several points of every sensor."""
    spacings = []
    for points in frames[0]:
        some = points.xyz[:: max(1, len(points.xyz) // options.most_points)]
        if len(points.xyz) > 1:
            distance, _ = cKDTree(points.xyz).query(some, [2])
            spacings.append(float(np.median(distance)))
    return max(options.least_cell_m, options.cell_spacings * max(spacings, default=0.0))


def _require_overlap(found: _Registration, reach: float, names: Sequence[str]) -> None:
    """Raise ConflictError for sensors that share no surface with the first, directly or not."""
    count = np.zeros((len(names), len(names)), np.int64)
    for each in found.pairs(reach):
        count[each.one.sensor, each.other.sensor] += len(each.off)
    shared, known = count + count.T >= found.options.least_pairs, {0}
    for _ in names:
        known |= {n for n in range(len(names)) if shared[n, sorted(known)].any()}
    apart = [names[n] for n in range(len(names)) if n not in known]
    if apart:
        raise ConflictError(
            f"{', '.join(apart)}: no surface is also seen by another sensor, within "
            f"{reach:.2f} m; sensors are aligned by surfaces that two of them see"
        )


def _require_determined(
    found: _Registration, H: F64, variance: float, names: Sequence[str]
) -> None:
    """Raise ConflictError for a sensor that can slide along the surfaces that it shares."""
    options, moved = found.options, sorted(found.T)[1:]
    spread = np.linalg.pinv(H + 1e-12 * np.trace(H) * np.eye(len(H))) * variance
    for k, sensor in enumerate(moved):
        xyz = np.concatenate([s.xyz for frame in found.frames for s in frame if s.sensor == sensor])
        at = np.median(np.abs(xyz), axis=0).max() * np.ones(3)
        scale = np.diag([*at, 1.0, 1.0, 1.0])
        part = scale @ spread[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] @ scale
        error = options.correlated * float(np.sqrt(np.linalg.eigvalsh(part)[-1]))
        if error > options.most_error_m:
            raise ConflictError(
                f"{names[sensor]}: the surfaces that it shares with other sensors leave its "
                f"position open by {100 * error:.1f} cm, such as a floor alone; record surfaces "
                "that face different ways"
            )


def _require_small(
    corrections: Sequence[Correction], names: Sequence[str], options: AlignmentOptions
) -> None:
    """Raise ConflictError for a correction that is not small, and so probably wrong."""
    for name, each in zip(names, corrections, strict=True):
        if each.shift > options.most_shift_m or each.turn > options.most_turn_deg:
            raise ConflictError(
                f"{name}: expected an error of at most {100 * options.most_shift_m:.0f} cm and "
                f"{options.most_turn_deg:.0f}° of its mount, got {100 * each.shift:.0f} cm and "
                f"{each.turn:.0f}°; import the recording with better mounts"
            )
