"""Masks of pictures, which labels are made from."""

from __future__ import annotations

from dataclasses import dataclass

from pointbrush.values.edits import Edit

LATTICE = "depth"
"""Name of the depth camera that measured the points, in URLs and names of files."""

VOID = 65535
"""Value of a pixel without evidence, such as a hole between points; no label has this id."""


@dataclass(frozen=True, slots=True)
class MaskEdit(Edit):
    """Result of masks that became labels."""

    seen: int
    """Number of points in the masks' values that have a label or class."""
    doubt: int
    """Number of points that stay as they are, because they are near a border of a mask or cameras
    disagree."""
