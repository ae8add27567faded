"""Every message of the WebSocket, once.

TypeScript is generated from these models (``pointbrush.streaming.typescript``); the subprotocol
carries a hash of their schema, so that a stale page is refused instead of misread.  A message is
one msgpack map with ``type``.  Points are numbered in *stored order* here (the progressive order
of the frame store); coordinates are metres in the source's frame unless a field says otherwise.
Packed arrays are little-endian ``bytes``.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

Id = Annotated[str, Field(min_length=1, max_length=64)]
Uuid = Annotated[
    str, Field(pattern=r"^[0-9a-fA-F]{8}(-[0-9a-fA-F]{4}){3}-[0-9a-fA-F]{12}$", max_length=36)
]
FrameIndex = Annotated[int, Field(ge=0, lt=2**31)]
Count = Annotated[int, Field(ge=0, lt=2**53)]
Pair = Annotated[list[Count], Field(min_length=2, max_length=2)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Vec3 = Annotated[list[Finite], Field(min_length=3, max_length=3)]
Quaternion = Annotated[list[Finite], Field(min_length=4, max_length=4)]
Pose = Annotated[list[Finite], Field(min_length=7, max_length=7)]
"""Position x, y, z then quaternion x, y, z, w."""
Matrix4 = Annotated[list[Finite], Field(min_length=16, max_length=16)]
"""Row-major 4x4."""
LabelId = Annotated[int, Field(ge=0, le=65534)]
Color = Annotated[str, Field(pattern=r"^#[0-9a-fA-F]{6}$")]

Tool = Literal["paint", "erase", "delete", "restore"]
Shape = Literal["sphere", "ray", "lasso", "box", "grow", "plane"]
Role = Literal["viewer", "annotator", "reviewer", "admin"]
JobState = Literal["queued", "running", "done", "failed", "cancelled"]


class Message(BaseModel):
    """Base: unknown fields are refused, types are not coerced."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


# ── shared pieces ────────────────────────────────────────────────────────────────────────────


class Sample(Message):
    """One sample of the controller or mouse: a ray, and the time since the stroke began."""

    origin: Vec3
    direction: Vec3 = [0.0, 0.0, -1.0]
    t: Finite = 0.0


class Brush(Message):
    """What a stroke does with its samples; see the contract for each shape."""

    label: LabelId = 0
    tool: Tool = "paint"
    shape: Shape = "sphere"
    radius: Annotated[float, Field(gt=0, le=1000, allow_inf_nan=False)] = 0.05
    only_unlabeled: bool = False
    through: bool = False
    polygon: (
        Annotated[
            list[Annotated[list[Finite], Field(min_length=2, max_length=2)]], Field(max_length=4096)
        ]
        | None
    ) = None
    """lasso: vertices in normalised device coordinates, x right and y up, -1..1."""
    matrix: Matrix4 | None = None
    """lasso: ``clip_from_source``, the camera's projection times view, row-major."""
    center: Vec3 | None = None
    size: Vec3 | None = None
    """box: full edge lengths."""
    quaternion: Quaternion | None = None
    """box: orientation x, y, z, w."""


class Label(Message):
    """An entry of the palette."""

    id: LabelId
    name: str
    category: str
    color: Color
    locked: bool
    visible: bool


class Chunk(Message):
    """A run of points, encoded with the meshoptimizer vertex codec, 12 bytes a point.

    Decoded layout: x, y, z uint16; r, g, b, intensity uint8; flags uint8; a byte zero.
    Where bit 0 of the first vertex's flags is set, all of r and b are less g (modulo 256).
    Position = ``origin + q * scale``, in the sequence's local coordinates (source minus shift).
    """

    index: Count
    level: Annotated[int, Field(ge=0, le=64)]
    first: Count
    count: Count
    offset: Count
    """Byte offset in the message's ``data`` (in a frame message) or in the frame's wire file."""
    nbytes: Count
    origin: Vec3
    scale: Vec3
    lo: Vec3
    hi: Vec3


# ── client to server ─────────────────────────────────────────────────────────────────────────


class Hello(Message):
    """The first message: who this is; answered with ``welcome``."""

    type: Literal["hello"] = "hello"
    name: Annotated[str, Field(max_length=64)] = ""
    color: Color | None = None


class Open(Message):
    """Open a sequence; ``revision`` is the last one the client has, when it resumes.

    ``held`` lists the frames that it still has, each with the number of chunks from the first on:
    these are not sent again.  Without it, edits in all frames are told and points come anew.
    """

    type: Literal["open"] = "open"
    sequence: Id
    frame: FrameIndex = 0
    revision: Count | None = None
    held: Annotated[list[Pair], Field(max_length=65536)] | None = None


class Play(Message):
    """Send frames in time with a clock that starts at ``frame`` when this arrives."""

    type: Literal["play"] = "play"
    frame: FrameIndex
    speed: Annotated[float, Field(ge=-16, le=16, allow_inf_nan=False)] = 1.0
    loop: bool = True


class Pause(Message):
    """Stop the clock, at ``frame`` if given; that frame is refined to all its points."""

    type: Literal["pause"] = "pause"
    frame: FrameIndex | None = None


class Seek(Message):
    """Show one frame: its first levels at once, then refinement up to all points."""

    type: Literal["seek"] = "seek"
    frame: FrameIndex


class Credit(Message):
    """The client applied ``frames`` frame messages and may be sent as many more.

    With 0 of them it only says how the page keeps up.  ``frame_ms`` is the page's measured time per rendered frame, ``target_ms`` what its display
    wants; a page that falls behind is sent fewer points.  ``points`` caps points per frame.
    """

    type: Literal["credit"] = "credit"
    frames: Annotated[int, Field(ge=0, le=64)] = 1
    nbytes: Count = 0
    decode_ms: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.0
    frame_ms: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.0
    target_ms: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.0
    points: Count | None = None


class Forget(Message):
    """Frames that the client dropped from its cache and must be sent again when shown."""

    type: Literal["forget"] = "forget"
    frames: Annotated[list[FrameIndex], Field(max_length=65536)]


class Want(Message):
    """Chunks of a large frame, most wanted first; replaces the previous list."""

    type: Literal["want"] = "want"
    frame: FrameIndex
    chunks: Annotated[list[Count], Field(max_length=4096)]


class StrokeBegin(Message):
    """A stroke starts; the same ``id`` sent again after a lost connection applies once."""

    type: Literal["stroke_begin"] = "stroke_begin"
    id: Uuid
    frame: FrameIndex
    brush: Brush


class StrokeSamples(Message):
    """More samples of a stroke; answered with ``stroke_result``, not final."""

    type: Literal["stroke_samples"] = "stroke_samples"
    id: Uuid
    samples: Annotated[list[Sample], Field(max_length=4096)]


class StrokeEnd(Message):
    """The stroke is over; answered with a final ``stroke_result`` once it is durable."""

    type: Literal["stroke_end"] = "stroke_end"
    id: Uuid


class Undo(Message):
    """Take back this author's last edit; answered with a final ``stroke_result``."""

    type: Literal["undo"] = "undo"
    id: Uuid


class Redo(Message):
    """Bring back what this author's last undo took; answered like ``undo``."""

    type: Literal["redo"] = "redo"
    id: Uuid


class Track(Message):
    """Start a tracking run; its ``job`` messages follow."""

    type: Literal["track"] = "track"
    id: Uuid
    labels: Annotated[list[LabelId], Field(max_length=65534)] | None = None
    start: FrameIndex
    stop: FrameIndex
    method: Annotated[str, Field(max_length=64)] = "auto"
    overwrite: Literal["never", "tracked", "all"] = "tracked"
    stop_unsure: bool = False
    """End the run at the first frame where a label is found with little confidence, or lost."""


class ClientPresence(Message):
    """Where this person is, in room coordinates (y up, metres); absent parts are null."""

    type: Literal["presence"] = "presence"
    frame: FrameIndex = 0
    head: Pose | None = None
    hands: Annotated[list[Pose | None], Field(max_length=2)] = []
    brush: Vec3 | None = None
    radius: Annotated[float, Field(ge=0, le=1000, allow_inf_nan=False)] = 0.0
    label: LabelId = 0


ClientMessage = Annotated[
    Hello
    | Open
    | Play
    | Pause
    | Seek
    | Credit
    | Forget
    | Want
    | StrokeBegin
    | StrokeSamples
    | StrokeEnd
    | Undo
    | Redo
    | Track
    | ClientPresence,
    Field(discriminator="type"),
]


# ── server to client ─────────────────────────────────────────────────────────────────────────


class Welcome(Message):
    """The answer to ``hello``."""

    type: Literal["welcome"] = "welcome"
    viewer: Id
    author: str
    role: Role
    version: str
    credits: int
    """Frame messages that the server may send before the first credit comes back."""


class SequenceInfo(Message):
    """The answer to ``open``, and sent again when the manifest changes."""

    type: Literal["sequence"] = "sequence"
    id: Id
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
    large: bool
    """True: chunks form an octree, ask for them with ``want``; the table comes over HTTP."""
    position_error: float
    """Greatest distance between a streamed coordinate and the stored one, metres per axis."""
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


class Annotation(Message):
    """Label values of a frame's points, whole (``base`` null) or as a delta from ``base``.

    A value is a label id, 0 unlabeled, or 65535 for a deleted point.
    whole: runs over [first, first + count): ``lengths`` uint32 and ``values`` uint16, as many.
    delta: ``lengths`` holds sorted uint32 point numbers, ``values`` one uint16 for each, or a
    single one for all; ``base`` is the revision that last changed this frame.  Who applies all of
    them in the order they come is always right; who holds the frame at a revision below ``base``
    has missed something and sends ``open`` with the last revision it is sure of.
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


class Job(Message):
    """Long work and how far it is."""

    type: Literal["job"] = "job"
    id: Id
    kind: Literal["import", "tracking", "export"]
    sequence: str | None
    state: JobState
    progress: float
    message: str
    frame: FrameIndex | None = None
    error: str | None = None


class ServerPresence(Message):
    """Where somebody else is; ``left``: they have gone."""

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
    """RFC 9457 fields; ``about`` is the id of the stroke, undo or track refused, if any."""

    type: Literal["error"] = "error"
    title: str
    detail: str
    status: int
    about: str | None = None


ServerMessage = Annotated[
    Welcome
    | SequenceInfo
    | Frame
    | Annotation
    | StrokeResult
    | Labels
    | Timeline
    | Job
    | ServerPresence
    | Error,
    Field(discriminator="type"),
]
