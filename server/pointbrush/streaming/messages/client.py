"""Messages that a page sends."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from pointbrush.selection import MAX_FRAMES
from pointbrush.streaming.messages.values import (
    Brush,
    Color,
    Count,
    FrameIndex,
    Id,
    LabelId,
    Message,
    Pair,
    Pose,
    Sample,
    TouchedPoints,
    Uuid,
    Vec3,
)
from pointbrush.values.runs import TrackingOptions


class Hello(Message):
    """First message: the name and colour of the person; the server answers ``welcome``."""

    type: Literal["hello"] = "hello"
    name: Annotated[str, Field(max_length=64)] = ""
    color: Color | None = None
    depth: bool = False
    """The server may send frames of depth cameras as ``depth`` messages instead of ``frame``."""


class Open(Message):
    """Open a sequence; a client that resumes sends the last ``revision`` that it has.

    ``held`` lists the frames that the client still has, each with the number of its chunks from the
    first on; the server does not send these chunks again.  Without ``held``, it sends the edits of
    all frames and all points.  ``identity`` is the import that ``revision`` and ``held`` belong to;
    if the sequence has another identity, it is opened anew.
    """

    type: Literal["open"] = "open"
    sequence: Id
    frame: FrameIndex = 0
    identity: Id | None = None
    revision: Count | None = None
    held: Annotated[list[Pair], Field(max_length=65536)] | None = None


class Play(Message):
    """Play frames by a clock that starts at ``frame`` when this message arrives."""

    type: Literal["play"] = "play"
    frame: FrameIndex
    speed: Annotated[float, Field(ge=-16, le=16, allow_inf_nan=False)] = 1.0
    loop: bool = True


class Pause(Message):
    """Stop the clock, at ``frame`` if given; the server refines this frame to all its points."""

    type: Literal["pause"] = "pause"
    frame: FrameIndex | None = None


class Seek(Message):
    """Show one frame: its first levels at once, then refinement up to all points.

    ``around``: frames that are laid over it; they are sent likewise, after it and in this order.
    """

    type: Literal["seek"] = "seek"
    frame: FrameIndex
    around: Annotated[list[FrameIndex], Field(max_length=MAX_FRAMES, default_factory=list)]


class Credit(Message):
    """The client has applied ``frames`` frame messages; the server may send as many more.

    With 0 frames the message only reports the speed of the page.  ``frame_ms`` is the page's
    measured time per rendered frame, ``target_ms`` the time that its display allows; the server
    sends fewer points to a slow page.  ``points`` limits the points per frame.
    """

    type: Literal["credit"] = "credit"
    frames: Annotated[int, Field(ge=0, le=64)] = 1
    nbytes: Count = 0
    decode_ms: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.0
    frame_ms: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.0
    target_ms: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.0
    points: Count | None = None


class Forget(Message):
    """Frames that the client has dropped from its cache; the server sends them again when shown."""

    type: Literal["forget"] = "forget"
    frames: Annotated[list[FrameIndex], Field(max_length=65536)]


class Want(Message):
    """Chunks of a large frame in the order of urgency; the list replaces the previous one."""

    type: Literal["want"] = "want"
    frame: FrameIndex
    chunks: Annotated[list[Count], Field(max_length=4096)]


class StrokeBegin(Message):
    """A stroke starts; the server applies an ``id`` once, also when it is sent twice."""

    type: Literal["stroke_begin"] = "stroke_begin"
    id: Uuid
    frame: FrameIndex
    brush: Brush


class StrokeSamples(Message):
    """More samples of a stroke; the server answers ``stroke_result``, which is not final."""

    type: Literal["stroke_samples"] = "stroke_samples"
    id: Uuid
    samples: Annotated[list[Sample], Field(max_length=4096)]


class StrokeEnd(Message):
    """The stroke ends; the server answers a final ``stroke_result`` when the edit is durable.

    ``touched``: the points that the client found in the shape, in each frame; the server takes
    these instead of its own selection, and applies the rules of tools, locks and hidden labels to
    them.  A client may send them if it has all points of the stroke's frames; positions in chunks
    are rounded, so that its selection differs from the server's at the border of the shape.
    """

    type: Literal["stroke_end"] = "stroke_end"
    id: Uuid
    touched: Annotated[list[TouchedPoints], Field(max_length=65536)] | None = None


class StrokeCancel(Message):
    """Cancel a stroke before its end: it changes nothing, and there is no answer."""

    type: Literal["stroke_cancel"] = "stroke_cancel"
    id: Uuid


class Ask(Message):
    """Request the points that a stroke of shape object, grow, cluster or plane would take.

    The server answers the newest request and drops an older one that still waits.  Without
    ``samples``, the answer only reports whether the frame is prepared for the object tool, and the
    server prepares it.
    """

    type: Literal["ask"] = "ask"
    id: Uuid
    frame: FrameIndex
    brush: Brush
    samples: Annotated[list[Sample], Field(max_length=64)]
    """Rays at the object or at the region."""
    negatives: Annotated[list[Sample], Field(max_length=64, default_factory=list)]
    """Rays at points that do not belong to the object."""
    previous: Annotated[str, Field(max_length=64)] = ""
    """The candidate taken so far; the new candidates stay close to it if the clicks allow that."""


class Undo(Message):
    """Take back this author's last edit; the server answers a final ``stroke_result``."""

    type: Literal["undo"] = "undo"
    id: Uuid


class Redo(Message):
    """Restore the edit that this author's last undo took back; answered like ``undo``."""

    type: Literal["redo"] = "redo"
    id: Uuid


class Track(Message, TrackingOptions):  # type: ignore[misc]
    """Start a tracking run; the server sends its ``job`` messages."""

    type: Literal["track"] = "track"
    id: Uuid
    labels: Annotated[list[LabelId], Field(max_length=65534)] | None = None
    start: FrameIndex
    stop: FrameIndex
    method: Annotated[str, Field(max_length=64)] = TrackingOptions.method


class ClientPresence(Message):
    """Position of this person in room coordinates (y up, metres); missing parts are null."""

    type: Literal["presence"] = "presence"
    frame: FrameIndex = 0
    head: Pose | None = None
    hands: Annotated[list[Pose | None], Field(max_length=2, default_factory=list)]
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
    | StrokeCancel
    | Ask
    | Undo
    | Redo
    | Track
    | ClientPresence,
    Field(discriminator="type"),
]
