"""Work on a few jobs ahead of what is asked for: reading, computing and writing overlap."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

WORKERS = 2
"""Threads; numpy and scipy let go of the interpreter's lock in their long loops."""

T = TypeVar("T")
A = TypeVar("A")


def ahead(
    pool: ThreadPoolExecutor, work: Callable[[A], T], jobs: Iterable[A], most: int = WORKERS
) -> Iterator[T]:
    """Results of ``work`` in the order of ``jobs``; ``most`` of them are worked on ahead."""
    pending: deque[Future[T]] = deque()
    try:
        for job in jobs:
            pending.append(pool.submit(work, job))
            if len(pending) > most:
                yield pending.popleft().result()
        while pending:
            yield pending.popleft().result()
    finally:
        for future in pending:
            future.cancel()
