"""Parts of messages of both sides: checked numbers, strokes, labels, chunks, and the brush.

The brush is derived from the table of shapes (``pointbrush.selection.SHAPES``).
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, create_model

from pointbrush.selection import MAX_FRAMES, SHAPES, TOOLS
from pointbrush.selection.box import BOX
from pointbrush.selection.shape import Numbers, Parameter, Rays
from pointbrush.values.boxes import Box as Box
from pointbrush.values.boxes import BoxPose as BoxPose
from pointbrush.values.kinds import MOST_SENSORS
from pointbrush.values.kinds import Color as Color
from pointbrush.values.kinds import Count as Count
from pointbrush.values.kinds import Finite as Finite
from pointbrush.values.kinds import FrameIndex as FrameIndex
from pointbrush.values.kinds import LabelId as LabelId
from pointbrush.values.kinds import Role as Role
from pointbrush.values.kinds import SensorType as SensorType
from pointbrush.values.kinds import Share as Share
from pointbrush.values.kinds import Uuid as Uuid

Id = Annotated[str, Field(min_length=1, max_length=64)]
Pair = Annotated[list[Count], Field(min_length=2, max_length=2)]
Vec3 = Annotated[list[Finite], Field(min_length=3, max_length=3)]
Quaternion = Annotated[list[Finite], Field(min_length=4, max_length=4)]
Pose = Annotated[list[Finite], Field(min_length=7, max_length=7)]
"""Position x, y, z then quaternion x, y, z, w."""
Matrix4 = Annotated[list[Finite], Field(min_length=16, max_length=16)]
"""Row-major 4x4."""
SensorNumber = Annotated[int, Field(ge=0, lt=MOST_SENSORS)]
RUN_BYTES = 2**20
"""Most bytes of the runs of points of a frame."""

Tool = Literal["paint", "erase", "delete", "restore"]
JobState = Literal["queued", "running", "done", "failed", "cancelled"]


class Message(BaseModel):
    """Base class: refuses unknown fields and does not convert types."""

    model_config = ConfigDict(
        extra="forbid", strict=True, frozen=True, use_attribute_docstrings=True
    )


class Sample(Message):
    """One sample of the controller or mouse: a ray, and the time since the stroke began."""

    origin: Vec3
    """Position of the device or the eye, source coordinates, metres."""
    direction: Vec3 = [0.0, 0.0, -1.0]
    """Direction of the ray, of any length."""
    t: Finite = 0.0
    """Milliseconds since the stroke began."""


class TouchedPoints(Message):
    """Points of a frame: ``runs`` holds first number and length of ascending runs, uint32 each."""

    frame: FrameIndex
    runs: Annotated[bytes, Field(max_length=RUN_BYTES)]


class Label(Message):
    """An entry of the palette."""

    id: LabelId
    name: str
    category: str
    color: Color
    locked: bool
    visible: bool


BoxId = Annotated[int, Field(ge=1, lt=2**31)]


class Lattice(Message):
    """Pixels of a depth camera, equal for all frames of a recording.

    With a depth of d units, the point of pixel (column, row) is d * ``unit`` metres from ``eye``
    along ``sign`` times axis ``axis``, and (``tangent`` + ``pitch`` * pixel) times this distance
    along the other two axes: the first with the column, the second with the row.
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


def _omitted(description: str) -> Any:
    """Return the field of a piece of a message that is left out where it does not apply."""
    return Field(None, description=description, json_schema_extra={"omitted": True})


_SENSOR = "Number of the sensor of its points; left out if the recording has one sensor."
_POINTS = "As of `frame`, for a chunk of points; left out for a band of a depth image."


class SensorInfo(Message):
    """One of several sensors of a recording.

    Its chunks and its lattice are in its own coordinates.  A point p of it is at
    ``T_frame_sensor * correction * p`` in local coordinates.
    """

    name: str
    type: SensorType
    lattice: Lattice | None
    """Pixels of its chunks in ``depth`` messages; null: they are points."""
    T_frame_sensor: list[Matrix4]
    """Mount in the frames: one for all, or one for each frame."""
    correction: Matrix4
    """Correction of the mounts; the identity: none."""


class DepthChunk(Message):
    """A run of points as a band of a depth image: docs/depth-format.md.

    In a recording of several sensors each depth camera has a depth image, and the chunks of other
    sensors are points.
    """

    index: Count
    level: Annotated[int, Field(ge=0, le=64)]
    first: Count
    count: Count
    offset: Count
    """Byte offset in the message's ``data``."""
    nbytes: Count
    origin: Vec3 | None = _omitted(_POINTS)
    scale: Vec3 | None = _omitted(_POINTS)
    sensor: Count | None = _omitted(_SENSOR)
    lo: Vec3
    """Bounds of its points, local coordinates."""
    hi: Vec3


class Chunk(Message):
    """A run of points, encoded with the meshoptimizer vertex codec, 12 bytes per point.

    Decoded layout: x, y, z uint16; r, g, b, intensity uint8; flags uint8; a zero byte.
    If bit 0 of the first vertex's flags is set, g was subtracted from all r and b (modulo 256).
    Bits 1 and 2 are the number n of low bits that r, g and b have lost:
    value = v << n | v >> (8 - 2n).  If n = 3, the bytes of r and g are a little-endian word with r
    (lowest), g and b in 5, 6 and 5 bits.
    Position = ``origin + q * scale``, in the sequence's local coordinates (source minus shift), or
    in those of its sensor if there are several.
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
    sensor: Count | None = _omitted(_SENSOR)
    lo: Vec3
    """Bounds of its points, local coordinates."""
    hi: Vec3


def _field(parameter: Parameter, shapes: list[str]) -> tuple[Any, Any]:
    """Return a parameter's type and field; a field without a default may be null."""
    kind, default = parameter.kind.type, parameter.default
    if default is None or isinstance(parameter.kind, Numbers):
        kind, default = kind | None, None
    if isinstance(parameter.kind, Rays):
        kind, default = Annotated[list[Sample], Field(max_length=parameter.kind.most)], []
    return kind, Field(default, description=f"{', '.join(shapes)}: {parameter.about}")


def _parameters() -> dict[str, Any]:
    """Return the fields of all shapes' parameters, each once."""
    fields: dict[str, Any] = {}
    for shape in SHAPES.values():
        for parameter in shape.parameters:
            users = [other.name for other in SHAPES.values() if parameter in other.parameters]
            fields[parameter.name] = _field(parameter, users)
    return fields


_Parameters: Any = create_model("_Parameters", __base__=Message, **_parameters())


def _box() -> dict[str, Any]:
    """Return the fields of a box, which are the parameters of the shape ``box``."""
    return {
        each.name: (each.kind.type, Field(*_default(each), description=each.about))
        for each in BOX.parameters
    }


def _default(parameter: Parameter) -> tuple[Any, ...]:
    return (...,) if parameter.default is None else (list(parameter.default),)


ClipBox: Any = create_model(
    "ClipBox",
    __base__=Message,
    __doc__="A box in the coordinates of the frame that a stroke is drawn in.",
    **_box(),
)


class Brush(_Parameters):  # type: ignore[misc]  # its base is made when it is imported
    """Action of a stroke on its samples."""

    label: LabelId = 0
    """Id of the label to paint; 0 for the other tools."""
    tool: Literal[TOOLS] = "paint"  # type: ignore[valid-type]
    """`paint`: give the label; `erase`: remove labels; `delete`: delete points as noise;
    `restore`: bring deleted points back."""
    shape: Literal[tuple(SHAPES)] = Field(  # type: ignore[valid-type]
        "sphere", description=" ".join(f"`{s.name}`: {s.about}" for s in SHAPES.values())
    )
    only_unlabeled: bool = False
    """Paint only points without a label."""
    hidden: Annotated[list[LabelId], Field(max_length=65535)] = Field(
        [],
        description="labels that only this viewer hides, beside the hidden labels of the "
        "palette; 0: points without a label. Strokes do not change their points, and rays pass "
        "through them.",
    )
    hidden_sensors: Annotated[list[SensorNumber], Field(max_length=MOST_SENSORS)] = Field(
        [],
        description="numbers of the sensors that this viewer hides. Strokes do not change their "
        "points, and rays pass through them.",
    )
    frames: Annotated[list[FrameIndex], Field(max_length=MAX_FRAMES)] = Field(
        [],
        description="further frames that the stroke paints, in the same edit. The poses of the "
        "recording place their points over the stroke's frame; the track places a tracked "
        "label's points.",
    )
    clip: ClipBox | None = Field(
        None,
        description="the visible box: no shape changes points outside it, and rays pass through "
        "them.",
    )
