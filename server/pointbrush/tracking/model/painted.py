"""Properties of an object in the painted frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.options.tracks import ObjectOptions
from pointbrush.tracking.sensors.view import View


def cut_off_by_edge(view: View, indices: I64, radius: float) -> tuple[bool, bool]:
    """Return whether the picture's edge cuts off a painted object of ``radius`` metres, or may.

    Many of its points lie at the edge, or it is as large as a part of a person and touches the edge
    along much of its width.  If no unlabelled point reaches as far, the object itself ends there.
    Of several cameras, each that shows the object cuts it off.
    """
    if view.lens is None:
        return False, False
    own, others = np.zeros(len(view.xyz), np.bool_), ~view.labelled()
    own[indices] = True
    row, column = np.divmod(view.cells.cell, view.image_shape[1])
    cuts = [
        _cut_off(
            row[points], column[points], own[points], others[points], radius, view.options.track
        )
        for points in view.points_by_sensor
        if own[points].any()
    ]
    return bool(cuts) and all(cut for cut, _ in cuts), bool(cuts) and all(may for _, may in cuts)


def _cut_off(
    row: I64, column: I64, own: Mask, others: Mask, radius: float, options: ObjectOptions
) -> tuple[bool, bool]:
    """See ``cut_off_by_edge``, for the points (N,) of one camera at a ``row`` and a ``column``."""
    gaps, touch = np.inf, 0.0
    for at, along in ((row, column), (column, row)):
        for side in (at, -at):
            if others.any() and side[others].min() < side.min() + options.edge_px:
                gap = side[own] - side.min()
                gaps = np.minimum(gaps, gap)
                contact = np.unique(along[own][gap < options.edge_px])
                touch = max(touch, len(contact) / (np.ptp(along[own]) + 1))
    wide = touch > options.contact_share
    cut = (wide and radius > options.cut_m) or np.mean(gaps < options.edge_px) > options.edge_share
    return bool(cut), wide


def sensor_distance(view: View, xyz: F64) -> float:
    """Return the distance (m) of points (M, 3) from the sensor; 0 if its position is unknown."""
    return view.sensor_distance(xyz.mean(axis=0)) or 0.0


def across_way(xyz: F64) -> float:
    """Return the standard deviation (m) of points (M, 3) across their longest axis."""
    if len(xyz) < 3:
        return 0.0
    return float(np.sqrt(max(np.linalg.eigvalsh(np.cov(xyz.T))[1], 0.0)))


def texture(xyz: F64, colour: F32, options: ObjectOptions) -> tuple[float, float]:
    """Return the median distance and colour difference between neighbours."""
    if len(xyz) < 3:
        return options.lone_spacing_m, options.min_colour_noise
    sample = np.arange(0, len(xyz), max(1, len(xyz) // options.sampled_points))
    distance, near = cKDTree(xyz).query(xyz[sample], k=2)
    gaps = np.asarray(distance)[:, 1]
    unlike = np.linalg.norm(colour[sample] - colour[np.asarray(near)[:, 1]], axis=1)
    return max(float(np.median(gaps)), options.min_spacing_m), float(np.median(unlike))


def across_rings(xyz: F64, options: ObjectOptions) -> float:
    """Return the median distance to the nearest point across the direction of the nearest one.

    Lidars measure densely along a ring, and the next ring is farther away.
    """
    if len(xyz) < options.ring_neighbours:
        return 0.0
    sample = xyz[:: max(1, len(xyz) // options.sampled_points)]
    distance, near = cKDTree(xyz).query(sample, k=options.ring_neighbours)
    way = xyz[np.asarray(near)[:, 1:]] - sample[:, None]
    length = np.asarray(distance)[:, 1:] + 1e-9
    along = np.abs((way * way[:, :1]).sum(axis=2)) / (length * length[:, :1])
    length = np.where(along < options.ring_cos, length, length[:, -1:])
    return float(np.median(length.min(axis=1)))


def uneven(xyz: F64, options: ObjectOptions) -> float:
    """Return the median distance of points (M, 3) from the plane through them."""
    if len(xyz) < options.ring_neighbours:
        return np.inf
    offset = xyz - xyz.mean(axis=0)
    normal = np.linalg.eigh(offset.T @ offset)[1][:, 0]
    return float(np.median(np.abs(offset @ normal)))


def colourless(view: View, indices: I64) -> bool:
    """Return whether many of the points are exactly black: outside the view of all cameras."""
    rgb = view.frame.rgb
    return (
        rgb is None
        or float((~np.asarray(rgb)[indices].any(axis=1)).mean()) > view.options.track.black_share
    )


@dataclass(frozen=True)
class Painted:
    """Properties of an object in the painted frame.

    ``flat``: lying on the ground; ``sheet``: a flat object, such as a door; ``broad``: as broad as
    part of a person; ``cut``: cut off by the edge of the picture; ``entering``: touches the edge
    and may be a small part of a person; ``grounded``: painted with the ground below it;
    ``with_flying``: painted with the flying pixels at its outline.
    """

    flat: bool
    sheet: bool
    broad: bool
    cut: bool
    entering: bool = False
    grounded: bool = False
    with_flying: bool = False

    @staticmethod
    def of(view: View, indices: I64, xyz: F64, radius: float) -> Painted:
        """Return the properties of points ``indices`` (M,) at ``xyz`` (M, 3), ``radius`` in m."""
        options = view.options.track
        cut, entering = cut_off_by_edge(view, indices, radius)
        return Painted(
            flat=float(view.low[indices].mean()) > options.flat_share,
            sheet=uneven(xyz, options=options) < options.sheet_radii * radius,
            broad=radius > options.part_m
            and across_way(xyz) > options.broad_m
            and sensor_distance(view, xyz) > options.afar_m,
            cut=cut,
            entering=entering,
        )
