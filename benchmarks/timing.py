"""Paired timing: the candidates in turn, so that a drifting machine slows all of them alike."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping


def paired(
    candidates: Mapping[str, Callable[[], object]], rounds: int = 15
) -> dict[str, list[float]]:
    """Seconds of each candidate in each of ``rounds`` rounds, after one that does not count."""
    seconds: dict[str, list[float]] = {name: [] for name in candidates}
    for counted in [False] + [True] * rounds:
        for name, run in candidates.items():
            start = time.perf_counter()
            run()
            if counted:
                seconds[name].append(time.perf_counter() - start)
    return seconds


def table(seconds: Mapping[str, list[float]], ours: str) -> str:
    """A line each: median milliseconds, and how many times as long as ``ours`` took."""
    lines = []
    for name, times in seconds.items():
        ratio = statistics.median(t / o for t, o in zip(times, seconds[ours], strict=True))
        lines.append(f"  {name:40} {1e3 * statistics.median(times):9.3f} ms {ratio:8.2f} x")
    return "\n".join(lines)
