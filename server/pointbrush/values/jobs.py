"""Long work of the server."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pointbrush.values.base import Meanings, Value

JobKind = Annotated[
    Literal["import", "tracking", "export", "prediction", "fitting", "alignment"],
    Meanings(
        {
            "import": "reads files of points or labels",
            "tracking": "carries labels to other frames",
            "export": "writes files",
            "prediction": "applies a classifier, or finds people",
            "fitting": "fits boxes",
            "alignment": "aligns sensors",
        }
    ),
]
JobState = Annotated[
    Literal["queued", "running", "done", "failed", "cancelled"],
    Meanings(
        {
            "queued": "waits for a worker",
            "running": "at work",
            "done": "ended with a result",
            "failed": "ended with an error",
            "cancelled": "ended by a person",
        }
    ),
]


@dataclass(frozen=True, slots=True)
class Job(Value):
    """State and progress of a job."""

    id: str
    """UUID of the job."""
    kind: JobKind
    """Kind of work."""
    sequence: str | None
    """Id of its recording; null: an import without one yet."""
    state: JobState
    """State of the work; the last three are final."""
    progress: float
    """Finished share, 0 to 1."""
    message: str
    """Sentence about the present step or the result; may be empty."""
    result: dict[str, Any] | None
    """Result of a job that is done, as its call describes it."""
    error: str | None
    """Reason of a failure."""
    owner: str | None = None
    """Account that started it; null: the server."""
