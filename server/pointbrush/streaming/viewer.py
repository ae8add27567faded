"""State of one viewer: identity, view, its points, and the messages that wait for it."""

from __future__ import annotations

import time
import uuid
from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable, Iterable, Sequence
from typing import Protocol

from pointbrush.database.job import Job
from pointbrush.errors import BadInputError, PointbrushError
from pointbrush.streaming import messages
from pointbrush.streaming.encoding import encode
from pointbrush.streaming.load import Load
from pointbrush.streaming.outbox import Outbox
from pointbrush.streaming.plan import Plan
from pointbrush.streaming.rate import Link
from pointbrush.streaming.room import Room
from pointbrush.streaming.shared.presence import color_of
from pointbrush.streaming.shared.status import status_of

CREDITS = 8
"""Frame messages that may be in flight to a viewer; the link bounds their bytes as well."""


class Send(Protocol):
    """Sends a message; waits while the viewer reads too slowly."""

    async def __call__(self, *parts: bytes | memoryview, before: bytes | None = None) -> None:
        """Send one message of the bytes ``parts``; ``before``: a message to send ahead of it."""


SendEach = Callable[[Sequence[bytes]], Awaitable[None]]
"""Sends several messages in order, in one write."""


class Viewer(ABC):
    """One viewer's state; everything runs on the event loop."""

    def __init__(
        self,
        send: Send,
        *,
        author: str,
        role: messages.Role,
        load: Load,
        send_each: SendEach | None = None,
        public: Callable[[str], str],
    ) -> None:
        """``load``: the server's load; ``public`` returns the part of a text for clients."""
        self.public = public
        self.send, self.send_each = send, send_each or self._one_by_one
        self.id = uuid.uuid4().hex[:16]
        self.author, self.role = author, role
        self.name, self.color = author, color_of(self.id)
        self.room: Room | None = None
        self.outbox = Outbox()
        self.plan = Plan(frames=1, link=Link(CREDITS), load=load)
        self.depth = False
        """The viewer's page reads depth images."""
        self.resumed = False
        """The viewer resumed without a list of its frames."""
        self.catching_up = False

    @property
    @abstractmethod
    def waiting_edits(self) -> int:
        """Number of received edits without an answer."""

    async def _one_by_one(self, data: Sequence[bytes]) -> None:
        for one in data:
            await self.send(one)

    @abstractmethod
    async def reopen(self) -> None:
        """Open the sequence again after its manifest or import changed, or after its deletion."""

    @abstractmethod
    async def drain(self) -> None:
        """Read no more messages and answer the received ones, before the server stops."""

    @abstractmethod
    def require_admitted(self) -> None:
        """Raise UnauthorizedError once the token is not valid; may read the database."""

    @abstractmethod
    def may_see(self, job: Job) -> bool:
        """Return whether the viewer may see a job; may read the database."""

    @abstractmethod
    def expel(self) -> None:
        """End the session, because its token is no longer valid."""

    @abstractmethod
    def close(self) -> None:
        """End the session: the server stops."""

    def now(self) -> float:
        """Return the seconds of a monotonic clock."""
        return time.monotonic()

    def refuse(
        self, error: PointbrushError, about: str | None = None, closed: str | None = None
    ) -> None:
        """Answer with an error; ``closed``: the sequence that is no longer open."""
        message = messages.Error(
            title=error.title,
            detail=self.public(str(error)),
            status=status_of(error),
            about=about,
            closed=closed,
        )
        self.outbox.reply(encode(message))

    def require_room(self) -> Room:
        """Return the room of the open sequence; raise BadInputError if none is open."""
        if self.room is None:
            raise BadInputError("expected 'open' before this message")
        return self.room

    # ── changes by other viewers ─────────────────────────────────────────────────────────

    def holds(self, frame: int) -> bool:
        """Return whether the viewer needs the changes of a frame."""
        if self.catching_up or frame in self.outbox.stale:
            return False
        return self.has(frame)

    def has(self, frame: int) -> bool:
        """Return whether the viewer may have points of a frame."""
        return self.resumed or frame in self.plan.held

    def mark_stale(self, frames: Iterable[int]) -> None:
        """Queue all values of these frames."""
        owed = [frame for frame in frames if self.has(frame)]
        if owed:
            self.outbox.stale.update(dict.fromkeys(owed))
            self.outbox.wake.set()

    def mark_all_stale(self) -> None:
        """Queue all values of the frames that the viewer has."""
        self.outbox.clear_deltas()
        self.mark_stale(range(self.plan.frames) if self.resumed else list(self.plan.held))

    def mark_cells_changed(self, cells: set[tuple[int, int]], *, everything: bool) -> None:
        """Queue changes of palette, counts or timeline until the room wakes the viewer."""
        self.outbox.labels = True
        self.outbox.cells |= cells
        self.outbox.all_cells |= everything

    def mark_boxes_changed(self, boxes: Iterable[int] | None) -> None:
        """Queue the boxes of these ids, or all boxes: None; they are sent with the palette."""
        self.outbox.boxes.update(boxes or ())
        self.outbox.all_boxes |= boxes is None
