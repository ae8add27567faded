"""Export formats."""

from __future__ import annotations

from dataclasses import dataclass

from pointbrush.values.base import Complete


@dataclass(frozen=True, slots=True)
class ExportFormat(Complete):
    """An export format."""

    format: str
    """Name for the ``format`` of an export."""
    title: str
    """Name that people see."""
    content: str
    """Contents of its files."""
    purpose: str
    """Heading of the page's list."""
    cannot_hold: tuple[str, ...]
    """Content that is lost in it."""
    splits: bool = False
    """Its frames are split for training and validation."""
    whole_boxes: bool = False
    """It has whole boxes, not boxes that enclose only the visible points."""
    classes: bool = False
    """A label without a category becomes a class of its own in it."""
