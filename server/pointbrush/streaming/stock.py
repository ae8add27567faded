"""A recording's tables and point messages, made once for all who want them."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Awaitable, Callable
from typing import Any

from pointbrush.sequences import Sequence
from pointbrush.streaming.cache import MessageCache, Versioned
from pointbrush.streaming.encoding import encode_frame
from pointbrush.streaming.table import FrameTable, Piece

TABLES = 4096


class Stock:
    """What never changes of an imported recording.  Event loop only."""

    def __init__(
        self,
        recording: Sequence,
        cache: MessageCache,
        run: Callable[..., Awaitable[Any]],
    ) -> None:
        """``run(function, *args)`` awaits ``function`` in a worker thread."""
        self._recording, self._cache, self._run = recording, cache, run
        self._tables: OrderedDict[int, FrameTable] = OrderedDict()

    def known_table(self, frame: int) -> FrameTable | None:
        """The levels of a frame that somebody has looked at lately."""
        return self._tables.get(frame)

    async def table(self, frame: int) -> FrameTable:
        """The levels of a frame; raises NotFoundError."""
        table = self._tables.get(frame)
        if table is None:
            table = await self._run(lambda: FrameTable.of(self._recording[frame]))
            self._tables[frame] = table
            if len(self._tables) > TABLES:
                self._tables.popitem(last=False)
        return table

    def known_message(self, piece: Piece) -> bytes | None:
        """A piece's points, encoded, if they are here."""
        found = self._cache.known(self._key(piece))
        return None if found is None else found[1]

    async def message(self, piece: Piece) -> bytes:
        """A piece's points, encoded."""

        def read() -> Versioned:
            frame = self._recording[piece.frame]
            name = self._recording.manifest.id
            return 0, encode_frame(name, frame, piece.first, piece.stop, final=piece.final)

        return (await self._cache.get(self._key(piece), lambda: self._run(read)))[1]

    def _key(self, piece: Piece) -> tuple[object, ...]:
        identity = self._recording.identity
        return "frame", identity, piece.frame, piece.first, piece.stop, piece.final
