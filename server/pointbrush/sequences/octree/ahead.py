"""Computation of a few results ahead: reading, computing and writing overlap."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

WORKERS = 2
"""Threads; numpy, scipy and compiled loops release the GIL."""

T = TypeVar("T")
A = TypeVar("A")


def ahead(
    pool: ThreadPoolExecutor,
    work: Callable[[A], T],
    jobs: Iterable[A],
    most: float = WORKERS,
    size: Callable[[A], float] = lambda _: 1.0,
) -> Iterator[T]:
    """Yield results of ``work`` in the order of ``jobs``, computing at most ``most`` ahead.

    ``size`` of a job is a share of the memory of a large one: more small jobs are computed ahead,
    so that no worker waits for another worker's large job.
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
