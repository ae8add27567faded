"""Compiled tests of pixels against the scene, and the last label of each pixel."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pointbrush.compiled import compiled, innermost
from pointbrush.tracking.interface import F32, I64, Mask
from pointbrush.tracking.options.sensors import BackgroundOptions
from pointbrush.tracking.scene.images import DepthNoise
from pointbrush.tracking.sensors.camera import I32, Projection


class LastSeen(NamedTuple):
    """The farthest ``label`` of each cell, 0 for none, and its ``depth`` when last seen.

    Arrays (cells + 1,), updated in place by each frame.  An occluded cell keeps its label, and
    loses it when it shows the surface behind, or when the object is seen elsewhere.
    """

    label: I32
    depth: F32

    @staticmethod
    def nothing(count: int) -> LastSeen:
        """Return ``count`` cells without labels."""
        return LastSeen(np.zeros(count, np.int32), np.full(count, np.nan, np.float32))

    def learn(
        self, seen: F32, owner: I32, limit: F32, known: F32, options: BackgroundOptions
    ) -> Mask:
        """Update the cells by a frame; return a mask of unlabelled cells with labelled surface.

        ``seen``: depths; ``owner``: labels; ``limit``: metres within which depths are equal;
        ``known``: depths of the scene, NaN where it was never seen.
        """
        return _learnt(self, seen, owner, limit, known, options.stayed_share)


@compiled
def _learnt(
    last: LastSeen, seen: F32, owner: I32, limit: F32, known: F32, stayed_share: float
) -> Mask:
    label, depth = last
    moved = _moved_labels(last, seen, owner, limit, stayed_share)
    missed = np.zeros(len(seen), np.bool_)
    for c in range(len(seen)):
        if label[c] != 0 and moved[label[c]]:
            label[c] = 0
        if np.isnan(seen[c]) or (owner[c] == 0 and label[c] == 0):
            continue
        step = seen[c] - depth[c]
        if label[c] != 0 and step > limit[c]:
            label[c] = 0
        if seen[c] > known[c] - limit[c]:
            label[c] = 0
        elif owner[c] != 0 and (label[c] == 0 or label[c] == owner[c]):
            label[c], depth[c] = owner[c], seen[c]
        elif owner[c] == 0 and label[c] != 0:
            missed[c] = step > -limit[c]
    return missed


@compiled
def _moved_labels(last: LastSeen, seen: F32, owner: I32, limit: F32, stayed_share: float) -> Mask:
    """Return a mask (labels,) of visible labels that mostly moved to other cells."""
    label, depth = last
    most = 0
    for c in range(len(seen)):
        most = max(most, label[c], owner[c])
    every, same = np.zeros(most + 1, np.int64), np.zeros(most + 1, np.int64)
    for c in range(len(seen)):
        every[owner[c]] += 1
        if owner[c] == label[c] and abs(seen[c] - depth[c]) < limit[c]:
            same[owner[c]] += 1
    return same < stayed_share * every


class Images(NamedTuple):
    """Images of an ``ImageBackground`` (cells + 1,) for compiled loops."""

    noise: DepthNoise
    scene: F32
    depth: F32
    hidden: F32
    previous: F32
    anchor: F32
    age: I32


@innermost
def _limit(noise: DepthNoise, depth: float, near_sigmas: float) -> float:
    """Return the distance (m) within which two depths are equal."""
    return near_sigmas * (noise.still + noise.growing * depth * depth)


@compiled
def static_points(
    points: Projection, indices: I64, known: F32, last: F32, noise: DepthNoise, near_sigmas: float
) -> tuple[Mask, Mask]:
    """See ``Background.static``.

    ``known``: depths of the background; ``last``: unlabelled depths of the last frame.
    """
    cells, depths = points
    count = len(indices)
    far, rest = np.empty(count, np.bool_), np.empty(count, np.bool_)
    for i in range(count):
        cell, depth = cells[indices[i]], depths[indices[i]]
        limit = _limit(noise, depth, near_sigmas)
        far[i] = depth - known[cell] > -limit
        rest[i] = abs(depth - last[cell]) < limit
    return far, rest


@compiled
def reappearing_labels(
    points: Projection, indices: I64, last: LastSeen, noise: DepthNoise, near_sigmas: float
) -> I64:
    """See ``Background.reappearing_labels``."""
    cells, depths = points
    label = np.zeros(len(indices), np.int64)
    for i in range(len(indices)):
        cell, depth = cells[indices[i]], depths[indices[i]]
        if abs(depth - last.depth[cell]) < _limit(noise, depth, near_sigmas):
            label[i] = last.label[cell]
    return label


@compiled
def furniture(
    points: Projection, indices: I64, known: F32, scene: F32, noise: DepthNoise, near_sigmas: float
) -> Mask:
    """See ``PictureBackground.furniture``: ``known`` depths, and depths of the ``scene``."""
    cells, depths = points
    result = np.empty(len(indices), np.bool_)
    for i in range(len(indices)):
        cell, depth = cells[indices[i]], depths[indices[i]]
        limit = _limit(noise, depth, near_sigmas)
        result[i] = known[cell] < scene[cell] - limit and depth > known[cell] - limit
    return result


@compiled
def before(
    points: Projection,
    indices: I64,
    nearest: F32,
    noise: DepthNoise,
    near_sigmas: float,
) -> Mask:
    """See ``Background.certain``: ``nearest`` as of ``least``."""
    cells, depths = points
    result = np.empty(len(indices), np.bool_)
    for i in range(len(indices)):
        cell, depth = cells[indices[i]], depths[indices[i]]
        result[i] = depth < nearest[cell] - _limit(noise, depth, near_sigmas)
    return result


@compiled
def scenery(
    points: Projection,
    indices: I64,
    frames: int,
    nearest: F32,
    images: Images,
    hidden_share: float,
    near_sigmas: float,
) -> Mask:
    """See ``Background.scenery``: ``nearest`` as of ``least``."""
    cells, depths = points
    result = np.empty(len(indices), np.bool_)
    for i in range(len(indices)):
        cell, depth = cells[indices[i]], depths[indices[i]]
        limit = _limit(images.noise, depth, near_sigmas)
        if not (np.isnan(images.scene[cell]) and np.isnan(images.depth[cell])):
            result[i] = not depth < nearest[cell] - limit
            continue
        # Newly uncovered and continuing the scene around: no object has arrived.
        new = not abs(depth - images.previous[cell]) < limit
        goes_on = new and depth > hidden_share * images.hidden[cell] - limit
        stuck = abs(depth - images.anchor[cell]) < limit and images.age[cell] >= frames
        result[i] = goes_on or stuck
    return result


@compiled
def count_static_frames(anchor: F32, age: I32, seen: F32, limit: F32) -> None:
    """Count the frames in which each cell keeps the depth ``seen``, within a ``limit``.

    Unmeasured cells count as unchanged.
    """
    for c in range(len(seen)):
        age[c] += 1
        if not (np.isnan(seen[c]) or abs(seen[c] - anchor[c]) < limit[c]):
            anchor[c], age[c] = seen[c], 0


@compiled
def update_known_depths(known: F32, seen: F32, limit: F32, learn_rate: float) -> None:
    """Update the ``known`` depth of each cell by a running mean of ``seen`` depths.

    Farther depths replace it at once.
    """
    share = np.float32(learn_rate)
    for c in range(len(seen)):
        change = seen[c] - known[c]
        if abs(change) < limit[c]:
            known[c] += share * change
        elif change > limit[c] or np.isnan(known[c]):
            known[c] = seen[c]


@compiled
def least(known: F32, shape: tuple[int, int], noise: DepthNoise) -> F32:
    """Return (cells + 1,) the minimum depth of the scene in each cell.

    ``known`` (cells + 1,): its depth, NaN where unknown.  At a depth edge the minimum of the
    neighbours counts; on a continuous surface, slanted or not, the depth is unchanged.
    """
    height, width = shape
    result = known.copy()
    for row in range(height):
        for column in range(width):
            cell = row * width + column
            depth = known[cell]
            if np.isnan(depth):
                continue
            same = noise.still + noise.growing * depth * depth
            for down, along in ((0, 1), (1, 0), (1, 1), (1, -1)):
                one = other = np.float32(np.nan)
                if row >= down and 0 <= column - along < width:
                    one = known[cell - down * width - along]
                if row + down < height and 0 <= column + along < width:
                    other = known[cell + down * width + along]
                # A plane is linear in inverse depth: the mean of both neighbours equals the cell.
                if abs(2 * one * other - depth * (one + other)) < same * (one + other):
                    continue
                if one < result[cell]:
                    result[cell] = one
                if other < result[cell]:
                    result[cell] = other
    return result
