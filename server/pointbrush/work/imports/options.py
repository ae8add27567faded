"""Choices of a person for an import of labels: command line and job follow from them."""

from __future__ import annotations

from dataclasses import dataclass

from pointbrush.formats.names import LABEL_FORMATS
from pointbrush.options import choice

SAMPLES = ("juggling", "aerial")
"""Recordings that `pointbrush demo` makes."""


@dataclass(frozen=True)
class LabelOptions:
    """Choices on how files of labels are read."""

    format: str | None = choice(None, f"of the labels: {', '.join(LABEL_FORMATS)}")
    no_ground: bool = choice(False, "leave the ground out of each box")
    by_order: bool = choice(False, "files are frames in their order, not by name")
    field: str | None = choice(None, "the field of the points that is labels")
