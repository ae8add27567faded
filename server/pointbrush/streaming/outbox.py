"""Queue of messages to one viewer: edits in order, never dropped; states, newest wins.

Bounded: when a viewer reads too slowly for its deltas, they are given up for the whole values of
the frames they are about, which say the same; replies are bounded by not reading further requests.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

from pointbrush.streaming.wake import Wake

MOST_DELTA_BYTES = 4 * 2**20
MOST_REPLIES = 1024


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
        self.labels = self.all_cells = False
