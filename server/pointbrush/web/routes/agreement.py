"""Agreement of people with the same points to label, merging of their work, and ground truth."""

from __future__ import annotations

from typing import Annotated

from fastapi import Query
from pydantic import Field

from pointbrush.streaming.messages import FrameIndex, Uuid, Vec3
from pointbrush.teamwork.matching import Kind
from pointbrush.web.auth import Caller, resource
from pointbrush.web.context import SEQUENCE_ID, ProjectId, Ws
from pointbrush.web.problems import responses
from pointbrush.web.routes.checks import AgreementOut
from pointbrush.web.schemas import Body, EditOut, Out
from pointbrush.work.projects.agreeing import Region

router = resource("agreement")
Whole = Annotated[
    str, Query(pattern=SEQUENCE_ID, max_length=64, description="the recording that has copies")
]


class PlaceOut(Out):
    """A disagreement: labels of the first and second by name, and a point that differs."""

    kind: Kind
    frame: int
    first: list[str]
    second: list[str]
    labels: Annotated[
        list[list[int]], Field(description="their numbers in the first and the second copy")
    ]
    points: int
    has: Annotated[
        int | None,
        Field(description="0: the recording has the label of the first copy, 1: of the second"),
    ]
    place: Annotated[Vec3 | None, Field(description="source coordinates; null in an octree")]


class PairOut(Out):
    """Agreement of two copies, and places where they differ, the largest first."""

    first: str
    second: str
    agreement: AgreementOut
    places: list[PlaceOut]


Numbers = Annotated[list[Annotated[int, Field(ge=1, le=65534)]], Field(max_length=65534)]


class RegionBody(Body):
    """Points with one of these labels in a copy; ``frame`` null: in all submitted frames."""

    labels: Annotated[
        dict[Annotated[str, Field(pattern=SEQUENCE_ID, max_length=64)], Numbers],
        Field(
            min_length=1, max_length=9, json_schema_extra={"additionalProperties": False},
            description="labels, by the id of the copy",
        ),
    ]  # fmt: skip
    frame: FrameIndex | None = None


class MergeBody(Body):
    """Labels to merge: the ``majority`` of at least three people, or one copy by its id.

    ``region``: merge only these points.
    """

    sequence: Annotated[str, Field(pattern=SEQUENCE_ID, max_length=64)]
    take: Annotated[str, Field(pattern=SEQUENCE_ID, max_length=64)] = "majority"
    region: RegionBody | None = None
    id: Uuid | None = None


class ScoreOut(Out):
    """Work of a person on frames with ground truth; objects found, missed and added."""

    person: Annotated[str, Field(validation_alias="account")]
    frames: int
    miou: float | None
    found: int
    missed: int
    added: int


@router.get("/projects/{p}/agreement", responses=responses(404))
def get_agreement(p: ProjectId, sequence: Whole, workspace: Ws) -> list[PairOut]:
    """Compare the copies of a recording in pairs, in frames that both people have submitted."""
    return [PairOut.of(each) for each in workspace.agreeing.compare(p, sequence)]


@router.post("/projects/{p}/merge", responses=responses(404, 409, 413))
def merge(p: ProjectId, body: MergeBody, workspace: Ws, who: Caller) -> EditOut:
    """Write the labels of one copy, or of the majority, into the recording, as one edit."""
    region = None if body.region is None else Region(body.region.labels, body.region.frame)
    made = workspace.agreeing.merge(
        p, body.sequence, body.take, who.author, edit_id=body.id, region=region
    )
    return EditOut.of(made)


@router.get("/projects/{p}/scores", responses=responses(404))
def get_scores(p: ProjectId, workspace: Ws) -> list[ScoreOut]:
    """Compare the submitted labels of each person with the ground truth, the best first."""
    return [ScoreOut.of(each) for each in workspace.agreeing.scores(p)]
