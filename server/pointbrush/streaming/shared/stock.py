"""A recording's tables and points, as they lie on the disk: views of mapped files, no copies."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

from pointbrush.sequences import Sequence
from pointbrush.sequences.residence import can_tell, in_memory, read_in
from pointbrush.streaming.encoding import encode_depth, encode_frame
from pointbrush.streaming.shared.shelf import OpenFrame, Shelf
from pointbrush.streaming.table import FrameTable, Piece

PointsMessage = tuple[bytes, memoryview]
"""A ``frame`` or ``depth`` message in two parts: its head, and a view of the map."""


class Stock:
    """Parts of an imported recording that never change.  Event loop only.

    The page cache is the cache: what is in memory is sent from there without a thread in between,
    by one viewer or a hundred.  A thread opens a frame the first time, and reads what is not in
    memory.
    """

    def __init__(
        self, recording: Sequence, shelf: Shelf, run: Callable[..., Awaitable[Any]]
    ) -> None:
        """``run(function, *args)`` awaits ``function`` in a worker thread."""
        self._recording, self._shelf, self._run = recording, shelf, run
        self._opening: dict[int, asyncio.Task[OpenFrame]] = {}
        self._can_tell: bool | None = None

    def known_table(self, frame: int, *, depth: bool = False) -> FrameTable | None:
        """The levels of a frame that is open, or of its ``depth`` image, where it has one."""
        found = self._shelf.get(self._key(frame))
        if found is None:
            return None
        return found.depth if depth else found.table

    async def table(self, frame: int, *, depth: bool = False) -> FrameTable:
        """The same of any frame; raises NotFoundError."""
        found = await self._open(frame)
        return found.depth if depth else found.table

    def known_message(self, piece: Piece) -> PointsMessage | None:
        """A piece's points, if sending them would not wait for the disk."""
        found = self._shelf.get(self._key(piece.frame))
        if found is None or found.stored.large:
            return None
        message = self._encode(found, piece)
        return message if self._at_hand(found, message[1]) else None

    async def message(self, piece: Piece) -> PointsMessage:
        """A piece's points; a thread reads them into memory if they are not there."""
        found = await self._open(piece.frame)
        if found.stored.large:
            # Read there and not mapped: what was sent must not count as this process's memory.
            read: PointsMessage = await self._run(self._encode, found, piece)
            return read
        message = self._encode(found, piece)
        if not self._at_hand(found, message[1]):
            await self._run(read_in, message[1])
            found.looked_at = True
        return message

    def _encode(self, found: OpenFrame, piece: Piece) -> PointsMessage:
        name = self._recording.manifest.id
        encode = encode_depth if piece.depth else encode_frame
        return encode(name, found.stored, piece.first, piece.stop, final=piece.final)

    def _at_hand(self, found: OpenFrame, data: memoryview) -> bool:
        return in_memory(data) if self._can_tell else found.looked_at

    async def _open(self, frame: int) -> OpenFrame:
        """An open frame; those who want it at once wait for the same thread."""
        found = self._shelf.get(self._key(frame))
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
                # Mapped and counted here: the event loop finds it done.
                encode_frame("", stored, 0, table.chunks, final=True)
            return OpenFrame(stored, table, FrameTable.of(stored, depth=True))

        opened: OpenFrame = await self._run(look)
        return self._shelf.put(self._key(frame), opened)

    def _key(self, frame: int) -> tuple[str, int]:
        return self._recording.identity, frame
