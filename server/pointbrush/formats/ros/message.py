"""Messages serialised by ROS 1 or in CDR (ROS 2), including ``sensor_msgs/PointCloud2``."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.options import Extras, ReadOptions, require_count
from pointbrush.formats.tables.columns import frame_from_columns, unpack_rgb
from pointbrush.frame import PointFrame

TYPES = ("sensor_msgs/PointCloud2", "sensor_msgs/msg/PointCloud2")
KINDS = ("", "i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8")
MAX_FIELDS = 256
IMAGE, COMPRESSED, INFO, TRANSFORMS = "Image", "CompressedImage", "CameraInfo", "TFMessage"
"""Messages that are read in addition to point clouds."""


class Message(Protocol):
    """A serialised message."""

    @property
    def encoding(self) -> str:
        """Return ``ros1`` or ``cdr``."""

    @property
    def time(self) -> float:
        """Time at which it was recorded, in seconds."""

    @property
    def data(self) -> bytes:
        """Return its bytes."""


@dataclass(slots=True)
class MessageReader:
    """A cursor over serialised bytes; CDR aligns numbers to their size and ends texts in NUL.

    All reading raises struct.error at the end of the bytes.
    """

    data: bytes
    at: int
    order: str
    aligned: bool
    base: int

    def number(self, kind: str) -> Any:
        """Return a number of the type that ``struct`` calls ``kind``."""
        size = struct.calcsize("=" + kind)
        if self.aligned:
            self.at += -(self.at - self.base) % size
        (value,) = struct.unpack_from(self.order + kind, self.data, self.at)
        self.at += size
        return value

    def floats(self, count: int) -> NDArray[np.float64]:
        """Return float64 numbers (count,)."""
        if count > len(self.data) // 8:
            raise struct.error
        return np.array([self.number("d") for _ in range(count)])

    def text(self) -> str:
        """Return a text."""
        return self.bytes(self.number("I")).rstrip(b"\0").decode("utf-8", "replace")

    def bytes(self, length: int) -> bytes:
        """Return bytes."""
        part = self.data[self.at : self.at + length]
        if len(part) < length:
            raise struct.error
        self.at += length
        return part

    def head(self) -> tuple[float, str]:
        """Return stamp in seconds, and frame id, of a header."""
        if not self.aligned:
            self.number("I")  # ROS 1: sequence number
        seconds, nanoseconds = self.number("I"), self.number("I")
        return seconds + nanoseconds / 1e9, self.text()


def reader_of(name: str, message: Message) -> MessageReader:
    """A reader at the message's first field; raises BadInputError for other bytes."""
    data = message.data
    if message.encoding != "cdr":
        return MessageReader(data, 0, "<", False, 0)
    if len(data) < 4 or data[1] not in (0, 1):
        raise BadInputError(f"{name}: expected a CDR message, got other bytes")
    return MessageReader(data, 4, "<" if data[1] else ">", True, 4)


def kind_of(type_name: str) -> str:
    """The name of a message type of sensor_msgs or tf without its package, "" for others.

    tf/tfMessage of old bags is tf2_msgs/TFMessage by another name.
    """
    package, _, kind = type_name.rpartition("/")
    known = package.split("/")[0] in ("sensor_msgs", "tf2_msgs", "tf")
    return (TRANSFORMS if kind == "tfMessage" else kind) if known else ""


def cut_off(name: str, kind: str, message: Message) -> BadInputError:
    """The error of a message that ends too early."""
    return BadInputError(
        f"{name}: expected a {kind} message, got {len(message.data)} bytes; it is cut off"
    )


@dataclass(frozen=True, slots=True)
class PointCloud2:
    """A decoded message; ``time`` in seconds, fields as (name, offset, kind)."""

    time: float
    height: int
    width: int
    fields: list[tuple[str, int, str]]
    point_step: int
    row_step: int
    data: bytes


def head_of_message(name: str, message: Message, kind: str) -> tuple[float, str]:
    """Return stamp in seconds (or the time of recording without one), and frame id.

    Raises BadInputError for a message of this ``kind`` that is cut off.
    """
    try:
        stamp, frame_id = reader_of(name, message).head()
    except struct.error:
        raise cut_off(name, kind, message) from None
    return stamp or message.time, frame_id


def frame_of_message(name: str, message: Message, options: ReadOptions) -> PointFrame:
    """The points of a message.

    Points with NaN are missing measurements.  Raises BadInputError for a truncated message, or if
    its fields and steps do not fit its data.
    """
    try:
        cloud = _parse(name, message)
    except struct.error:
        raise cut_off(name, "PointCloud2", message) from None
    require_count(name, cloud.height * cloud.width, options.limits)
    rows = _rows(name, cloud)
    columns: dict[str, NDArray[Any]] = {field: rows[field] for field in rows.dtype.names or ()}
    for field in ("rgb", "rgba"):
        if field in columns:
            columns[field] = unpack_rgb(columns[field])
    organised = cloud.height > 1
    extras = Extras(
        timestamp=cloud.time or message.time, viewpoint=np.zeros(3) if organised else None
    )
    return frame_from_columns(name, columns, options, missing=True, extras=extras)


def _parse(name: str, message: Message) -> PointCloud2:
    reader = reader_of(name, message)
    time, _ = reader.head()
    height, width = reader.number("I"), reader.number("I")
    count = reader.number("I")
    if count > MAX_FIELDS:
        raise BadInputError(f"{name}: expected at most {MAX_FIELDS} fields, got {count}")
    fields = []
    for _ in range(count):
        field, offset = reader.text(), reader.number("I")
        kind, values = reader.number("B"), reader.number("I")
        if values == 1 and 1 <= kind < len(KINDS):
            fields.append((field, offset, KINDS[kind]))
    big = reader.number("B")
    point_step, row_step = reader.number("I"), reader.number("I")
    data = reader.bytes(reader.number("I"))
    ordered = [(field, offset, (">" if big else "<") + kind) for field, offset, kind in fields]
    return PointCloud2(time, height, width, ordered, point_step, row_step, data)


def _rows(name: str, cloud: PointCloud2) -> NDArray[Any]:
    """The points as records; rows may be padded."""
    count = cloud.height * cloud.width
    fits = all(at + np.dtype(kind).itemsize <= cloud.point_step for _, at, kind in cloud.fields)
    row = cloud.width * cloud.point_step
    # The step is ignored for one row, and for rows that fill the data: many drivers set it wrong.
    says_nothing = cloud.height == 1 or len(cloud.data) == cloud.height * row
    row_step = row if says_nothing else cloud.row_step
    if not fits or (count and (row_step < row or cloud.point_step == 0)):
        raise BadInputError(
            f"{name}: expected fields within a point of {cloud.point_step} bytes and rows of {row} "
            f"bytes or more, got rows of {row_step}"
        )
    needed = (cloud.height - 1) * row_step + row if count else 0
    if len(cloud.data) < needed:
        raise BadInputError(
            f"{name}: expected {cloud.height} rows of {cloud.width} points = {needed} bytes, got "
            f"{len(cloud.data)}"
        )
    named = {field: (at, kind) for field, at, kind in cloud.fields}
    dtype = np.dtype(
        {
            "names": list(named),
            "formats": [kind for _, kind in named.values()],
            "offsets": [at for at, _ in named.values()],
            "itemsize": max(cloud.point_step, 1),
        }
    )
    if count == 0:
        return np.empty(0, dtype)
    shape, strides = (cloud.height, cloud.width), (row_step, cloud.point_step)
    return np.ndarray(shape, dtype, cloud.data, 0, strides).reshape(-1)
