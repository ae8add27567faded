"""Parts of messages of both sides: checked numbers, strokes, labels, chunks."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from pointbrush.roles import Role as Role

Id = Annotated[str, Field(min_length=1, max_length=64)]
Uuid = Annotated[
    str, Field(pattern=r"^[0-9a-fA-F]{8}(-[0-9a-fA-F]{4}){3}-[0-9a-fA-F]{12}$", max_length=36)
]
FrameIndex = Annotated[int, Field(ge=0, lt=2**31)]
Count = Annotated[int, Field(ge=0, lt=2**53)]
Pair = Annotated[list[Count], Field(min_length=2, max_length=2)]
FARTHEST = 1e12
"""The largest number of a position, in metres; squares of squares of it are still numbers."""
Finite = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST, allow_inf_nan=False)]
Vec3 = Annotated[list[Finite], Field(min_length=3, max_length=3)]
Quaternion = Annotated[list[Finite], Field(min_length=4, max_length=4)]
Pose = Annotated[list[Finite], Field(min_length=7, max_length=7)]
"""Position x, y, z then quaternion x, y, z, w."""
Matrix4 = Annotated[list[Finite], Field(min_length=16, max_length=16)]
"""Row-major 4x4."""
LabelId = Annotated[int, Field(ge=0, le=65534)]
Color = Annotated[str, Field(pattern=r"^#[0-9a-fA-F]{6}$")]

Tool = Literal["paint", "erase", "delete", "restore"]
JobState = Literal["queued", "running", "done", "failed", "cancelled"]


class Message(BaseModel):
    """Base: unknown fields are refused, types are not coerced."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Sample(Message):
    """One sample of the controller or mouse: a ray, and the time since the stroke began."""

    origin: Vec3
    direction: Vec3 = [0.0, 0.0, -1.0]
    t: Finite = 0.0


class Label(Message):
    """An entry of the palette."""

    id: LabelId
    name: str
    category: str
    color: Color
    locked: bool
    visible: bool


class Lattice(Message):
    """Pixels of a depth camera; all frames of a recording have the same.

    With a depth of d units, the point of pixel (column, row) lies d * ``unit`` metres from ``eye``
    along ``sign`` times axis ``axis``, and (``tangent`` + ``pitch`` * pixel) times as far along the
    other two axes: the first one with the column, the second with the row.
    """

    width: Count
    height: Count
    axis: Annotated[int, Field(ge=0, le=2)]
    sign: Literal[-1, 1]
    tangent: Annotated[list[Finite], Field(min_length=2, max_length=2)]
    pitch: Annotated[list[Finite], Field(min_length=2, max_length=2)]
    eye: Vec3
    """Local coordinates (source minus shift)."""
    unit: Finite


class DepthChunk(Message):
    """A run of points that is a band of a depth image: docs/depth-format.md."""

    index: Count
    level: Annotated[int, Field(ge=0, le=64)]
    first: Count
    count: Count
    offset: Count
    """Byte offset in the message's ``data``."""
    nbytes: Count
    lo: Vec3
    hi: Vec3


class Chunk(Message):
    """A run of points, encoded with the meshoptimizer vertex codec, 12 bytes a point.

    Decoded layout: x, y, z uint16; r, g, b, intensity uint8; flags uint8; a byte zero.
    Where bit 0 of the first vertex's flags is set, all of r and b are less g (modulo 256).
    Bits 1 and 2 say how many low bits r, g and b have lost: value = v << n | v >> (8 - 2n); with
    n = 3 the bytes of r and g are a little-endian word of r (lowest), g and b in 5, 6 and 5 bits.
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
