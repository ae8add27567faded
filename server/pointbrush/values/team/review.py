"""The review of a recording: states and notes, findings, and agreement of annotators."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, Literal

from pointbrush.values.base import Body, Meanings, Rule, Value
from pointbrush.values.kinds import VISIBLE, FrameIndex, PaintId, Share, Vector

Note = Annotated[str, Rule(max_length=2_000, pattern=r"^[^\x00-\x08\x0b-\x1f\x7f]*$")]
Person = Annotated[str, Rule(max_length=128, pattern=f"^{VISIBLE}*$")]
ReviewState = Annotated[
    Literal["open", "review", "accepted", "rejected"],
    Meanings(
        {
            "open": "not reviewed",
            "review": "waits for a reviewer",
            "accepted": "accepted by a reviewer",
            "rejected": "rejected by a reviewer",
        }
    ),
]
FindingKind = Annotated[
    Literal[
        "name", "category", "few", "stray", "jump", "unlike", "predicted", "returned",
        "box_jump", "box_size", "box_overlap", "box_ground", "box_empty", "box_outside",
        "box_heading",
    ],
    Meanings({
        "name": "two labels have one name",
        "category": "a label has no category",
        "few": "a label has few points",
        "stray": "points are far from their object",
        "jump": "a track jumps",
        "unlike": "a frame differs from its neighbours",
        "predicted": "a classifier labelled points with low confidence",
        "returned": "a label was found again, in doubt, after it was hidden",
        "box_jump": "a box jumps or turns between frames",
        "box_size": "a box has another size than its class",
        "box_overlap": "two boxes overlap",
        "box_ground": "a box floats above the ground or is sunk in it",
        "box_empty": "a box contains no points",
        "box_outside": "points of the label are outside its box",
        "box_heading": "the heading of a box contradicts its motion",
    }),
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class NotePatch(Body):
    """A note and an assignee to set; missing fields and null do not change."""

    note: Note | None = None
    """New note; empty: removes the note."""
    place: Vector | None = None
    """Position that the note is pinned to, source coordinates, metres."""
    assignee: Person | None = None
    """Account that the work is assigned to; empty: any."""


@dataclass(frozen=True, slots=True)
class FrameReviewPatch(NotePatch):
    """Values to set; missing fields and null do not change."""

    state: ReviewState | None = None
    """New state; accepting and rejecting need the role reviewer."""
    label: PaintId | None = None
    """Id of a label to review instead of the frames themselves."""


@dataclass(frozen=True, slots=True)
class ReviewPatch(FrameReviewPatch):
    """Values for a range of frames, or for a label in all frames."""

    first: FrameIndex | None = None
    """First frame; null: the label as a whole."""
    last: FrameIndex | None = None
    """Last frame, included."""


@dataclass(frozen=True, slots=True)
class ReviewedFrames(Value):
    """Frames, or a label in them, that a review is about."""

    first: int | None
    """First frame; null: the label as a whole."""
    last: int | None
    """Last frame, included."""
    label: int | None
    """Id of the label; null: the frames themselves."""


@dataclass(frozen=True, slots=True)
class Standing(ReviewedFrames):
    """Review state of frames, or of a label."""

    state: ReviewState
    """Current state."""
    note: str
    """Note of a person; may be empty."""
    place: Vector | None
    """Position of the note, source coordinates, metres."""
    assignee: str
    """Name of the person that the frames are assigned to, or empty."""
    by: str
    """Name of the person who set the state or note, or empty."""
    at: datetime | None
    """Time of the last state or note."""
    changed: bool
    """Labels have changed since the decision."""


@dataclass(frozen=True, slots=True)
class ReviewOverview(Value):
    """The review of a recording."""

    counts: Mapping[ReviewState, int]
    """Number of frames in each state."""
    frames: tuple[Standing, ...]
    """Runs of reviewed frames, by label and frame."""
    labels: tuple[Standing, ...]
    """Labels that were reviewed as a whole."""
    people: tuple[str, ...]
    """Names of people who may be assigned: editors, reviewers and assignees."""


@dataclass(frozen=True, slots=True)
class Decision(ReviewedFrames):
    """A line of the review's history; null: not set by the decision."""

    state: ReviewState | None
    """State that was set."""
    note: str | None
    """Note that was set; empty: removed."""
    place: Vector | None
    """Position of the note, source coordinates, metres."""
    assignee: str | None
    """Account that the frames were assigned to; empty: not assigned."""
    by: str
    """Name of the person who decided."""
    at: datetime
    """Time of the decision."""
    revision: int
    """Revision of the recording that was reviewed."""


@dataclass(frozen=True, slots=True)
class Finding(Value):
    """A suspicious place or label; its ``id`` is the same in every check until it is gone."""

    id: str
    """Id, unique in the recording."""
    kind: FindingKind
    """Check that found it."""
    text: str
    """Sentence for people."""
    labels: tuple[int, ...]
    """Ids of its labels; empty: about frames."""
    first: int | None
    """First frame; null: about the palette."""
    last: int | None
    """Last frame, included."""
    place: Vector | None
    """Position in frame ``first``, source coordinates, metres."""
    settled: bool
    """Its frames or labels are accepted."""


@dataclass(frozen=True, slots=True)
class Checked(Value):
    """Findings, and parts that could not be checked."""

    findings: tuple[Finding, ...]
    """Findings in order of importance."""
    unchecked: tuple[str, ...]
    """A sentence for each skipped check."""


@dataclass(frozen=True, slots=True)
class LabelAgreement(Value):
    """Agreement on a label, by name."""

    name: str
    """Name of the label or category."""
    iou: Share
    """Intersection over union of its points, 0 to 1."""
    first: int
    """Number of its points in the first annotation."""
    second: int
    """Number of its points in the second annotation."""
    both: int
    """Number of its points in both annotations."""


@dataclass(frozen=True, slots=True)
class FrameAgreement(Value):
    """Agreement in a frame."""

    frame: int
    """Number of the frame."""
    labelled: int
    """Number of points that either annotation labels."""
    differ: int
    """Number of these points with different labels."""


@dataclass(frozen=True, slots=True)
class BoxScore(Value):
    """Boxes of the second annotation compared with the first."""

    iou: Share
    """Smallest 3D intersection over union of boxes that match."""
    ap: Share
    """Average precision, 0 to 1."""
    precision: Share
    """Share of the second's boxes that match, 0 to 1."""
    recall: Share
    """Share of the first's boxes that match, 0 to 1."""


@dataclass(frozen=True, slots=True)
class ClassAgreement(Value):
    """Agreement on the boxes of a class, counted in each frame."""

    name: str
    """Name of the class."""
    first: int
    """Number of boxes in the first annotation."""
    second: int
    """Number of boxes in the second annotation."""
    mean_iou: Share | None
    """Mean 3D intersection over union of overlapping boxes; null: none overlap."""
    scores: tuple[BoxScore, ...]
    """Scores by smallest overlap."""


@dataclass(frozen=True, slots=True)
class BoxAgreement(Value):
    """Agreement of boxes."""

    classes: tuple[ClassAgreement, ...]
    """Agreement by class."""
    hota: Share | None
    """Higher order tracking accuracy, 0 to 1; null without boxes or the package trackeval."""


@dataclass(frozen=True, slots=True)
class Agreement(Value):
    """Agreement of two annotations of the same points."""

    miou: Share | None
    """Mean of the labels' IoU, 0 to 1; null if neither has labels."""
    same: Share | None
    """Share of labelled points with equal labels, 0 to 1; null if neither has labels."""
    labels: tuple[LabelAgreement, ...]
    """Agreement by label."""
    frames: tuple[FrameAgreement, ...]
    """Agreement by frame."""
    boxes: BoxAgreement | None = None
    """Agreement of boxes, only on request."""
