"""Choices of a person for an import of labels: command line and job follow from them."""

from __future__ import annotations

from dataclasses import dataclass

from pointbrush.errors import BadInputError
from pointbrush.formats.names import LABEL_FORMATS
from pointbrush.options import choice

BOTH, KEEP, POINTS = "both", "keep", "points"
BOX_CHOICES = (BOTH, KEEP, POINTS)
"""Results of boxes that come in: boxes of labels, labels of the points inside, or both."""
SAMPLES = ("juggling", "aerial")
"""Recordings that `pointbrush demo` makes."""


@dataclass(frozen=True)
class LabelOptions:
    """Choices on how files of labels are read."""

    format: str | None = choice(None, f"of the labels: {', '.join(LABEL_FORMATS)}")
    no_ground: bool = choice(False, "leave the ground out of each box")
    by_order: bool = choice(False, "files are frames in their order, not by name")
    field: str | None = choice(None, "the field of the points that is labels")
    boxes: str = choice(BOTH, "of boxes: keep them, label the points inside, or both")

    def __post_init__(self) -> None:
        """Check the choices.  Raises BadInputError."""
        if self.boxes not in BOX_CHOICES:
            raise BadInputError(
                f"boxes: expected one of {', '.join(BOX_CHOICES)}, got {self.boxes[:40]!r}"
            )
