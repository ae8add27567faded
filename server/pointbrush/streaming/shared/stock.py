"""A recording's tables, and its pieces as sent: values, and points from mapped files.

``Shelf`` keeps the recently used frames of all rooms of a server open.
"""

from __future__ import annotations

import asyncio
import contextlib
import sys
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import Any

from pointbrush.cache import Cache
from pointbrush.errors import PointbrushError
from pointbrush.sequences import Sequence, StoredFrame
from pointbrush.sequences.storage.residence import can_tell, in_memory, read_in
from pointbrush.streaming.encoding import encode_depth, encode_frame
from pointbrush.streaming.shared.values import Values
from pointbrush.streaming.table import FrameTable, Piece

MOST_FRAMES = 4096
LEAST_FRAMES = 16
"""Most and least mapped frames that are kept open."""
FILES_SHARE = 8
"""Divisor of the process's limit of open files that gives the limit of mapped frames."""

Key = tuple[str, str]
"""A recording's id, as in messages, and its ``placement``."""
PointsMessage = tuple[bytes, memoryview]
"""A ``frame`` or ``depth`` message in two parts: its head, and a view of the map."""
Ready = tuple[int, bytes, PointsMessage]
"""The revision of a piece's values, their message, and the message of its points."""


IN_MEMORY_SECONDS = 0.25
"""Time for which the answer of the system that bytes are in memory is used.

Under memory pressure, the system evicts the least recently used bytes.
"""


@dataclass(slots=True)
class Head:
    """Head of a message of points; ``in_memory``: last time its points were found in memory."""

    data: bytes
    in_memory: float = float("-inf")


@dataclass(slots=True)
class OpenFrame:
    """A frame and its levels; ``looked_at``: its bytes have been read since it was opened.

    ``depth``: the levels of its depth image, or of its points if it has none.
    ``heads``: heads of its messages by first chunk, stop, and whether of the depth image.
    """

    stored: StoredFrame
    table: FrameTable
    depth: FrameTable
    looked_at: bool = False
    heads: dict[tuple[int, int, bool], Head] = field(default_factory=dict)

    def points_of(self, piece: Piece) -> tuple[int, int]:
        """Return the first point of a piece, and its number of points."""
        first = self.table.firsts[piece.first]
        return first, self.table.firsts[piece.stop] - first


class Shelf(Cache[tuple[Key, int], OpenFrame]):
    """The most recently used frames, within the limit of open files.

    A frame takes a few kilobytes and a mapped file; its bytes are in the page cache.
    """

    def __init__(self, limit: int | None = None) -> None:
        """``limit``: number of kept frames; by default from the process's limit of open files."""
        super().__init__(most_frames() if limit is None else limit)

    def forget(self, recording: Key) -> None:
        """Close a recording's frames when its last viewer has left."""
        self.drop(*(key for key in self.held() if key[0] == recording))


def most_frames() -> int:
    """Return the number of frames that this process may keep open."""
    if sys.platform == "win32":
        return MOST_FRAMES
    import resource

    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    files = MOST_FRAMES * FILES_SHARE if soft == resource.RLIM_INFINITY else soft
    return max(LEAST_FRAMES, min(MOST_FRAMES, files // FILES_SHARE))


class Stock:
    """The messages of an imported recording's frames, and their tables.  Event loop only.

    The system's page cache is the cache: bytes in memory are sent from there without a thread.  A
    thread opens each frame once, and reads bytes that are not in memory.
    """

    def __init__(
        self,
        recording: Sequence,
        values: Values,
        shelf: Shelf,
        run: Callable[..., Awaitable[Any]],
    ) -> None:
        """``run(function, *args)`` awaits ``function`` in a worker thread."""
        self.key: Key = recording.manifest.id, recording.placement
        self._recording, self._values = recording, values
        self._shelf, self._run = shelf, run
        self._opening: dict[int, asyncio.Task[OpenFrame]] = {}
        self._expected: dict[tuple[int, int, bool], asyncio.Task[None]] = {}
        self._can_tell: bool | None = None

    def known_table(self, frame: int, *, depth: bool = False) -> FrameTable | None:
        """Return the levels of an open frame, or of its ``depth`` image if it has one."""
        found = self._shelf.known((self.key, frame))
        if found is None:
            return None
        return found.depth if depth else found.table

    async def table(self, frame: int, *, depth: bool = False) -> FrameTable:
        """Return the levels of any frame, opening it if needed; raise NotFoundError."""
        found = await self._open(frame)
        return found.depth if depth else found.table

    def ready(self, piece: Piece) -> Ready | None:
        """Return the result of ``messages`` if it needs no read."""
        found = self._shelf.known((self.key, piece.frame))
        if found is None or found.stored.large:
            return None
        values = self._values.known(piece.frame, *found.points_of(piece))
        if values is None:
            return None
        head, points = self._head(found, piece)
        now = time.monotonic()
        if now - head.in_memory > IN_MEMORY_SECONDS:
            if not self._at_hand(found, points):
                return None
            head.in_memory = now
        return *values, (head.data, points)

    async def messages(self, piece: Piece) -> Ready:
        """Return the messages of a piece's values and points; threads read them where needed."""
        found = await self._open(piece.frame)
        values, points = await asyncio.gather(
            self._values.message(piece.frame, *found.points_of(piece)), self._points(found, piece)
        )
        return *values, points

    async def _points(self, found: OpenFrame, piece: Piece) -> PointsMessage:
        if found.stored.large:
            # Read in the thread instead of mapped: sent bytes must not count as process memory.
            read: PointsMessage = await self._run(self._encode, found, piece)
            return read
        head, points = self._head(found, piece)
        if not self._at_hand(found, points):
            await self._run(read_in, points)
            found.looked_at = True
        return head.data, points

    def expect(self, frame: int, level: int, *, depth: bool = False) -> None:
        """Prepare the messages of a frame up to a level before a viewer needs them.

        Otherwise the viewers that play a recording for the first time would wait at each frame.
        """
        table = self.known_table(frame, depth=depth)
        if table is not None and self.ready(table.first_piece(frame, level)) is not None:
            return
        key = frame, level, depth
        if key not in self._expected:
            task = self._expected[key] = asyncio.create_task(self._make(*key))
            task.add_done_callback(lambda _: self._expected.pop(key))

    async def _make(self, frame: int, level: int, depth: bool) -> None:
        # The viewer that needs the frame gets the error.
        with contextlib.suppress(PointbrushError):
            table = await self.table(frame, depth=depth)
            await self.messages(table.first_piece(frame, level))

    def _head(self, found: OpenFrame, piece: Piece) -> tuple[Head, memoryview]:
        """Return the cached head of a piece, and its points; for frames that are not large."""
        key = piece.first, piece.stop, piece.depth
        head = found.heads.get(key)
        if head is None:
            data, points = self._encode(found, piece)
            head = found.heads[key] = Head(data)
            return head, points
        # A new view checks that the file has not been truncated.
        view = found.stored.depth if piece.depth else found.stored.wire
        return head, view(piece.first, piece.stop)

    def _encode(self, found: OpenFrame, piece: Piece) -> PointsMessage:
        encode = encode_depth if piece.depth else encode_frame
        return encode(self.key[0], found.stored, piece.first, piece.stop, final=piece.final)

    def _at_hand(self, found: OpenFrame, data: memoryview) -> bool:
        return in_memory(data) if self._can_tell else found.looked_at

    async def _open(self, frame: int) -> OpenFrame:
        """Return an open frame; concurrent calls wait for the same thread."""
        found = self._shelf.known((self.key, frame))
        if found is not None:
            return found
        task = self._opening.get(frame)
        if task is None:
            task = self._opening[frame] = asyncio.create_task(self._opened(frame))
            task.add_done_callback(lambda _: self._opening.pop(frame))
        return await asyncio.shield(task)

    async def _opened(self, frame: int) -> OpenFrame:
        def look() -> OpenFrame:
            if self._can_tell is None:
                self._can_tell = can_tell(self._recording.path)
            stored = self._recording[frame]
            table = FrameTable.of(stored)
            if not stored.large:
                # Map the file and encode the table in this thread instead of on the event loop.
                encode_frame("", stored, 0, table.chunks, final=True)
            return OpenFrame(stored, table, FrameTable.of(stored, depth=True))

        opened: OpenFrame = await self._run(look)
        return self._shelf.get((self.key, frame), lambda: opened)
