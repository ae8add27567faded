"""The JSON shapes of long work: imports, tracking runs and what they find, jobs."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field

from pointbrush.formats import format_names
from pointbrush.jobs import Job
from pointbrush.streaming.messages import FrameIndex, LabelId, Matrix4, Uuid
from pointbrush.tracking import METHODS
from pointbrush.web.context import one_of
from pointbrush.web.schemas import Body, Name, PaintId


class ImportBody(Body):
    """Import files that the server can already read."""

    path: Annotated[str, Field(min_length=1, max_length=4096, pattern=r"^[^\x00]+$")]
    name: Name | None = None
    fps: Annotated[float, Field(gt=0, le=1000, allow_inf_nan=False)] | None = None
    format: Annotated[str, Field(pattern=one_of(format_names()))] | None = None
    drop_invalid: bool = False


class TrackingBody(Body):
    """A tracking run; ``stop`` below ``start`` tracks backward.

    A label ends at its first lost frame unless ``continue_lost``, and at the next frame where it
    is painted with ``until_painted``; with ``stop_unsure`` the run ends where a label is doubtful.
    """

    labels: Annotated[list[PaintId], Field(min_length=1, max_length=65534)] | None = None
    start: FrameIndex
    stop: FrameIndex
    method: Annotated[str, Field(pattern=one_of(METHODS))] = "auto"
    overwrite: Literal["never", "tracked", "all"] = "tracked"
    continue_lost: bool = False
    until_painted: bool = False
    stop_unsure: bool = False
    id: Uuid | None = None


class AcceptBody(Body):
    """Labels of a frame that a person vouches for."""

    labels: Annotated[list[PaintId], Field(min_length=1, max_length=65534)]
    id: Uuid | None = None


class TrackOut(BaseModel):
    """A label's track in one frame."""

    label: LabelId
    frame: FrameIndex
    pose: Matrix4
    rmse: float | None
    inliers: float
    confidence: float
    points: int
    state: Literal["tracked", "occluded", "lost", "painted"]


class JobOut(BaseModel):
    """Long work and how far it is."""

    id: str
    kind: Literal["import", "tracking", "export"]
    sequence: str | None
    state: Literal["queued", "running", "done", "failed", "cancelled"]
    progress: float
    message: str
    result: dict[str, Any] | None
    error: str | None

    @classmethod
    def of(cls, job: Job) -> JobOut:
        """From the runner's record."""
        return cls(
            id=job.id, kind=job.kind, sequence=job.sequence, state=job.state,
            progress=job.progress, message=job.message, result=job.result, error=job.error,
        )  # fmt: skip
