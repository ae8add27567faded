"""Labels from masks of pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pointbrush.values.base import Body, Items, Meanings, Rule
from pointbrush.values.edits import Edit
from pointbrush.values.kinds import Finite, PaintId, Uuid

LATTICE = "depth"
"""Name of the depth camera that measured the points, in URLs and names of files."""

MaskSource = Annotated[
    Literal["imported", "predicted", "painted"],
    Meanings(
        {
            "imported": "of another tool; painted points keep their label",
            "predicted": "of a model; only predicted and unlabelled points change",
            "painted": "by a person in the picture; all points change",
        }
    ),
]
MOST_BYTES = 64 * 2**20
"""Most bytes of a mask's file."""
MOST_CLICKS = 1_000
"""Limit of clicks in a picture."""
Click = Annotated[tuple[Finite, Finite], Items()]
Clicks = Annotated[tuple[Click, ...], Rule(max_length=MOST_CLICKS)]
VOID = 65535
"""Value of a pixel without evidence, such as a hole between points; no label has this id."""


@dataclass(frozen=True, slots=True)
class MaskEdit(Edit):
    """Edit that labels points from masks."""

    seen: int
    """Number of points with a value in the masks that has a label or class."""
    doubt: int
    """Number of points that keep their label because they are near a border of a mask or cameras
    disagree."""


@dataclass(frozen=True, slots=True)
class MaskPrompt(Body):
    """Request to a model that finds masks in a picture."""

    model: Annotated[str, Rule(min_length=1, max_length=200)]
    """Name of a model of the server."""
    positives: Clicks = ()
    """Clicks on the object: column and row, pixels from the picture's upper left corner."""
    negatives: Clicks = ()
    """Clicks beside the object."""
    text: Annotated[str, Rule(max_length=2_000)] = ""
    """Description of the objects."""
    label: PaintId | None = None
    """Label of all points behind the masks; null: labels of the classes that the model names."""
    id: Uuid | None = None
    """UUID of the edit."""
