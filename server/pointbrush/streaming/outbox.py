"""Queue of messages to one viewer: edits in order, never dropped; states, newest wins.

Bounded: when a viewer reads too slowly for its deltas, they are given up for the whole values of
the frames they are about, which say the same; replies are bounded by not reading further requests.
"""

from __future__ import annotations

import asyncio
from collections import deque
from dataclasses import dataclass, field

MOST_DELTA_BYTES = 4 * 2**20
MOST_REPLIES = 1024


class Wake:
    """A bell that one task waits for, rung from the event loop; remembers one ring meanwhile.

    ``asyncio.wait_for`` makes a task each time, this does not.
    """

    def __init__(self) -> None:
        self._rung = self._points = False
        self._waiter: asyncio.Future[None] | None = None

    def set(self, *, points: bool = True) -> None:
        """Ring; ``points``: there may be points to send, and not messages alone."""
        self._rung = True
        self._points = self._points or points
        if self._waiter is not None and not self._waiter.done():
            self._waiter.set_result(None)

    def clear(self) -> bool:
        """Forget earlier rings; returns whether one was for points."""
        points = self._points
        self._rung = self._points = False
        return points

    async def wait(self, seconds: float | None) -> None:
        """Wait for the next ring, or for ``seconds`` if given."""
        if self._rung:
            return
        loop = asyncio.get_running_loop()
        self._waiter = waiter = loop.create_future()
        timer = None if seconds is None else loop.call_later(seconds, self.set)
        try:
            await waiter
        finally:
            self._waiter = None
            if timer is not None:
                timer.cancel()


@dataclass(frozen=True, slots=True)
class QueuedDelta:
    """An encoded annotation delta."""

    frame: int
    revision: int
    data: bytes
    provisional: bool = False


@dataclass
class Outbox:
    """One viewer's queues; used on the event loop only."""

    replies: deque[bytes] = field(default_factory=deque)
    deltas: deque[QueuedDelta] = field(default_factory=deque)
    stale: dict[int, None] = field(default_factory=dict)
    """Frames whose values must be sent whole."""
    jobs: dict[str, bytes] = field(default_factory=dict)
    presence: dict[str, bytes] = field(default_factory=dict)
    labels: bool = False
    """The palette or its counts changed."""
    cells: set[tuple[int, int]] = field(default_factory=set)
    """Timeline cells (frame, label) that changed."""
    all_cells: bool = False
    boxes: set[int] = field(default_factory=set)
    """Boxes that changed."""
    all_boxes: bool = False
    wake: Wake = field(default_factory=Wake)
    delta_bytes: int = 0

    def reply(self, data: bytes) -> None:
        """Queue an answer."""
        self.replies.append(data)
        self.wake.set()

    @property
    def quiet(self) -> bool:
        """Whether nothing waits but points."""
        return not (
            self.replies
            or self.deltas
            or self.stale
            or self.jobs
            or self.presence
            or self.labels
            or self.cells
            or self.all_cells
            or self.boxes
            or self.all_boxes
        )

    @property
    def crowded(self) -> bool:
        """Whether the viewer must read answers before it is heard again."""
        return len(self.replies) >= MOST_REPLIES

    def delta(self, delta: QueuedDelta) -> None:
        """Queue a delta; it goes out when the room wakes the viewer, with others."""
        self.deltas.append(delta)
        self.delta_bytes += len(delta.data)
        if self.delta_bytes > MOST_DELTA_BYTES:
            self.collapse()

    def collapse(self) -> None:
        """Give up all deltas for whole values."""
        for delta in self.deltas:
            self.stale[delta.frame] = None
        self.clear_deltas()
        self.wake.set()

    def clear_deltas(self) -> None:
        """Forget queued deltas."""
        self.deltas.clear()
        self.delta_bytes = 0

    def next_delta(self, up_to: int | None = None) -> QueuedDelta | None:
        """Take the oldest delta, if it is of revision ``up_to`` at most."""
        if not self.deltas or (up_to is not None and self.deltas[0].revision > up_to):
            return None
        delta = self.deltas.popleft()
        self.delta_bytes -= len(delta.data)
        return delta

    def drop(self, frame: int, up_to: int) -> None:
        """Forget deltas of a frame up to a revision: whole values that say the same go out."""
        if not self.deltas:
            return
        kept = [d for d in self.deltas if d.frame != frame or d.revision > up_to or d.provisional]
        self.deltas = deque(kept)
        self.delta_bytes = sum(len(delta.data) for delta in kept)

    def restart(self) -> None:
        """Drop everything about a sequence: another one was opened."""
        self.clear_deltas()
        self.stale.clear()
        self.presence.clear()
        self.cells.clear()
        self.boxes.clear()
        self.labels = self.all_cells = self.all_boxes = False

    def everything(self) -> None:
        """Note that palette, timeline and boxes must be sent whole."""
        self.labels = self.all_cells = self.all_boxes = True
