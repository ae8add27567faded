"""Messages that the server sends."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from pointbrush.streaming.messages.values import (
    Box,
    BoxId,
    Chunk,
    Color,
    Count,
    DepthChunk,
    FrameIndex,
    Id,
    JobState,
    Label,
    LabelId,
    Lattice,
    Matrix4,
    Message,
    Pose,
    Role,
    Uuid,
    Vec3,
)


class Welcome(Message):
    """The answer to ``hello``."""

    type: Literal["welcome"] = "welcome"
    viewer: Id
    author: str
    role: Role
    version: str
    credits: int
    """Frame messages that the server may send before the first credit comes back."""
    account: str = ""
    """The account that edits and jobs are by; ``author`` is the name shown for it."""


class SequenceInfo(Message):
    """The answer to ``open``, and sent again when the manifest changes."""

    type: Literal["sequence"] = "sequence"
    id: Id
    identity: Id
    """Of this import: what is held of another one, also under the same ``id``, is void."""
    name: str
    frames: Count
    fps: float
    points: list[Count]
    fields: list[str]
    shift: Vec3
    lo: Vec3
    hi: Vec3
    """Bounds over all frames, in local coordinates (source minus shift)."""
    room: Matrix4
    """``T_room_local``: stands the recording on the floor, y up, metres."""
    cameras: bool
    """True: cameras took pictures of its frames, of all or some."""
    large: bool
    """True: chunks form an octree, ask for them with ``want``; the table comes over HTTP."""
    position_error: float
    """Greatest distance between a streamed coordinate and the stored one, metres per axis."""
    color_error: float
    """Greatest root mean square of what a ``depth`` frame's colours differ from the stored ones."""
    lattice: Lattice | None
    """The pixels of ``depth`` messages; null: there are none."""
    revision: Count
    frame: FrameIndex


class Frame(Message):
    """Chunks of a frame, in stored order: a prefix, or what refines the prefix sent before.

    Of a large frame, the chunks asked for.  The ``annotation`` of these points, whole, comes just
    before, so that they never show without their labels.
    """

    type: Literal["frame"] = "frame"
    sequence: Id
    frame: FrameIndex
    total: Count
    final: bool
    """The frame is complete at the client once this is applied."""
    chunks: list[Chunk]
    data: bytes


class Depth(Message):
    """Chunks of a frame as parts of a depth image, in place of ``frame``; numbers are the same.

    Sent to who said ``depth`` in ``hello``.  A chunk needs the depths of all before it.
    """

    type: Literal["depth"] = "depth"
    sequence: Id
    frame: FrameIndex
    total: Count
    final: bool
    """The frame is complete at the client once this is applied."""
    chunks: list[DepthChunk]
    data: bytes


class Annotation(Message):
    """Label values of a frame's points, whole (``base`` null) or as a delta from ``base``.

    A value is a label id, 0 unlabeled, or 65535 for a deleted point.
    whole: runs over [first, first + count): ``lengths`` uint32 and ``values`` uint16, as many.
    delta: ``lengths`` holds sorted uint32 point numbers, ``values`` one uint16 for each, or a
    single one for all.  Who applies all of them in the order they come is always right.  ``base``
    is no older than the last change of the frame and no newer than what the viewer has: who holds
    the frame at a revision below it has missed something and sends ``open`` with the last revision
    it is sure of.  The answer to that, ``sequence``, counts for all that is held: the deltas up to
    its revision follow.
    """

    type: Literal["annotation"] = "annotation"
    sequence: Id
    frame: FrameIndex
    revision: Count
    base: Count | None
    edit: str | None = None
    author: str | None = None
    provisional: bool = False
    """A tracking run's finding, shown before the run is committed."""
    first: Count = 0
    count: Count = 0
    lengths: bytes
    values: bytes


class StrokeResult(Message):
    """``touched``: newly touched points so far; ``final`` once the edit is durable.

    ``changed``: those of them that the stroke changes; what the hand feels.
    """

    type: Literal["stroke_result"] = "stroke_result"
    id: Uuid
    frame: FrameIndex
    touched: Count
    changed: Count
    edit: str | None
    revision: Count
    final: bool


class Candidate(Message):
    """Points that a click would take: ``runs`` holds first number and length, uint32 each.

    ``id`` is opaque, and void once the frame or the clicks change; empty for the regions of other
    shapes.  ``score``: the overlap with the object that is expected, 0..1.
    """

    id: Annotated[str, Field(max_length=64)]
    level: Count
    score: float
    points: Count
    runs: bytes


class Candidates(Message):
    """The answer to ``ask``: at most six candidates from part to group.

    ``first``: the one to show first.  ``ready``: the whole frame is prepared; else they come from
    what is near the clicks.
    """

    type: Literal["candidates"] = "candidates"
    id: Uuid
    frame: FrameIndex
    first: Count
    ready: bool
    candidates: list[Candidate]


class Prepared(Message):
    """A frame is prepared for the object tool: what is asked of it is answered from all of it."""

    type: Literal["prepared"] = "prepared"
    sequence: Id
    frame: FrameIndex


class Labels(Message):
    """The palette, whole; and how many points each label has in all frames together."""

    type: Literal["labels"] = "labels"
    sequence: Id
    revision: Count
    labels: list[Label]
    counts: dict[str, Count]
    undo: str | None
    """Summary of the edit that this author's undo would take back, or null."""
    redo: str | None


class TimelineCell(Message):
    """One label in one frame: how many points, where from, how sure."""

    frame: FrameIndex
    label: LabelId
    points: Count
    painted: Count
    confidence: float | None
    state: Literal["painted", "tracked", "occluded", "lost"] | None


class Timeline(Message):
    """Cells that changed (all of them after ``open``); one without points and state goes."""

    type: Literal["timeline"] = "timeline"
    sequence: Id
    revision: Count
    whole: bool
    cells: list[TimelineCell]


class Boxes(Message):
    """Boxes that changed, as they are now, and ids of those that are gone.

    After ``open`` all there are (``whole``), and then with every edit that changes boxes.
    """

    type: Literal["boxes"] = "boxes"
    sequence: Id
    revision: Count
    whole: bool
    boxes: list[Box]
    removed: list[BoxId]


class Job(Message):
    """Long work and how far it is."""

    type: Literal["job"] = "job"
    id: Id
    kind: Literal["import", "tracking", "export", "prediction", "fitting"]
    sequence: str | None
    state: JobState
    progress: float
    message: str
    frame: FrameIndex | None = None
    error: str | None = None
    edit: str | None = None
    """The edit that it makes: the id of the ``track`` that asked for it."""
    owner: str = ""
    """The account that began it: it may stop the job, and whoever manages."""


class ServerPresence(Message):
    """Place of another person; ``left``: they have gone."""

    type: Literal["presence"] = "presence"
    viewer: Id
    name: str
    color: Color
    left: bool
    frame: FrameIndex
    head: Pose | None
    hands: list[Pose | None]
    brush: Vec3 | None
    radius: float
    label: LabelId


class Error(Message):
    """RFC 9457 fields; ``about`` is the id of the stroke, undo, track or ask refused, if any."""

    type: Literal["error"] = "error"
    title: str
    detail: str
    status: int
    about: str | None = None
    closed: str | None = None
    """The sequence that is no longer open to this viewer: it was deleted, or cannot be read."""


ServerMessage = Annotated[
    Welcome
    | SequenceInfo
    | Frame
    | Depth
    | Annotation
    | StrokeResult
    | Candidates
    | Prepared
    | Labels
    | Timeline
    | Boxes
    | Job
    | ServerPresence
    | Error,
    Field(discriminator="type"),
]
