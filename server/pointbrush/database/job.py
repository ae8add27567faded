"""The state of a job, as the server's parts see it."""

from __future__ import annotations

import time
import uuid
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from pointbrush.values import jobs as values
from pointbrush.values.jobs import JobState

ENDED: tuple[JobState, ...] = ("done", "failed", "cancelled")


@dataclass(frozen=True, kw_only=True)
class Job(values.Job):
    """State of one job; a new value at every change."""

    id: str = field(default_factory=lambda: str(uuid.uuid4()))
    sequence: str | None = None
    state: JobState = "queued"
    progress: float = 0.0
    message: str = ""
    result: dict[str, Any] | None = None
    error: str | None = None
    created: float = field(default_factory=time.time)
    edit: str | None = None
    """Id of the edit that it makes, if any."""
    request: Mapping[str, Any] | None = None
    """Request that restarts it after its server has ended, as JSON; None: not restartable."""
