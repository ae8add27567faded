"""A stroke and a frame in, the numbers of the points it takes out: one module per shape."""

from pointbrush.selection.plane import fit_plane
from pointbrush.selection.points import Blocks, Points
from pointbrush.selection.pointset import PointSet
from pointbrush.selection.select import Selector, first_hits, select
from pointbrush.selection.shapes import SHAPES
from pointbrush.selection.stroke import TOOLS, Stroke
from pointbrush.selection.surface import Plane

__all__ = [
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
