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
    SensorInfo,
    Share,
    Uuid,
    Vec3,
)
from pointbrush.work.loops.compiling import StepName


class Welcome(Message):
    """The answer to ``hello``."""

    type: Literal["welcome"] = "welcome"
    viewer: Id
    author: str
    role: Role
    version: str
    credits: int
    """Frame messages that the server may send before the client returns a credit."""
    account: str = ""
    """The account to which edits and jobs belong; ``author`` is its displayed name."""


class SequenceInfo(Message):
    """The answer to ``open``; sent again when the manifest changes."""

    type: Literal["sequence"] = "sequence"
    id: Id
    identity: Id
    """Id of this import and of the corrections of its sensors' mounts: data of another one is void,
    even under the same ``id``."""
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
    """``T_room_local``: places the recording on the floor, y up, metres."""
    cameras: bool
    """True: some or all frames have camera pictures."""
    large: bool
    """True: chunks form an octree; request them with ``want``, and their table over HTTP."""
    position_error: float
    """Greatest difference of a streamed and the stored coordinate, metres per axis."""
    color_error: float
    """Greatest root mean square difference of a ``depth`` frame's colours from the stored ones."""
    lattice: Lattice | None
    """The pixels of ``depth`` messages; null: there are none, or each sensor has its own."""
    sensors: list[SensorInfo]
    """Sensors by number, if the recording has several; else none."""
    revision: Count
    frame: FrameIndex


class Frame(Message):
    """Chunks of a frame in stored order: a prefix of the frame, or its continuation.

    For a large frame: the requested chunks.  The whole ``annotation`` of these points comes just
    before, so that points never show without their labels.
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
    """Chunks of a frame as parts of a depth image, instead of ``frame``; same chunk numbers.

    Sent to clients that set ``depth`` in ``hello``.  A chunk needs the depths of all chunks of its
    sensor before it.
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

    A value is a label id, 0 for unlabeled, or 65535 for a deleted point.
    Whole: runs over [first, first + count): ``lengths`` uint32 and ``values`` uint16, as many.
    Delta: ``lengths`` holds sorted uint32 point numbers, ``values`` one uint16 for each, or a
    single one for all.  A client that applies all messages in order of arrival is always right.
    ``base`` is not older than the last change of the frame and not newer than the viewer's labels.
    A client with labels of the frame older than ``base`` has missed a message and sends
    ``open`` with the last revision that it knows to be complete.  The server answers ``sequence``,
    which holds for all frames of the client; the deltas up to its revision follow.
    """

    type: Literal["annotation"] = "annotation"
    sequence: Id
    frame: FrameIndex
    revision: Count
    base: Count | None
    edit: str | None = None
    author: str | None = None
    provisional: bool = False
    """True: a result of a tracking run that is not committed yet."""
    first: Count = 0
    count: Count = 0
    lengths: bytes
    values: bytes


class StrokeResult(Message):
    """``touched``: number of points touched so far; ``final``: the edit is durable.

    ``changed``: number of touched points that the stroke changes; it drives the haptic pulse.
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

    ``id`` is opaque and becomes void when the frame or the clicks change; it is empty for the
    regions of other shapes.  ``score``: the expected overlap with the object, 0..1.
    """

    id: Annotated[str, Field(max_length=64)]
    level: Count
    score: float
    points: Count
    runs: bytes


class Candidates(Message):
    """The answer to ``ask``: at most six candidates from part to group.

    ``first``: the candidate to show first.  ``ready``: the whole frame is prepared; otherwise the
    candidates come from the points near the clicks.
    """

    type: Literal["candidates"] = "candidates"
    id: Uuid
    frame: FrameIndex
    first: Count
    ready: bool
    candidates: list[Candidate]


class Prepared(Message):
    """A frame is prepared for the object tool: further answers use all its points."""

    type: Literal["prepared"] = "prepared"
    sequence: Id
    frame: FrameIndex


class Compiling(Message):
    """Progress of a step of compiling loops, which a server does once on its machine.

    Sent after ``welcome`` for each step that is not done, and at each hundredth; with ``share`` 1
    a step is done.  Questions about objects wait for ``objects``, tracking runs for ``things``.
    """

    type: Literal["compiling"] = "compiling"
    step: StepName
    share: Share
    seconds: float | None
    """Time that probably remains; null: the step has not begun."""


class Labels(Message):
    """The whole palette, and the number of points of each label in all frames."""

    type: Literal["labels"] = "labels"
    sequence: Id
    revision: Count
    labels: list[Label]
    counts: dict[str, Count]
    undo: str | None
    """Summary of the edit that an undo of this author would take back, or null."""
    redo: str | None


class Timeline(Message):
    """Changed cells (all cells after ``open``); remove a cell without points and state.

    A cell is a label in a frame.  Each array has one item for each cell.
    """

    type: Literal["timeline"] = "timeline"
    sequence: Id
    revision: Count
    whole: bool
    frames: bytes
    """uint32."""
    labels: bytes
    """uint16."""
    points: bytes
    """uint32."""
    painted: bytes
    """uint32: the number of points that a person painted."""
    confidence: bytes
    """float32, 0..1; NaN where the label was not tracked."""
    states: bytes
    """uint8: 0 none, 1 painted, 2 tracked, 3 occluded, 4 lost."""


class Boxes(Message):
    """Changed boxes in their new state, and the ids of removed boxes.

    Sent with all boxes after ``open`` (``whole``), and then with every edit that changes boxes.
    """

    type: Literal["boxes"] = "boxes"
    sequence: Id
    revision: Count
    whole: bool
    boxes: list[Box]
    removed: list[BoxId]


class Job(Message):
    """State and progress of a job."""

    type: Literal["job"] = "job"
    id: Id
    kind: Literal["import", "tracking", "export", "prediction", "fitting", "alignment"]
    sequence: str | None
    state: JobState
    progress: float
    message: str
    frame: FrameIndex | None = None
    error: str | None = None
    edit: str | None = None
    """The edit that the job makes: the id of the ``track`` message that started it."""
    owner: str = ""
    """The account that started the job; this account and managers may stop it."""


class ServerPresence(Message):
    """Position of another person; ``left``: the person has left."""

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
    """RFC 9457 fields; ``about`` is the id of the refused stroke, undo, track or ask, if any."""

    type: Literal["error"] = "error"
    title: str
    detail: str
    status: int
    about: str | None = None
    closed: str | None = None
    """The sequence that was closed for this viewer: it was deleted or cannot be read."""


ServerMessage = Annotated[
    Welcome
    | SequenceInfo
    | Frame
    | Depth
    | Annotation
    | StrokeResult
    | Candidates
    | Prepared
    | Compiling
    | Labels
    | Timeline
    | Boxes
    | Job
    | ServerPresence
    | Error,
    Field(discriminator="type"),
]
