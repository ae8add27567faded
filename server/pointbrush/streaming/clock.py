"""The server's clock of one viewer's playback."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

MOST_PER_SECOND = 60.0
"""Faster playback shows every second, third … frame: no display shows more."""


@dataclass(frozen=True, slots=True)
class PlayClock:
    """Frames due over time: ``start`` at time ``since``, ``rate`` frames a second (signed)."""

    start: int
    since: float
    rate: float
    frames: int
    loop: bool = True
    stride: int = field(init=False)
    """Frames between two that are shown, signed like the direction."""
    shown_per_second: float = field(init=False)
    """Different frames shown a second."""

    def __post_init__(self) -> None:
        step = max(1, math.ceil(abs(self.rate) / MOST_PER_SECOND - 1e-9))
        object.__setattr__(self, "stride", step if self.rate >= 0 else -step)
        object.__setattr__(self, "shown_per_second", abs(self.rate) / step)

    def steps(self, now: float) -> int:
        """Shown frames passed since the start."""
        return max(0, math.floor((now - self.since) * self.shown_per_second + 1e-9))

    def frame(self, step: int) -> int:
        """The frame of a step, wrapped when looping, else held at the end."""
        index = self.start + step * self.stride
        return index % self.frames if self.loop else min(max(index, 0), self.frames - 1)

    def due(self, now: float) -> int:
        """The frame that should be seen now."""
        return self.frame(self.steps(now))

    def next_change(self, now: float) -> float:
        """Seconds until another frame is due; infinity when none will be."""
        if self.rate == 0 or (not self.loop and self.ended(now)):
            return math.inf
        return max(0.0, self.since + (self.steps(now) + 1) / self.shown_per_second - now)

    def ended(self, now: float) -> bool:
        """Not looping, and at the last frame of the direction."""
        last = self.frames - 1 if self.rate >= 0 else 0
        return not self.loop and self.due(now) == last

    def ahead(self, now: float, seconds: float, first: int = 0) -> Iterator[tuple[int, int]]:
        """Step and frame due now, and of those due within ``seconds``, in order of time.

        Steps before ``first`` are left out.
        """
        last = self.steps(now + seconds) if self.rate else 0
        for step in range(max(first, min(self.steps(now), last)), last + 1):
            yield step, self.frame(step)

    def time_of(self, step: int) -> float:
        """Moment at which a step is due."""
        return self.since + step / self.shown_per_second if self.rate else self.since
