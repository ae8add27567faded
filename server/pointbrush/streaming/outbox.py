"""Queue of messages to one viewer: edits in order, never dropped; of states, the newest.

The queue is bounded: if a viewer reads its deltas too slowly, the whole values of their frames
replace them; if replies wait, the server stops reading the viewer's requests.
"""

from __future__ import annotations

import asyncio
from collections import deque
from dataclasses import dataclass, field

MOST_DELTA_BYTES = 4 * 2**20
MOST_REPLIES = 1024


class Wake:
    """An event for one waiting task, set from the event loop; one set before the wait is kept.

    Unlike ``asyncio.wait_for``, a wait with a timeout creates no task.
    """

    def __init__(self) -> None:
        self._rung = self._points = False
        self._waiter: asyncio.Future[None] | None = None

    def set(self, *, points: bool = True) -> None:
        """Wake the task; ``points``: there may be points to send, not only messages."""
        self._rung = True
        self._points = self._points or points
        if self._waiter is not None and not self._waiter.done():
            self._waiter.set_result(None)

    def clear(self) -> bool:
        """Clear the event; return whether it was set for points."""
        points = self._points
        self._rung = self._points = False
        return points

    async def wait(self, seconds: float | None) -> None:
        """Wait until the event is set, for at most ``seconds`` if given."""
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
    """Frames of which all values must be sent."""
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
        """Return whether no message waits except points."""
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
        """Return whether the viewer must read answers before the server reads its messages."""
        return len(self.replies) >= MOST_REPLIES

    def delta(self, delta: QueuedDelta) -> None:
        """Queue a delta; it is sent together with others when the room wakes the viewer."""
        self.deltas.append(delta)
        self.delta_bytes += len(delta.data)
        if self.delta_bytes > MOST_DELTA_BYTES:
            self.collapse()

    def collapse(self) -> None:
        """Replace all deltas by the whole values of their frames."""
        for delta in self.deltas:
            self.stale[delta.frame] = None
        self.clear_deltas()
        self.wake.set()

    def clear_deltas(self) -> None:
        """Remove all queued deltas."""
        self.deltas.clear()
        self.delta_bytes = 0

    def next_delta(self, up_to: int | None = None) -> QueuedDelta | None:
        """Remove and return the oldest delta if its revision is at most ``up_to``."""
        if not self.deltas or (up_to is not None and self.deltas[0].revision > up_to):
            return None
        delta = self.deltas.popleft()
        self.delta_bytes -= len(delta.data)
        return delta

    def drop(self, frame: int, up_to: int) -> None:
        """Remove a frame's deltas up to a revision: the whole values being sent include them."""
        if not self.deltas:
            return
        kept = [d for d in self.deltas if d.frame != frame or d.revision > up_to or d.provisional]
        self.deltas = deque(kept)
        self.delta_bytes = sum(len(delta.data) for delta in kept)

    def restart(self) -> None:
        """Remove all messages of a sequence after another one was opened."""
        self.clear_deltas()
        self.stale.clear()
        self.presence.clear()
        self.cells.clear()
        self.boxes.clear()
        self.labels = self.all_cells = self.all_boxes = False

    def mark_all(self) -> None:
        """Note that palette, timeline and boxes must be sent whole."""
        self.labels = self.all_cells = self.all_boxes = True
