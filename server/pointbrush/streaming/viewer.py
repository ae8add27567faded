"""State of one viewer: identity, view, the points that it has, and those that wait for it."""

from __future__ import annotations

import time
import uuid
from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable, Iterable, Sequence
from typing import Protocol

from pointbrush.errors import BadInputError, PointbrushError
from pointbrush.job import Job
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
"""Frame messages that may be on their way to a viewer; their bytes are bounded besides."""


class Send(Protocol):
    """Send a message; waits while the viewer reads more slowly than it is sent to."""

    async def __call__(self, *parts: bytes | memoryview, before: bytes | None = None) -> None:
        """Send one message whose bytes are ``parts``; ``before``: and one ahead of it."""


SendEach = Callable[[Sequence[bytes]], Awaitable[None]]
"""Sends several messages, in order and in one piece."""


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
        """``load``: what the server has time for; ``public``: what clients may read of a text."""
        self.public = public
        self.send, self.send_each = send, send_each or self._one_by_one
        self.id = uuid.uuid4().hex[:16]
        self.author, self.role = author, role
        self.name, self.color = author, color_of(self.id)
        self.room: Room | None = None
        self.outbox = Outbox()
        self.plan = Plan(frames=1, link=Link(CREDITS), load=load)
        self.wanted: tuple[int, list[int]] | None = None
        """A frame of a large sequence and the chunks it asks for, most wanted first."""
        self.depth = False
        """The viewer's page reads depth images."""
        self.resumed = False
        """Whether it came back without saying which frames it has."""
        self.catching_up = False

    @property
    @abstractmethod
    def waiting_edits(self) -> int:
        """Edits that have come and are not answered yet."""

    async def _one_by_one(self, data: Sequence[bytes]) -> None:
        for one in data:
            await self.send(one)

    @abstractmethod
    async def reopen(self) -> None:
        """The sequence's manifest changed, or the sequence has gone, or is another by now."""

    @abstractmethod
    async def drain(self) -> None:
        """Hear nothing more and answer what was heard: the server is about to stop."""

    @abstractmethod
    def require_admitted(self) -> None:
        """Raise UnauthorizedError once its token lets nobody in any more; may read the database."""

    @abstractmethod
    def may_see(self, job: Job) -> bool:
        """Return whether a job is for who looks; may read the database."""

    @abstractmethod
    def expel(self) -> None:
        """End the session: its token lets nobody in any more."""

    @abstractmethod
    def close(self) -> None:
        """End the session: the server stops."""

    def now(self) -> float:
        """Seconds on a clock that only runs forward."""
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
        """The open sequence's room; raises BadInputError when none is open."""
        if self.room is None:
            raise BadInputError("expected 'open' before this message")
        return self.room

    # ── what others change ───────────────────────────────────────────────────────────────

    def holds(self, frame: int) -> bool:
        """Whether the viewer must hear of changes in a frame."""
        if self.catching_up or frame in self.outbox.stale:
            return False
        return self.has(frame)

    def has(self, frame: int) -> bool:
        """Whether the viewer may have points of a frame."""
        return self.resumed or frame in self.plan.held

    def stale(self, frames: Iterable[int]) -> None:
        """Values of these frames must be sent whole."""
        owed = [frame for frame in frames if self.has(frame)]
        if owed:
            self.outbox.stale.update(dict.fromkeys(owed))
            self.outbox.wake.set()

    def all_stale(self) -> None:
        """Values of everything that the viewer holds must be sent whole."""
        self.outbox.clear_deltas()
        self.stale(range(self.plan.frames) if self.resumed else list(self.plan.held))

    def cells_changed(self, cells: set[tuple[int, int]], *, everything: bool) -> None:
        """Palette, counts or timeline changed; it goes out when the room wakes the viewer."""
        self.outbox.labels = True
        self.outbox.cells |= cells
        self.outbox.all_cells |= everything

    def boxes_changed(self, boxes: Iterable[int] | None) -> None:
        """Boxes of these ids changed, or any, None; they go out with the palette."""
        self.outbox.boxes.update(boxes or ())
        self.outbox.all_boxes |= boxes is None
