"""The queue of a project, and agreement of people with the same points to label."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, Literal

from pointbrush.values.base import Body, ClosedKeys, Meanings, Rule, Value
from pointbrush.values.kinds import (
    FrameIndex,
    FrameRange,
    PaintId,
    SequenceName,
    TaskState,
    Uuid,
    Vector,
)
from pointbrush.values.team.review import Agreement, NotePatch, Person

Work = Annotated[
    Literal["label", "review"],
    Meanings({"label": "label frames", "review": "review the labels of other people"}),
]
DisagreementKind = Annotated[
    Literal["missed", "added", "split", "merged", "renamed", "outline"],
    Meanings(
        {
            "missed": "the second has no label there",
            "added": "the first has no label there",
            "split": "one label of the first is several of the second",
            "merged": "several labels of the first are one of the second",
            "renamed": "the label has another name",
            "outline": "the labels have other outlines",
        }
    ),
]


@dataclass(frozen=True, slots=True)
class NewTasks(Body):
    """Tasks to create."""

    recordings: Annotated[tuple[SequenceName, ...], Rule(max_length=10_000)] | None = None
    """Ids of recordings; null: all of the project."""
    frames: FrameRange | None = None
    """Frames ``I:J`` of each recording; null: all frames."""
    every: Annotated[int, Rule(ge=1, lt=2**31)] | None = None
    """Number of frames of a task; null: one task for all frames."""
    assignee: Person = ""
    """Account that the tasks are reserved for; empty: any."""
    people: Annotated[int, Rule(ge=1, le=9)] = 1
    """Number of people who label the same frames, each in a separate copy."""
    truth: bool = False
    """The existing labels are hidden, and are ground truth for scores."""
    id: Uuid | None = None
    """UUID of the call: a repeated call creates no other tasks."""


@dataclass(frozen=True, slots=True)
class NextTask(Body):
    """A request for the next task."""

    work: Work = "label"
    """Kind of work."""


@dataclass(frozen=True, slots=True)
class TaskPatch(NotePatch):
    """Values to set; missing fields and null do not change."""

    state: TaskState | None = None
    """New state."""
    frame: FrameIndex | None = None
    """Frame of ``place``."""


@dataclass(frozen=True, slots=True)
class Task(Value):
    """Frames of a recording to label."""

    number: int
    """Number of the task in its project."""
    sequence: str
    """Id of the recording."""
    first: int
    """First frame."""
    last: int
    """Last frame, included."""
    state: TaskState
    """State of the work."""
    assignee: str
    """Name of the annotator, or empty."""
    reviewer: str
    """Name of the reviewer, or empty."""
    note: str
    """Note of a reviewer; may be empty."""
    frame: int | None
    """Frame of ``place``."""
    place: Vector | None
    """Position of the note, source coordinates, metres."""
    created: datetime
    """Time of its creation."""
    changed: datetime
    """Time of its last change."""


@dataclass(frozen=True, slots=True)
class TaskEvent(Value):
    """A change of a task."""

    at: datetime
    """Time of the change."""
    by: str
    """Name of the person who made it."""
    state: TaskState
    """State after the change."""
    assignee: str
    """Name of the annotator after the change, or empty."""
    note: str
    """Note after the change; may be empty."""


@dataclass(frozen=True, slots=True)
class Disagreement(Value):
    """A difference of two copies in a frame."""

    kind: DisagreementKind
    """Kind of difference."""
    frame: int
    """Number of the frame."""
    first: tuple[str, ...]
    """Names of the labels in the first copy."""
    second: tuple[str, ...]
    """Names of the labels in the second copy."""
    labels: tuple[tuple[int, ...], ...]
    """Ids of these labels in the first and in the second copy."""
    points: int
    """Number of differing points."""
    has: int | None
    """0: the recording has the label of the first copy, 1: of the second; null: of neither."""
    place: Vector | None
    """A differing point, source coordinates, metres; null in an octree."""


@dataclass(frozen=True, slots=True)
class CopyAgreement(Value):
    """Agreement of two copies of a recording."""

    first: str
    """Id of the first copy."""
    second: str
    """Id of the second copy."""
    agreement: Agreement
    """Agreement of their labels."""
    places: tuple[Disagreement, ...]
    """Places where they differ, the largest first."""


@dataclass(frozen=True, slots=True)
class Region(Body):
    """Points to merge."""

    labels: Annotated[
        Mapping[SequenceName, Annotated[tuple[PaintId, ...], Rule(max_length=65534)]],
        Rule(min_length=1, max_length=9),
        ClosedKeys(),
    ]
    """Ids of labels, by the id of the copy: only their points are merged."""
    frame: FrameIndex | None = None
    """Frame of the points; null: all submitted frames."""


@dataclass(frozen=True, slots=True)
class CopyMerge(Body):
    """Labels to write from copies into their recording."""

    sequence: SequenceName
    """Id of the recording."""
    take: SequenceName = "majority"
    """Id of a copy, or ``majority`` of at least three people."""
    region: Region | None = None
    """Points to merge; null: all points of submitted frames."""
    id: Uuid | None = None
    """UUID of the edit, which is applied once."""


@dataclass(frozen=True, slots=True)
class Score(Value):
    """Work of a person on frames with ground truth."""

    person: str
    """Name of the person."""
    frames: int
    """Number of compared frames."""
    miou: float | None
    """Mean IoU of classes, 0 to 1; null: no labels."""
    found: int
    """Number of objects of the ground truth that the person labelled."""
    missed: int
    """Number of objects of the ground truth that the person missed."""
    added: int
    """Number of objects that the ground truth does not have."""
