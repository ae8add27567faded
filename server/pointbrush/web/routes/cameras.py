"""Camera pictures beside a recording, and how its points project into them."""

from __future__ import annotations

from typing import Annotated

from fastapi import Path, Request, Response
from fastapi.responses import FileResponse
from pydantic import BaseModel, ConfigDict

from pointbrush.sequences.pictures import MEDIA_TYPES, find_picture, read_projections
from pointbrush.web.auth import resource
from pointbrush.web.context import FramePath, SequenceId, Ws
from pointbrush.web.problems import responses

router = resource("frames")
KEPT = "private, no-cache"
BINARY = {"schema": {"type": "string", "format": "binary"}}


class CameraOut(BaseModel):
    """A picture of a frame; a point p in source coordinates is at ``K (T_camera_frame p)``.

    ``distortion`` are the coefficients of ``model`` (``plumb_bob``: k1, k2, p1, p2, k3; none: the
    picture is rectified).  ``K`` and ``T_camera_frame`` are null where they are not known.
    """

    model_config = ConfigDict(from_attributes=True)

    name: str
    width: int
    height: int
    K: list[list[float]] | None
    distortion: list[float]
    model: str
    T_camera_frame: list[list[float]] | None


@router.get("/sequences/{seq}/frames/{i}/cameras", responses=responses(404))
def list_cameras(seq: SequenceId, i: FramePath, workspace: Ws) -> list[CameraOut]:
    """The cameras that took a picture at this frame; [] where there is none."""
    recording = workspace.recording(seq)
    found = read_projections(recording.path, recording[i].index)
    return [CameraOut.model_validate(each) for each in found]


@router.get(
    "/sequences/{seq}/frames/{i}/images/{camera}",
    response_class=Response,
    responses={
        200: {
            "description": "The picture as it came",
            "content": dict.fromkeys(MEDIA_TYPES.values(), BINARY),
        },
        304: {"description": "Not modified"},
        **responses(404),
    },
)
def get_image(
    seq: SequenceId,
    i: FramePath,
    camera: Annotated[str, Path(max_length=200, description="its name")],
    request: Request,
    workspace: Ws,
) -> Response:
    """The picture that a camera took at this frame, byte for byte as it was imported."""
    recording = workspace.recording(seq)
    path = find_picture(recording.path, recording[i].index, camera)
    tag = f'"{recording.identity}-{path.name}"'
    headers = {"ETag": tag, "Cache-Control": KEPT}
    if tag in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers)
    return FileResponse(path, media_type=MEDIA_TYPES[path.suffix], headers=headers)
