"""Labels of points from masks of pictures (``lift``), and masks from labels (``draw``).

Both use a ``View``: the pixel and the depth of each point of a frame in a picture.
"""

from __future__ import annotations

from pointbrush.masks.draw import draw
from pointbrush.masks.lift import IN_DOUBT, lift
from pointbrush.masks.options import LiftOptions
from pointbrush.masks.views import View
from pointbrush.values.masks import VOID

__all__ = ["IN_DOUBT", "VOID", "LiftOptions", "View", "draw", "lift"]
