"""Selection of point numbers in a frame by strokes; each brush shape is a module."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pointbrush.lazy import lazily

if TYPE_CHECKING:
    from pointbrush.selection.plane import fit_plane
    from pointbrush.selection.points import Points, PointSet
    from pointbrush.selection.selecting import Selector, first_hits, select
    from pointbrush.selection.shapes import SHAPES
    from pointbrush.selection.stroke import MAX_FRAMES, TOOLS, Stroke
if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)
