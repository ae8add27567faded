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
    Uuid,
    Vec3,
)
from pointbrush.work.tracking.options import RunOptions


class Hello(Message):
    """The first message: who this is; answered with ``welcome``."""

    type: Literal["hello"] = "hello"
    name: Annotated[str, Field(max_length=64)] = ""
    color: Color | None = None
    depth: bool = False
    """Frames of depth cameras may come as ``depth`` messages in place of ``frame``."""


class Open(Message):
    """Open a sequence; ``revision`` is the last one the client has, when it resumes.

    ``held`` lists the frames that it still has, each with the number of chunks from the first on:
    these are not sent again.  Without it, edits in all frames are told and points come anew.
    ``identity`` is the import's that both are of: another one of this name is opened from new.
    """

    type: Literal["open"] = "open"
    sequence: Id
    frame: FrameIndex = 0
    identity: Id | None = None
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
    """Show one frame: its first levels at once, then refinement up to all points.

    ``around``: frames that are laid over it, sent as it is, after it and in this order.
    """

    type: Literal["seek"] = "seek"
    frame: FrameIndex
    around: Annotated[list[FrameIndex], Field(max_length=MAX_FRAMES, default_factory=list)]


class Credit(Message):
    """The client applied ``frames`` frame messages and may be sent as many more.

    With 0 of them it only says how the page keeps up.  ``frame_ms`` is the page's measured time
    per rendered frame, ``target_ms`` what its display wants; a page that falls behind is sent
    fewer points.  ``points`` caps points per frame.
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


class StrokeCancel(Message):
    """The stroke is given up before its end: nothing of it stays; there is no answer."""

    type: Literal["stroke_cancel"] = "stroke_cancel"
    id: Uuid


class Ask(Message):
    """Request of what a stroke of shape ``object``, ``grow``, ``cluster`` or ``plane`` would take.

    The newest request counts: one that still waits when another comes is not answered.  Without
    ``samples``: only whether the frame is prepared for objects, which it is from then on.
    """

    type: Literal["ask"] = "ask"
    id: Uuid
    frame: FrameIndex
    brush: Brush
    samples: Annotated[list[Sample], Field(max_length=64)]
    """Rays at the object, or where the region is."""
    negatives: Annotated[list[Sample], Field(max_length=64, default_factory=list)]
    """Rays at what is no part of the object."""
    previous: Annotated[str, Field(max_length=64)] = ""
    """The candidate taken so far: what is offered keeps to it as far as the clicks allow."""


class Undo(Message):
    """Take back this author's last edit; answered with a final ``stroke_result``."""

    type: Literal["undo"] = "undo"
    id: Uuid


class Redo(Message):
    """Bring back what this author's last undo took; answered like ``undo``."""

    type: Literal["redo"] = "redo"
    id: Uuid


class Track(Message, RunOptions):
    """Start a tracking run; its ``job`` messages follow."""

    type: Literal["track"] = "track"
    id: Uuid
    labels: Annotated[list[LabelId], Field(max_length=65534)] | None = None
    start: FrameIndex
    stop: FrameIndex
    method: Annotated[str, Field(max_length=64)] = RunOptions.method


class ClientPresence(Message):
    """Place of this person, in room coordinates (y up, metres); absent parts are null."""

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
