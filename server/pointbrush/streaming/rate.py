"""Rate of a viewer's link, from its credits, and the points that a frame may have.

The rate is estimated as in BBR (Cardwell et al. 2016): bytes delivered between a message's
sending and its credit, divided by that time.  A message sent into an idle link measures mostly the
round trip; such samples, with the round trip subtracted, may only raise the estimate.  A message
that took far longer than expected lowers it at once.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

MEMORY = 1.0
"""Seconds for which samples of a full link are used."""
SHARE = 0.85
"""Share of the estimated rate that frames may take."""
QUEUE_SECONDS = 0.1
"""Bytes in flight beyond the round trip, as time on the link: the longest wait behind them."""
FIRST_WINDOW = 256 * 1024
LARGEST_WINDOW = 16 * 2**20
SLOW_FACTOR, SLOW_SECONDS = 2.0, 0.03
RAISE = 0.3
SHORTEST = 1e-4
FLOOR_MEMORY = 10.0


@dataclass(slots=True)
class _Sent:
    nbytes: int
    time: float
    delivered: int
    delivered_time: float
    ahead: int
    idle: bool


@dataclass(slots=True)
class Floor:
    """Minimum of the recent values."""

    value: float = 0.0
    _since: float = float("-inf")

    def note(self, value: float, now: float) -> None:
        """Add a value."""
        if value <= self.value or now - self._since > FLOOR_MEMORY:
            self.value, self._since = value, now


@dataclass(slots=True)
class Link:
    """In-flight frame messages of one viewer, and their rate."""

    credits: int
    rate: float = 0.0
    """Estimated bytes a second; 0 before the first credit."""
    _flight: deque[_Sent] = field(default_factory=deque)
    _bytes: int = 0
    _delivered: int = 0
    _delivered_time: float = 0.0
    _samples: deque[tuple[float, float]] = field(default_factory=deque)
    _trip: Floor = field(default_factory=Floor)
    _own: Floor = field(default_factory=Floor)

    @property
    def round_trip(self) -> float:
        """Return an upper bound of the seconds from a message to its credit on an idle link."""
        return self._trip.value

    @property
    def window(self) -> int:
        """Return the bytes in flight below which another message may be sent."""
        if not self.rate:
            return FIRST_WINDOW
        return min(LARGEST_WINDOW, int(self.rate * (self.round_trip + QUEUE_SECONDS)))

    @property
    def has_room(self) -> bool:
        """Return whether another message may be sent now."""
        return len(self._flight) < self.credits and self._bytes <= self.window

    def sent(self, nbytes: int, now: float, *, idle: bool = False) -> None:
        """Record a frame message; ``idle``: the link was idle before it."""
        if not self._flight:
            self._delivered_time = now
        self._flight.append(
            _Sent(nbytes, now, self._delivered, self._delivered_time, self._bytes, idle)
        )
        self._bytes += nbytes

    def credited(self, frames: int, now: float) -> None:
        """Record that the viewer applied the oldest ``frames`` messages; ignore an excess."""
        last: _Sent | None = None
        for _ in range(min(frames, len(self._flight))):
            last = self._flight.popleft()
            self._bytes -= last.nbytes
            self._delivered += last.nbytes
        if last is not None:
            self._learn(last, now)
            self._delivered_time = now

    def _learn(self, sent: _Sent, now: float) -> None:
        latency = max(now - sent.time, SHORTEST)
        elapsed = max(now - sent.delivered_time, SHORTEST)
        sample = (self._delivered - sent.delivered) / elapsed
        if not self.rate:
            self.rate = sample
            self._samples.append((now, sample))
            self._trip.note(latency, now)
            return
        carried = (sent.ahead + sent.nbytes) / self.rate
        self._trip.note(latency, now)
        self._own.note(max(0.0, latency - carried), now)
        if latency > SLOW_FACTOR * (self.round_trip + carried) + SLOW_SECONDS:
            self._samples.clear()
            self._samples.append((now, sample))
            self.rate = sample
        elif sent.idle:
            way = max(latency - self._own.value, SHORTEST)
            sample = max(sample, min((sent.ahead + sent.nbytes) / way, 2 * self.rate))
            self.rate += RAISE * max(sample - self.rate, 0.0)
        else:
            # The samples are kept in descending order: the first one is the maximum.
            while self._samples and self._samples[-1][1] <= sample:
                self._samples.pop()
            self._samples.append((now, sample))
            while self._samples[0][0] < now - MEMORY:
                self._samples.popleft()
            self.rate = self._samples[0][1]


EASE_GROW, EASE_LEAST = 1.15, 0.01
EASE_PERIOD = 0.3
COMFORTABLE = 0.5
"""Filled share of the look-ahead above which the viewer may get more points."""


@dataclass(slots=True)
class Pace:
    """Feedback over any bottleneck: less after skipped frames, more while ahead of the clock.

    The link's estimate does not include a busy client, a busy server or other viewers; the
    lateness of frames does.
    """

    ease: float = 1.0
    """Share of the link's estimate to use."""
    _changed: float = float("-inf")

    def left(self, skipped: int, lead: float, now: float) -> None:
        """Record a frame sent ``lead`` (0..1 of the look-ahead) early after ``skipped`` others."""
        if now - self._changed < EASE_PERIOD:
            return
        if skipped > 0:
            self.ease = max(EASE_LEAST, self.ease / (1 + min(skipped, 3)))
        elif lead > COMFORTABLE and self.ease < 1.0:
            self.ease = min(1.0, self.ease * EASE_GROW)
        else:
            return
        self._changed = now


PAGE_SLOW, PAGE_FAST = 1.15, 0.9
PAGE_CUT, PAGE_GROW = 0.8, 1.1
PAGE_PERIOD = 0.25
FEWEST_POINTS = 2_000
UNLIMITED = 1 << 40


@dataclass(slots=True)
class PageBudget:
    """Number of points that the page can draw, from its own measured frame time."""

    points: int = UNLIMITED
    requested_points: int = UNLIMITED
    _changed: float = 0.0

    def report(
        self, frame_ms: float, target_ms: float, points: int | None, shown: int, now: float
    ) -> None:
        """Record the times of a credit; ``shown`` points were drawn in that time."""
        self.requested_points = UNLIMITED if points is None else max(points, 1)
        if not frame_ms or not target_ms or now - self._changed < PAGE_PERIOD:
            return
        if frame_ms > PAGE_SLOW * target_ms:
            self.points = max(FEWEST_POINTS, int(PAGE_CUT * min(self.points, max(shown, 1))))
            self._changed = now
        elif frame_ms < PAGE_FAST * target_ms and self.points < UNLIMITED:
            # A limit above the size of every frame is removed.
            grown = int(PAGE_GROW * self.points)
            self.points = UNLIMITED if grown > 4 * max(shown, FEWEST_POINTS) else grown
            self._changed = now

    @property
    def limit(self) -> int:
        """Return the largest number of points of a frame during playback."""
        return min(self.points, self.requested_points)
