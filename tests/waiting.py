"""Waiting for what another thread or process is about to do."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from typing import Any

PATIENCE = 120.0
"""Seconds after which a test gives an event up: far more than a busy machine needs."""


def eventually(found: Callable[[], Any], seconds: float = PATIENCE, every: float = 0.01) -> Any:
    """Poll until ``found`` returns something true; returns it, fails after ``seconds``."""
    deadline = time.monotonic() + seconds
    while not (value := found()):
        assert time.monotonic() < deadline, f"not within {seconds} s"
        time.sleep(every)
    return value


async def comes_true(holds: Callable[[], Any]) -> None:
    """Let the event loop run until ``holds`` returns something true; fails after PATIENCE."""
    deadline = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < deadline, f"not within {PATIENCE} s"
        await asyncio.sleep(0.002)
