"""Rates: token buckets by client."""

from __future__ import annotations

import time

from pointbrush.errors import TooManyRequestsError

BURST_SECONDS = 10
"""A client may spend this many seconds' worth of requests at once, unless told otherwise."""
KNOWN_CLIENTS = 10_000


class RateLimit:
    """Token buckets by client; raises TooManyRequestsError when one is empty."""

    def __init__(self, per_second: float, burst: float | None = None) -> None:
        """``burst``: what a client may spend at once."""
        self._rate = per_second
        self._burst = per_second * BURST_SECONDS if burst is None else burst
        self._buckets: dict[str, tuple[float, float]] = {}

    def spend(self, client: str, now: float | None = None) -> None:
        """Take one token of ``client``."""
        now = time.monotonic() if now is None else now
        left, since = self._buckets.pop(client, (self._burst, now))
        left = min(self._burst, left + (now - since) * self._rate)
        # Popped and put back: the dict stays in order of use, so the first is the stalest.
        self._buckets[client] = (max(left - 1.0, 0.0), now)
        if len(self._buckets) > KNOWN_CLIENTS:
            del self._buckets[next(iter(self._buckets))]
        if left < 1.0:
            raise TooManyRequestsError(f"expected at most {self._rate:g} requests a second")
