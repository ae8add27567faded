"""Numbers, texts and headers of messages, serialised by ROS 1 or in CDR (ROS 2)."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError


class Message(Protocol):
    """A serialised message."""

    @property
    def encoding(self) -> str:
        """Return ``ros1`` or ``cdr``."""

    @property
    def time(self) -> float:
        """Return when it was recorded, in seconds."""

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


def cut_off(name: str, kind: str, message: Message) -> BadInputError:
    """The error of a message that ends too early."""
    return BadInputError(
        f"{name}: expected a {kind} message, got {len(message.data)} bytes; it is cut off"
    )
