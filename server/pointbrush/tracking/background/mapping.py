"""Which surfaces that a depth camera on the move sees are the scene's.

What other frames see through moves, and what nobody else sees may be noise; what lies about a thing
that is labelled may be another side of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.tracking.background.depth_noise import DepthNoise
from pointbrush.tracking.background.surface_map import SurfaceMap
from pointbrush.tracking.geometry.near import close_to
from pointbrush.tracking.geometry.windows import least_around, widened
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensor.view import View


def chart_of(views: Sequence[View], noise: DepthNoise, options: TrackerOptions) -> SurfaceMap:
    """The scene of some frames with depth images; the first has labels."""
    chart = SurfaceMap(np.empty((0, 3)), np.empty((0, 3)))
    around = [_around(view) for view in views]
    for view in views:
        depth = view.depth.copy()
        for points in view.labels.values():
            depth[view.cells.cell[points]] = np.nan
        depth[np.abs(depth - chart.drawn(view)) < options.background.near_sigmas * noise(depth)] = (
            np.nan
        )
        new = SurfaceMap.of(view, depth)
        asked = [_asked(v, a, new.at, noise) for v, a in zip(views, around, strict=True)]
        inside, shown, through = np.sum(asked, axis=0)
        enough = np.maximum(
            min(options.mapping.min_views, len(views)), options.mapping.shown_share * inside
        )
        keep = (shown >= enough) & (through <= options.mapping.seen_through_share * shown)
        keep &= ~_about(new.at, views[0], noise)
        chart += new.pick(keep)
    return chart


class _Around(NamedTuple):
    """The ``least`` and the ``most`` depth (cells + 1,) around each cell, NaN where none is."""

    least: F32
    most: F32


def _around(view: View) -> _Around:
    least, most = _least(view, view.depth), -_least(view, -view.depth)
    return _Around(np.where(np.isinf(least), np.nan, least), np.where(np.isinf(most), np.nan, most))


def _least(view: View, image: F32) -> F32:
    """The least of each cell and those around it, inf where there is none."""
    result = np.full_like(image, np.inf)
    filled = np.where(np.isnan(image[:-1]), np.float32(np.inf), image[:-1])
    result[:-1] = least_around(filled.reshape(view.camera.shape)).ravel()
    return result


def _asked(view: View, seen: _Around, at: F64, noise: DepthNoise) -> NDArray[np.int64]:
    """(3, M) whether the places (M, 3) lie in a picture, show a surface there, are seen through."""
    cell, depth = view.project(at)
    limit = view.options.background.near_sigmas * noise(depth)
    through = seen.least[cell] > depth + limit
    shown = ~through & (seen.most[cell] > depth - limit)
    return np.stack([cell >= 0, shown, through]).astype(np.int64)


def _about(at: F64, first: View, noise: DepthNoise) -> Mask:
    """Which of the places (M, 3) may be of the things that are labelled in the first frame.

    They lie there or close behind; not far behind one of them; or beside, where that frame does
    not show them to be others'.
    """
    options = first.options
    if not first.labels:
        return np.zeros(len(at), np.bool_)
    cell, depth = first.project(at)
    lengths = {n: float(np.ptp(first.xyz[own], axis=0).max()) for n, own in first.labels.items()}
    labelled, there = np.zeros(len(first.depth), np.bool_), np.zeros(len(at), np.bool_)
    for label, own in first.labels.items():
        inside, back = _extent(first, own)
        labelled |= inside
        there |= inside[cell] & (depth < back[cell] + options.mapping.side_share * lengths[label])
    longest = max(lengths.values())
    some = np.flatnonzero(first.labelled())
    some = some[:: max(1, len(some) // options.mapping.sampled_points)]
    objects = first.xyz[some].astype(np.float64)
    hidden = (
        labelled[cell]
        & (depth > first.depth[cell])
        & close_to(at, objects, options.mapping.body_share * longest)
    )
    others = ~labelled[cell] & (
        np.abs(first.depth[cell] - depth) < options.background.near_sigmas * noise(depth)
    )
    return np.asarray(
        there | hidden | (close_to(at, objects, options.mapping.side_share * longest) & ~others)
    )


def _extent(view: View, points: I64) -> tuple[Mask, F32]:
    """The cells (cells + 1,) of some points and a rim about them, and the greatest depth there."""
    front = np.full(len(view.depth), np.nan, np.float32)
    front[view.cells.cell[points]] = view.cells.depth[points]
    rim = widened(np.isfinite(front[:-1]).reshape(view.camera.shape), view.options.mapping.rim_px)
    return np.append(rim, False), -_least(view, -front)
