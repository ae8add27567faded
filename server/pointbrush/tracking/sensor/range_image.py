"""What hides what from a sensor that looks all round: how far it saw in each direction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.spatial import cKDTree

from pointbrush.tracking.interface import F32, F64, I64, Mask

AZIMUTH = 0.4
"""Degrees of a cell around."""
ELEVATIONS = (0.4, 0.8, 1.6, 3.2)
"""Degrees of a cell up and down: the least is taken of which the cells are mostly FILLED."""
FILLED = 0.6
"""Share of the cells, within the edges of what is seen, that show something."""
DEEPER = 0.03
"""Share of its range by which a point has to lie behind all others there to be hidden."""
FEWEST = 2000
"""Points of a frame of which it is asked whether they were seen from one place."""
HEIGHTS = (0.0, 1.0, 1.8, 2.6)
"""Metres above a frame's origin at which its sensor is looked for."""
BEHIND, SEES, SWEPT = 1.25, 0.02, 0.07
"""Ranges beyond the nearest in its direction that no sensor at that place can see, the share of
such points, of those in the very same direction, up to which the sensor is there, and of all: what
a lidar swept while it drove, brought to one moment, was seen from a metre around."""
DEEP = 1.5
"""Range of the farthest points, over the nearest, from which a place in between is a lidar's."""
FINE, SOME = 0.1, 0.005
"""Degrees within which a sensor sees one surface, even along the ground, and the share of a frame
below which points that have others in their direction are too few to be told by."""
WIDTH = int(360 / AZIMUTH) + 1
"""Cells around."""
AROUND = np.add.outer((-WIDTH, 0, WIDTH), (-1, 0, 1)).ravel()
"""Flat steps to the cells around one, and to itself."""
FAR, MOST = 15.0, 0.95
"""Metres farther than depth cameras measure, and the share of the points that lie nearer."""
SPREADS, BESIDE, ASKED = 0.5, 3, 2000
"""Power of the range by which points have to lie farther apart for a sensor to have seen them: 1
as it sees them, 0 as a surface is sampled; neighbours, and points, of which it is asked."""
RIM, ENDS = 0.02, 0.05
"""Shares of the points beyond the edges of what is seen, and that are the nearest or the farthest:
stray ones, which tell nothing of the rest."""
SAMPLE = 5000
"""Points that tell which way is up."""
ASIDE = 6
"""Cells beside the last direction in which anything was measured from which nothing is seen."""


@dataclass(frozen=True, slots=True, eq=False)
class RangeImage:
    """Ranges around ``eye`` (3,): the ``farthest`` of each cell, metres, inf where none, and 0
    where the sensor does not look.

    ``up`` the axis that azimuths go round, ``step`` degrees of elevation of a cell.
    """

    eye: F64
    farthest: F32
    up: int
    step: float

    def hides(self, xyz: F64, by: float, own: I64 | None = None, size: float = np.inf) -> Mask:
        """Which points (M, 3) lie ``by`` metres or more behind all that was measured there, or
        beyond the edges of what the sensor sees.

        In the directions ``own``, and beside, what is less than ``size`` metres nearer hides none.
        """
        cell, away = _cells(xyz - self.eye, self.up, self.step)
        far = self.farthest[cell]
        hidden = far < away - np.maximum(by, DEEPER * away)
        if own is not None:
            there = np.zeros(len(self.farthest), np.bool_)
            there[np.clip(own[:, None] + AROUND, 0, len(there) - 1)] = True
            hidden &= ~there[cell] | (far < away - size)
        return np.asarray(hidden)

    def towards(self, xyz: F64) -> I64:
        """The directions of points (M, 3), each once."""
        return np.unique(_cells(xyz - self.eye, self.up, self.step)[0])


def range_image_of(xyz: F32, eye: F64, most: float = SWEPT) -> RangeImage | None:
    """The ranges of a frame (N, 3) around ``eye``.

    None where it has hardly any points, or was not seen from there: more than the share ``most``
    lies well behind others.
    """
    if len(xyz) < FEWEST:
        return None
    local = xyz - eye
    up = axis_up(local)
    if _behind(local, up) > most and _confused(local, up) > SEES:
        return None
    for step in ELEVATIONS:
        cell, away = _cells(local, up, step)
        farthest = np.zeros(int(180 / step + 1) * WIDTH, np.float32)
        np.maximum.at(farthest, cell, away.astype(np.float32))
        image = farthest.reshape(-1, WIDTH)
        row = np.quantile(cell // WIDTH, [RIM, 1 - RIM]).astype(int)
        part = image[row[0] : row[1] + 1, image.any(axis=0)] > 0
        if part.mean() > FILLED:
            break
    farthest = np.where(farthest > 0, farthest, _open(image)).astype(np.float32)
    return RangeImage(np.asarray(eye, np.float64), farthest, up, step)


def _open(image: F32) -> F32:
    """Flat ranges where an ``image`` (R, WIDTH) is empty: inf inside of its edges, 0 beyond."""
    looks = maximum_filter1d(image.any(axis=0), 2 * ASIDE + 1, mode="wrap")
    rows = np.flatnonzero(image.any(axis=1))
    seen = np.zeros(image.shape, np.float32)
    seen[rows[0] : rows[-1] + 1, looks] = np.inf
    return seen.ravel()


def find_eye(xyz: F32) -> F64 | None:
    """Where the sensor of a frame (N, 3) without a viewpoint was: about its origin, or unknown.

    From there each direction shows one surface; from elsewhere surfaces lie behind each other.
    """
    if len(xyz) < FEWEST:
        return None
    up = axis_up(xyz)
    above = np.eye(3)[up]
    height, most = 0.0, SWEPT
    if _behind(xyz, up) > SWEPT:
        height, most = min(HEIGHTS, key=lambda h: _confused(xyz - h * above, up)), SEES
    local = xyz - height * above
    there = range_image_of(xyz, height * above, most) is not None and _deep(local)
    # What is thinned to cells and reaches as far as a lidar does is no figure about its middle.
    there = there and (reach_of(xyz) > FAR or _spreads(local))
    return np.asarray(height * above) if there else None


def _deep(local: F32 | F64) -> bool:
    """Whether what lies behind something else would be seen to: all of a small thing is hardly
    farther than its front."""
    away = np.linalg.norm(local, axis=1)
    near, far = np.quantile(away, [ENDS, 1 - ENDS])
    return bool(far > DEEP * near)


def _spreads(local: F32 | F64) -> bool:
    """Whether points (N, 3) lie farther apart the farther they are, as a sensor sees them.

    A figure about its own middle shows one surface in each direction too, but is sampled evenly.
    """
    away = np.linalg.norm(local, axis=1)
    some = np.arange(0, len(local), -(-len(local) // ASKED))
    apart = np.asarray(cKDTree(local).query(local[some], k=[BESIDE + 1])[0])[:, 0]
    near, far = (away[some] <= np.quantile(away, 1 / 3), away[some] >= np.quantile(away, 2 / 3))
    farther = np.median(away[some][far]) / np.median(away[some][near])
    wider = np.median(apart[far]) / max(float(np.median(apart[near])), 1e-9)
    return bool(wider > farther**SPREADS)


def reach_of(xyz: F32 | F64) -> float:
    """Metres from the middle of points (N, 3), along each axis, within which most of them lie."""
    if not len(xyz):
        return 0.0
    away = np.abs(xyz - np.median(xyz, axis=0).astype(np.float64)).max(axis=1)
    return float(np.quantile(away, MOST))


def axis_up(local: F32 | F64) -> int:
    """The axis that a spinning sensor looks along the least."""
    return int(np.argmin(np.abs(local[:: max(1, len(local) // SAMPLE)]).mean(axis=0)))


def _behind(local: F32 | F64, up: int) -> float:
    """Share of the points (N, 3) that lie well behind another in their direction."""
    cell, away = _cells(local, up, ELEVATIONS[0])
    nearest = np.full(int(180 / ELEVATIONS[0] + 1) * WIDTH, np.inf, np.float32)
    np.minimum.at(nearest, cell, away.astype(np.float32))
    return float((away > BEHIND * nearest[cell]).mean())


def _confused(local: F32 | F64, up: int) -> float:
    """Share of the points (N, 3), of those with others in the very same direction, that lie well
    behind another: what several sensors saw, or one elsewhere, is confused so."""
    cell, away = _cells(local, up, FINE, FINE)
    order = np.argsort(cell, kind="stable")
    start = np.flatnonzero(np.diff(cell[order], prepend=-1))
    count = np.diff(start, append=len(cell))
    nearest = np.repeat(np.minimum.reduceat(away[order], start), count)
    behind = np.count_nonzero(away[order] > BEHIND * nearest)
    shared = int(count[count > 1].sum())
    return float(behind / max(shared, SOME * len(local)))


def _cells(local: F32 | F64, up: int, step: float, azimuth: float = AZIMUTH) -> tuple[I64, F64]:
    """Flat cell and range of points (M, 3) around the sensor."""
    across, along = (a for a in range(3) if a != up)
    away = np.sqrt(np.einsum("ij,ij->i", local, local)) + 1e-9
    around = np.degrees(np.arctan2(local[:, along], local[:, across])) + 180.0
    elevation = np.degrees(np.arcsin(np.clip(local[:, up] / away, -1.0, 1.0))) + 90.0
    width = int(360 / azimuth) + 1
    cell = (elevation / step).astype(np.int64) * width + (around / azimuth).astype(np.int64)
    return cell, np.asarray(away, np.float64)
