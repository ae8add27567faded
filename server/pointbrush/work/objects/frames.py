"""A stored frame, or its part round a click, as selectors want it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection import Points
from pointbrush.selection.objects.options import SensorKind
from pointbrush.sequences import Manifest, StoredFrame
from pointbrush.work.objects.options import SensingOptions

if TYPE_CHECKING:
    from pointbrush.selection.objects import ObjectFrame

Floats = NDArray[np.float64]

SENSING = SensingOptions()


def object_frame(
    frame: StoredFrame, manifest: Manifest, members: NDArray[np.int64] | None = None
) -> ObjectFrame:
    """Return a frame, or its points ``members``, for ``Selector.prepare``."""

    def part(column: NDArray[np.generic] | None) -> NDArray[np.generic] | None:
        if column is None:
            return None
        return np.ascontiguousarray(column if members is None else column[members])

    # Here, since what is compiled is loaded with it.
    from pointbrush.selection.objects import ObjectFrame

    viewpoint = _viewpoint(frame, manifest)
    return ObjectFrame(
        xyz=np.ascontiguousarray(frame.coordinates[slice(None) if members is None else members]),
        rgb=part(frame.rgb),  # type: ignore[arg-type]
        intensity=part(frame.intensity),  # type: ignore[arg-type]
        viewpoint=viewpoint,
        sensor=sensor_kind(frame, viewpoint),
        T_room_local=manifest.T_room_local,
    )


def sensor_kind(frame: StoredFrame, viewpoint: Floats | None) -> SensorKind:
    """Tell a depth camera, a spinning lidar and a scan joined from many views apart.

    From one sensor's place hardly any point lies behind another one.
    """
    if frame.pixel is not None:
        return "camera"
    if frame.count == 0:
        return "room"
    xyz = np.asarray(
        frame.coordinates[: SENSING.sample], np.float64
    )  # the first points are an even subsample
    xyz = xyz[np.isfinite(xyz).all(axis=1)]
    extent = float(np.ptp(xyz, axis=0).max(initial=0.0))
    away = xyz - (np.zeros(3) if viewpoint is None else viewpoint)
    distance = np.linalg.norm(away, axis=1)
    away, distance = away[distance > 1e-6], distance[distance > 1e-6]
    if len(away) and _behind(away, distance) <= SENSING.one_view:
        return "lidar" if _round(away, distance) >= SENSING.all_round else "camera"
    return "lidar" if extent > SENSING.open_air else "room"


def _behind(away: Floats, distance: Floats) -> float:
    """Share of points behind the nearest one of their direction."""
    cells = max(1, round(np.sqrt(len(away) / SENSING.per_direction / 6)))
    # Faces of a cube round the sensor, each with a grid: directions without poles.
    axis = np.abs(away).argmax(axis=1)
    rows = np.arange(len(away))
    ahead = away[rows, axis]
    across = away[rows, (axis + 1) % 3] / np.abs(ahead)
    down = away[rows, (axis + 2) % 3] / np.abs(ahead)
    column, row = (
        np.minimum(((t + 1) / 2 * cells).astype(np.int64), cells - 1) for t in (across, down)
    )
    cell = ((axis * 2 + (ahead > 0)) * cells + column) * cells + row
    nearest = np.full(6 * cells * cells, np.inf)
    np.minimum.at(nearest, cell, distance)
    return float(np.mean(distance > SENSING.behind * nearest[cell]))


def _round(away: Floats, distance: Floats) -> float:
    """Largest share of a full turn that has points, about any axis of the coordinates."""
    shares = []
    for axis in range(3):
        a, b = away[:, (axis + 1) % 3], away[:, (axis + 2) % 3]
        level = np.hypot(a, b) > 0.5 * distance
        turns = ((np.arctan2(a[level], b[level]) / (2 * np.pi) + 0.5) * 36).astype(np.int64)
        shares.append(len(np.unique(np.minimum(turns, 35))) / 36)
    return max(shares)


def _viewpoint(frame: StoredFrame, manifest: Manifest) -> Floats | None:
    """The sensor's place, local metres: told, or the origin of what lies round it."""
    if frame.viewpoint is not None:
        return np.asarray(frame.viewpoint, np.float64)
    origin = -np.asarray(manifest.shift, np.float64)
    lo, hi = np.asarray(manifest.lo), np.asarray(manifest.hi)
    size = float(np.max(hi - lo, initial=0.0))
    return origin if ((origin >= lo - size) & (origin <= hi + size)).all() else None


def near(points: Points, middle: Floats, reach: float, most: int) -> NDArray[np.int64]:
    """Return numbers of the points round a place (3,), in a cube with at most ``most`` of them."""
    first = points.blocks.first
    while reach > 1e-3:
        blocks = points.blocks_in_box(middle - reach, middle + reach)
        if int((first[blocks + 1] - first[blocks]).sum()) <= most:
            break
        reach /= 1.3
    numbers = points.numbers(blocks)
    inside = (np.abs(points.xyz[numbers] - middle) <= reach).all(axis=1)
    return np.asarray(numbers[inside])
