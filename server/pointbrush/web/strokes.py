"""Request bodies with samples of a stroke, which are messages of the socket."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from pointbrush.streaming.messages import Brush, ClipBox, FrameIndex, LabelId, Message, Sample, Uuid
from pointbrush.values.base import integral

Rays = Annotated[list[Sample], Field(max_length=64)]


class SampleBody(Message):
    """Base of bodies with samples."""

    _integral = model_validator(mode="before")(integral)


class FloorBody(SampleBody):
    """Rays to the floor in a frame, source coordinates, as a stroke's samples."""

    frame: FrameIndex = Field(description="Number of the frame.")
    samples: Annotated[Rays, Field(min_length=1)] = Field(
        description="Rays to the floor: one places the recording, three level it better."
    )


class StrokeBody(Brush):
    """A whole stroke; the server applies an ``id`` once."""

    _integral = model_validator(mode="before")(integral)
    id: Uuid | None = Field(None, description="UUID of the edit, which is applied once.")
    samples: Annotated[list[Sample], Field(max_length=65536)] = Field(
        default_factory=list, description="Samples from press to release, source coordinates."
    )


class ObjectBody(SampleBody):
    """Rays at an object, and at points outside it; see a stroke of shape ``object``."""

    positives: Annotated[Rays, Field(min_length=1)] = Field(description="Rays at the object.")
    negatives: Rays = Field(default_factory=list, description="Rays at points outside it.")
    radius: Annotated[float, Field(gt=0, le=1000, allow_inf_nan=False)] = Field(
        0.05, description="Radius of the brush, metres: candidates begin at this size."
    )
    label: LabelId = Field(0, description="Id of the label to paint; 0: unknown yet.")
    take_labelled: bool = Field(False, description="Candidates may contain labelled points.")
    hidden: Annotated[list[LabelId], Field(max_length=65535)] = Field(
        default_factory=list, description="Labels that only this viewer hides; 0: unlabeled points."
    )
    clip: ClipBox | None = Field(None, description="Visible box, which contains all candidates.")
    previous: Annotated[str, Field(max_length=64)] = Field(
        "", description="Id of the candidate shown before; similar candidates are preferred."
    )
