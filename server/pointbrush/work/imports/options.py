"""Options of an import of labels, from which flags and job options are derived."""

from __future__ import annotations

from dataclasses import dataclass

from pointbrush.errors import BadInputError
from pointbrush.formats.tables.names import LABEL_FORMATS
from pointbrush.settings.definitions import choice

BOTH, KEEP, POINTS = "both", "keep", "points"
BOX_CHOICES = (BOTH, KEEP, POINTS)
"""Results of imported boxes: boxes of labels, labels of the points inside, or both."""
SAMPLES = ("juggling", "aerial")
"""Sample recordings of `pointbrush demo`."""


@dataclass(frozen=True)
class LabelOptions:
    """Options for reading files of labels."""

    format: str | None = choice(
        None, f"format of the labels (default: detected): {', '.join(LABEL_FORMATS)}"
    )
    no_ground: bool = choice(False, "do not label the ground inside boxes")
    by_order: bool = choice(False, "match files to frames by their order, not by name")
    field: str | None = choice(None, "field of the points that holds the labels")
    allow_empty: bool = choice(False, "accept files that label nothing")
    boxes: str = choice(
        BOTH, "keep imported boxes (keep), label the points inside (points), or both (default)"
    )

    def __post_init__(self) -> None:
        """Check the options.  Raises BadInputError."""
        if self.boxes not in BOX_CHOICES:
            raise BadInputError(
                f"boxes: expected one of {', '.join(BOX_CHOICES)}, got {self.boxes[:40]!r}"
            )
