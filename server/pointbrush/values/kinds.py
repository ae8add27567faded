"""Numbers, texts and vectors that values consist of, with their limits."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Annotated, Literal, overload

from pointbrush.values.base import Items, Meanings, Rule

HIDDEN = r"\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069"
"""Control, line breaking and bidirectional characters, as the inside of a regular expression's
class: Python's, JavaScript's and Rust's read it alike."""
VISIBLE = f"[^{HIDDEN}]"
"""Pattern of a character that names may hold."""
FARTHEST = 1e12
"""The largest number of a position, in metres; squares of squares of it are still numbers."""
LONGEST_SIDE = 1_000.0
"""The longest side of a box, metres."""

LONGEST_NAME = 200
Name = Annotated[str, Rule(min_length=1, max_length=LONGEST_NAME, pattern=f"^{VISIBLE}+$")]
SEQUENCE_ID = r"^[a-z0-9][a-z0-9._-]{0,63}$"
"""Pattern of the ids of recordings, projects and snapshots."""
SequenceName = Annotated[str, Rule(pattern=SEQUENCE_ID, max_length=64)]
Uuid = Annotated[
    str, Rule(pattern=r"^[0-9a-fA-F]{8}(-[0-9a-fA-F]{4}){3}-[0-9a-fA-F]{12}$", max_length=36)
]
Color = Annotated[str, Rule(pattern=r"^#[0-9a-fA-F]{6}$")]
FrameRange = Annotated[str, Rule(pattern=r"^[0-9]{0,9}(:[0-9]{0,9})?$")]
"""Frames ``I:J``, J not included."""

FrameIndex = Annotated[int, Rule(ge=0, lt=2**31)]
Count = Annotated[int, Rule(ge=0, lt=2**53)]
LabelId = Annotated[int, Rule(ge=0, le=65534)]
PaintId = Annotated[int, Rule(ge=1, le=65534)]
PaintIds = Annotated[tuple[PaintId, ...], Rule(min_length=1, max_length=65534)]
Share = Annotated[float, Rule(ge=0, le=1)]
Finite = Annotated[float, Rule(ge=-FARTHEST, le=FARTHEST, allow_inf_nan=False)]
Vector = Annotated[tuple[Finite, Finite, Finite], Items()]
Quaternion = Annotated[tuple[Finite, Finite, Finite, Finite], Items()]
Matrix4 = Annotated[tuple[Finite, ...], Rule(min_length=16, max_length=16)]
"""4x4, row by row."""
Side = Annotated[float, Rule(gt=0, le=LONGEST_SIDE, allow_inf_nan=False)]
Sides = Annotated[tuple[Side, Side, Side], Items()]
"""Length, width and height of a box, metres."""

MOST_SENSORS = 64
"""Most sensors of one recording."""

SensorType = Annotated[
    Literal["depth", "spinning", "solid-state", "radar", "unknown"],
    Meanings(
        {
            "depth": "a depth camera",
            "spinning": "a lidar that turns",
            "solid-state": "a lidar without a turning head",
            "radar": "a radar",
            "unknown": "the files do not tell",
        }
    ),
]
Role = Annotated[
    Literal["viewer", "annotator", "reviewer", "manager", "admin"],
    Meanings(
        {
            "viewer": "sees recordings and labels",
            "annotator": "changes labels",
            "reviewer": "accepts and rejects labels",
            "manager": "manages recordings, projects and accounts",
            "admin": "manages the server",
        }
    ),
]
TaskState = Annotated[
    Literal["open", "taken", "done", "review", "accepted", "returned"],
    Meanings(
        {
            "open": "not assigned",
            "taken": "being labelled",
            "done": "labelled, waits for a review",
            "review": "being reviewed",
            "accepted": "accepted by a reviewer",
            "returned": "to be labelled again",
        }
    ),
]


@overload
def time_of(seconds: float) -> datetime: ...
@overload
def time_of(seconds: float | None) -> datetime | None: ...
def time_of(seconds: float | None) -> datetime | None:
    """Return the time of seconds since the epoch, UTC."""
    return None if seconds is None else datetime.fromtimestamp(seconds, UTC)
