"""Limits of sign-ins that wait for the provider, in separate threads, also by address."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

from anyio import CapacityLimiter

from pointbrush.errors import TooManyRequestsError, UnavailableError

AT_ONCE = 8
"""Sign-ins that wait for the provider at the same time."""
FROM_ONE_ADDRESS = 4


class SignIns:
    """Counts the sign-ins that wait, on the event loop."""

    def __init__(self) -> None:
        self.threads = CapacityLimiter(AT_ONCE)
        self._waiting: Counter[str] = Counter()

    @contextmanager
    def one_of(self, address: str) -> Iterator[None]:
        """Count one sign-in from ``address`` until the context ends.

        Raises TooManyRequestsError, or UnavailableError while all threads wait.
        """
        if self._waiting[address] >= FROM_ONE_ADDRESS:
            raise TooManyRequestsError(
                f"sign-in: expected at most {FROM_ONE_ADDRESS} at a time from one address"
            )
        if self._waiting.total() >= AT_ONCE:
            raise UnavailableError("sign-in: all attempts wait for the provider, try again later")
        self._waiting[address] += 1
        try:
            yield
        finally:
            self._waiting[address] -= 1
            self._waiting += Counter()  # drops addresses without any
