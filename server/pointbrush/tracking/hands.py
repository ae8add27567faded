"""Work on several things at once, in threads, where that pays."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from typing import TypeVar

from pointbrush.tracking.thing import Thing

R = TypeVar("R")
MOST = 4
"""Threads at most: what they share of the interpreter leaves no work for more."""


class Hands(AbstractContextManager["Hands"]):
    """A few threads; what they are given to do must touch nothing that another touches.

    Only where a large thing is among them: its time goes into k-d trees and long arrays, which
    release the interpreter, while small ones would wait for each other.
    """

    def __init__(self) -> None:
        self._count = min(MOST, os.cpu_count() or 1)
        self._pool: ThreadPoolExecutor | None = None

    def each(self, do: Callable[[Thing], R], things: Iterable[Thing]) -> dict[int, R]:
        """Label → ``do(thing)``, in the order of the things."""
        some = list(things)
        if self._count < 2 or len(some) < 2 or not any(thing.large for thing in some):
            return {thing.label: do(thing) for thing in some}
        if self._pool is None:
            self._pool = ThreadPoolExecutor(self._count)
        # The longest first, so that none is left over at the end.
        order = sorted(some, key=lambda thing: -thing.size)
        futures = {thing.label: self._pool.submit(do, thing) for thing in order}
        return {thing.label: futures[thing.label].result() for thing in some}

    def __exit__(self, *_: object) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()
