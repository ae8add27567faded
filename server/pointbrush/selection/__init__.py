"""A stroke and a frame in, the numbers of the points it takes out: one module per shape."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pointbrush.lazy import lazily

if TYPE_CHECKING:
    from pointbrush.selection.plane import Plane, fit_plane
    from pointbrush.selection.points import Blocks, Points, PointSet
    from pointbrush.selection.selecting import Selector, first_hits, select
    from pointbrush.selection.shapes import SHAPES
    from pointbrush.selection.stroke import MAX_FRAMES, TOOLS, Stroke

__all__ = [
    "MAX_FRAMES",
    "SHAPES",
    "TOOLS",
    "Blocks",
    "Plane",
    "PointSet",
    "Points",
    "Selector",
    "Stroke",
    "first_hits",
    "fit_plane",
    "select",
]
_PLACES = {
    "fit_plane": "pointbrush.selection.plane",
    "Blocks": "pointbrush.selection.points",
    "Points": "pointbrush.selection.points",
    "PointSet": "pointbrush.selection.points",
    "Selector": "pointbrush.selection.selecting",
    "first_hits": "pointbrush.selection.selecting",
    "select": "pointbrush.selection.selecting",
    "SHAPES": "pointbrush.selection.shapes",
    "MAX_FRAMES": "pointbrush.selection.stroke",
    "TOOLS": "pointbrush.selection.stroke",
    "Stroke": "pointbrush.selection.stroke",
    "Plane": "pointbrush.selection.plane",
}
if not TYPE_CHECKING:
    __getattr__ = lazily(__name__, _PLACES)
