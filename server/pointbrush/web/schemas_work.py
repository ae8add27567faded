"""The JSON schemas of imports, tracking runs and their results, and jobs."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from pointbrush.database.project_tables import FIRST
from pointbrush.formats import format_names
from pointbrush.formats.tables.corrections import (
    LARGEST_SCALE,
    MOST_COLUMNS,
    Corrections,
    parse_corrections,
)
from pointbrush.formats.tables.names import DELIMITERS
from pointbrush.settings.definitions import chosen
from pointbrush.streaming.messages import FrameIndex, LabelId, Matrix4, Uuid
from pointbrush.tracking import METHODS
from pointbrush.web.context import SEQUENCE_ID, one_of
from pointbrush.web.schemas import Body, Name, Out, PaintId
from pointbrush.work.imports.previewing import Preview
from pointbrush.work.tracking.options import RunOptions

ColumnName = Annotated[str, Field(min_length=1, max_length=200)]


JobId = Annotated[Uuid, Field(description="of the job: a repeated call does not begin another")]
Text = Annotated[str, Field(min_length=1, max_length=4096, pattern=r"^[^\x00]+$")]


class ImportOptions(Body):
    """Corrections by a person to an import's files; see ``formats.corrections.Corrections``."""

    name: Name | None = None
    fps: Annotated[float, Field(gt=0, le=1000, allow_inf_nan=False)] | None = None
    format: Annotated[str, Field(pattern=one_of(format_names()))] | None = None
    columns: Annotated[list[ColumnName], Field(max_length=MOST_COLUMNS)] | None = None
    delimiter: Annotated[str, Field(pattern=one_of(DELIMITERS) + r"|^[^\x00]$")] | None = None
    decimal_comma: bool | None = None
    scale: Annotated[float, Field(gt=0, le=LARGEST_SCALE, allow_inf_nan=False)] | None = None
    up: Annotated[str, Field(pattern=r"^\+?(x|y|z|-x|-y|-z)$")] | None = None
    topic: Annotated[str, Field(min_length=1, max_length=1000)] | None = None
    poses: Text | None = None
    by_order: bool = False
    drop_invalid: bool = False
    project: Annotated[str, Field(pattern=SEQUENCE_ID, max_length=64)] = FIRST
    id: JobId | None = None

    @model_validator(mode="before")
    @classmethod
    def _listed(cls, value: Any) -> Any:
        """Also accept ``columns`` as one text with commas."""
        if isinstance(value, dict) and isinstance(value.get("columns"), str):
            return {**value, "columns": [part.strip() for part in value["columns"].split(",")]}
        return value

    @property
    def chosen(self) -> Corrections:
        """The corrections among them; raises BadInputError."""
        return parse_corrections(chosen(Corrections, self))


class ImportBody(ImportOptions):
    """Import files that the server can already read: at ``path``, or a previewed ``upload``."""

    path: Text | None = None
    upload: Annotated[str, Field(pattern="^[0-9a-f]{32}$")] | None = None


@dataclass(frozen=True)
class PreviewOut(Preview):
    """Preview of an import; ``upload`` names its uploaded files for an hour."""

    upload: str | None = None

    @classmethod
    def of(cls, preview: Preview, upload: str | None) -> PreviewOut:
        """Return the answer for the workspace's preview."""
        return cls(**asdict(preview), upload=upload)


class TrackingBody(Body, RunOptions):
    """A tracking run; ``stop`` below ``start`` tracks backward.

    A label ends at its first lost frame unless ``continue_lost``, and with ``until_painted`` at the
    next frame in which it is painted.  With ``stop_unsure`` the run ends at a doubtful frame.
    """

    labels: Annotated[list[PaintId], Field(min_length=1, max_length=65534)] | None = None
    start: FrameIndex
    stop: FrameIndex
    method: Annotated[str, Field(pattern=one_of(METHODS))] = RunOptions.method
    id: Uuid | None = None


class AcceptBody(Body):
    """Labels of a frame that a person accepts."""

    labels: Annotated[list[PaintId], Field(min_length=1, max_length=65534)]
    id: Uuid | None = None


class CopyBody(Body):
    """Labels to copy from another frame."""

    labels: Annotated[list[PaintId], Field(min_length=1, max_length=65534)]
    source: FrameIndex
    id: Uuid | None = None


class ClearBody(Body):
    """Labels to remove from their points, in this frame or up to ``stop`` (included)."""

    labels: Annotated[list[PaintId], Field(min_length=1, max_length=65534)]
    stop: FrameIndex | None = None
    id: Uuid | None = None


class StretchBody(AcceptBody):
    """Labels in the frames from ``start`` to ``stop``, both included."""

    start: FrameIndex
    stop: FrameIndex

    @property
    def frames(self) -> range:
        """The frames, ascending."""
        return range(min(self.start, self.stop), max(self.start, self.stop) + 1)


class TrackOut(Out):
    """A label's track in one frame."""

    label: LabelId
    frame: FrameIndex
    pose: Matrix4
    rmse: float | None
    inliers: float
    confidence: float
    points: int
    state: Literal["tracked", "occluded", "lost", "painted"]


class JobOut(Out):
    """State and progress of a job."""

    id: str
    kind: Literal["import", "tracking", "export", "prediction", "fitting"]
    sequence: str | None
    state: Literal["queued", "running", "done", "failed", "cancelled"]
    progress: float
    message: str
    result: dict[str, Any] | None
    error: str | None
    owner: Annotated[str | None, Field(description="the account that started it")] = None
