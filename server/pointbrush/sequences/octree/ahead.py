"""Work on a few jobs ahead of what is asked for: reading, computing and writing overlap."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

WORKERS = 2
"""Threads; numpy, scipy and compiled loops let go of the interpreter's lock."""

T = TypeVar("T")
A = TypeVar("A")


def ahead(
    pool: ThreadPoolExecutor,
    work: Callable[[A], T],
    jobs: Iterable[A],
    most: float = WORKERS,
    size: Callable[[A], float] = lambda _: 1.0,
) -> Iterator[T]:
    """Results of ``work`` in the order of ``jobs``; ``most`` of them are worked on ahead.

    ``size`` of a job is a share of the memory of a large one: more small jobs are worked on ahead,
    so that no worker waits for another's large one.
    """
    pending: deque[tuple[Future[T], float]] = deque()
    held = 0.0
    try:
        for job in jobs:
            pending.append((pool.submit(work, job), size(job)))
            held += pending[-1][1]
            while held > most:
                future, freed = pending.popleft()
                held -= freed
                yield future.result()
        while pending:
            yield pending.popleft()[0].result()
    finally:
        for future, _ in pending:
            future.cancel()
