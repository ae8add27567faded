"""Agreement of two annotators: recordings of the same points, labelled twice."""

from __future__ import annotations

from typing import Annotated

from fastapi import Query, Response
from pydantic import BaseModel, Field

from pointbrush.web.auth import resource
from pointbrush.web.context import FramePath, SequenceId, Ws
from pointbrush.web.problems import responses
from pointbrush.work.reviewing import Agreement, By

router = resource("review")
PNG = "image/png"
Other = Annotated[
    str,
    Query(
        alias="with",
        pattern=r"^[a-z0-9][a-z0-9._-]{0,63}$",
        max_length=64,
        description="the other recording of the same points",
    ),
]
Share = Annotated[float, Field(ge=0, le=1)]
CompareBy = Annotated[By, Query(description="labels are the same by")]


class LabelAgreementOut(BaseModel):
    """A label by name: its points in the first, the second and both."""

    name: str
    iou: Share
    first: int
    second: int
    both: int


class FrameAgreementOut(BaseModel):
    """Points of a frame that either labelled, and those of them that differ."""

    frame: int
    labelled: int
    differ: int


class AgreementOut(BaseModel):
    """Null where neither has labelled anything."""

    miou: Share | None
    same: Share | None
    labels: list[LabelAgreementOut]
    frames: list[FrameAgreementOut]

    @classmethod
    def of(cls, found: Agreement) -> AgreementOut:
        """From the workspace's."""
        labels = [
            LabelAgreementOut(
                name=each.name, iou=each.iou, first=each.first, second=each.second, both=each.both
            )
            for each in found.labels
        ]
        frames = [
            FrameAgreementOut(frame=each.frame, labelled=each.labelled, differ=each.differ)
            for each in found.frames
        ]
        return cls(miou=found.miou, same=found.same, labels=labels, frames=frames)


@router.get("/sequences/{seq}/agreement", responses=responses(404))
def get_agreement(
    seq: SequenceId,
    workspace: Ws,
    other: Other,
    by: CompareBy = "name",
    frames: Annotated[str | None, Query(pattern=r"^[0-9:]*$", description="I:J")] = None,
) -> AgreementOut:
    """IoU of each label between two annotations, and the points of each frame that differ."""
    return AgreementOut.of(workspace.reviewing.agreement(seq, other, by, frames))


@router.get(
    "/sequences/{seq}/frames/{i}/agreement",
    response_class=Response,
    responses={
        200: {
            "description": "The frame from above",
            "content": {PNG: {"schema": {"type": "string", "format": "binary"}}},
        },
        **responses(404),
    },
)
def get_difference(
    seq: SequenceId, i: FramePath, workspace: Ws, other: Other, by: CompareBy = "name"
) -> Response:
    """Draw the differences of two annotations as a picture from above.

    Blue: only the first has a label, orange: only the second, pink: another one, light: the same.
    """
    return Response(workspace.reviewing.difference(seq, other, i, by), media_type=PNG)
