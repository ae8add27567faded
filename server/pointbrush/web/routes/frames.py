"""A frame's points, annotation layers, and immutable wire chunks."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from fastapi import Depends, Header, Path, Query, Request, Response
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import StreamingResponse
from numpy.typing import NDArray

from pointbrush.errors import NotFoundError
from pointbrush.sequences import Chunk
from pointbrush.streaming.messages import Uuid
from pointbrush.web import npy
from pointbrush.web.auth import Caller, resource
from pointbrush.web.context import FramePath, SequenceId, Ws, body_within, etag, if_match
from pointbrush.web.problems import responses
from pointbrush.web.schemas import ChunkOut, ChunkTable, EditOut
from pointbrush.work.annotate.layers import require_layer
from pointbrush.workspace import Workspace

router = resource("frames")
Layer = Annotated[Literal["label", "provenance", "deleted"], Query(description="which values")]
HEADER_ROOM = 4096
WIDEST = 8
"""Bytes a value of the widest type that is read, to say that the type is wrong."""
BINARY = {"schema": {"type": "string", "format": "binary"}}
FOREVER = "private, max-age=31536000, immutable"
REVALIDATED = "private, no-cache"
HOUR = "private, max-age=3600"


@router.get(
    "/sequences/{seq}/frames/{i}/points",
    response_class=Response,
    responses={
        200: {
            "description": "Points",
            "content": {npy.MEDIA_TYPE: BINARY, "application/zip": BINARY},
        },
        **responses(404),
    },
)
def get_points(
    seq: SequenceId,
    i: FramePath,
    workspace: Ws,
    format: Annotated[Literal["npy", "npz"], Query()] = "npy",
) -> Response:
    """All points in the source's order and coordinates: structured ``.npy``, or ``.npz``."""
    frame = workspace.recording(seq)[i]
    if format == "npz":
        fields = {
            name: _column(workspace, seq, i, name)
            for name in ("xyz", "rgb", "intensity")
            if getattr(frame, name) is not None
        }
        return StreamingResponse(npy.stream_npz(fields, frame.count), media_type="application/zip")
    length, pieces = npy.stream_points(workspace.points(seq, i), frame.count)
    headers = {"Content-Length": str(length)}
    return StreamingResponse(pieces, media_type=npy.MEDIA_TYPE, headers=headers)


def _column(workspace: Workspace, seq: str, i: int, name: str) -> Iterator[NDArray[Any]]:
    return (columns[name] for columns in workspace.points(seq, i, (name,)))


@router.get(
    "/sequences/{seq}/frames/{i}/annotation",
    response_class=Response,
    responses={
        200: {"description": "One value a point", "content": {npy.MEDIA_TYPE: BINARY}},
        304: {"description": "Not modified"},
        **responses(404),
    },
)
def get_annotation(
    seq: SequenceId,
    i: FramePath,
    workspace: Ws,
    layer: Layer = "label",
    if_none_match: Annotated[str | None, Header()] = None,
) -> Response:
    """One value a point in the source's order: uint16 labels, uint8 provenance, bool deleted.

    The ``ETag`` is the revision of the frame's last change, in any layer.
    """
    blocks, revision = workspace.annotation_blocks(seq, i, layer)
    headers = {"ETag": etag(revision), "Cache-Control": REVALIDATED}
    if if_none_match is not None and etag(revision) in if_none_match:
        return Response(status_code=304, headers=headers)
    count = workspace.recording(seq)[i].count
    length, pieces = npy.stream_array(blocks, require_layer(layer), count)
    headers["Content-Length"] = str(length)
    return StreamingResponse(pieces, media_type=npy.MEDIA_TYPE, headers=headers)


async def annotation_body(
    request: Request, seq: SequenceId, i: FramePath, workspace: Ws
) -> bytearray:
    """The body, if it can be an array of this frame's values."""
    frame = await run_in_threadpool(lambda: workspace.recording(seq)[i])
    return await body_within(request, frame.count * WIDEST + HEADER_ROOM, "annotation")


AnnotationBody = Annotated[bytearray, Depends(annotation_body)]


@router.put(
    "/sequences/{seq}/frames/{i}/annotation",
    responses=responses(404, 409, 413),
    openapi_extra={"requestBody": {"required": True, "content": {npy.MEDIA_TYPE: BINARY}}},
)
def put_annotation(
    seq: SequenceId,
    i: FramePath,
    body: AnnotationBody,
    response: Response,
    workspace: Ws,
    who: Caller,
    layer: Layer = "label",
    id: Annotated[Uuid | None, Query(description="the edit's UUID")] = None,
    if_match_: Annotated[
        str | None, Header(alias="If-Match", pattern=r'^(\*|"?[0-9]{1,18}"?)$')
    ] = None,
) -> EditOut:
    """Replace a layer, as one edit.

    ``If-Match`` refuses it (409) when this frame has changed since that revision, or the revision
    is yet to come; edits in other frames do not matter.
    """
    count = workspace.recording(seq)[i].count
    commit = workspace.put_annotation(
        seq,
        i,
        npy.parse(body, require_layer(layer), count),
        author=who.author,
        layer=layer,
        if_match=if_match(if_match_),
        edit=id,
    )
    response.headers["ETag"] = etag(workspace.changed(seq, i, commit))
    return EditOut.of(commit)


@router.get("/sequences/{seq}/frames/{i}/chunks", responses=responses(404))
def get_chunk_table(seq: SequenceId, i: FramePath, workspace: Ws) -> ChunkTable:
    """Return each wire chunk's place, its points and how to dequantise them."""
    recording = workspace.recording(seq)
    frame = recording[i]
    rows = [_row(chunk) for chunk in frame.chunks]
    return ChunkTable(frame=i, points=frame.count, identity=recording.identity, chunks=rows)


def _row(chunk: Chunk) -> ChunkOut:
    return ChunkOut(**{name: getattr(chunk, name) for name in ChunkOut.model_fields})


@router.get(
    "/sequences/{seq}/frames/{i}/chunks/{c}",
    response_class=Response,
    responses={
        200: {"description": "Encoded points", "content": {"application/octet-stream": BINARY}},
        304: {"description": "Not modified"},
        **responses(404),
    },
)
def get_chunk(
    seq: SequenceId,
    i: FramePath,
    c: Annotated[int, Path(ge=0, lt=2**31, description="chunk number, from 0")],
    request: Request,
    workspace: Ws,
    identity: Annotated[
        str | None, Query(max_length=64, description="the import's, from the table")
    ] = None,
) -> Response:
    """One chunk's bytes.  With ``identity`` they never change: a cache or CDN can stand in front.

    Without it the URL may come to mean another recording, and is asked for again each time.
    """
    recording = workspace.recording(seq)
    if identity not in (None, recording.identity):
        raise NotFoundError(f"identity: expected {recording.identity}, got {identity}")
    data = recording[i].wire(c, c + 1)
    tag = f'"{recording.identity}-{i}-{c}"'
    headers = {"ETag": tag, "Cache-Control": REVALIDATED if identity is None else FOREVER}
    if tag in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers)
    return Response(bytes(data), media_type="application/octet-stream", headers=headers)


@router.get(
    "/sequences/{seq}/frames/{i}/thumbnail",
    response_class=Response,
    responses={200: {"description": "A JPEG", "content": {"image/jpeg": BINARY}}, **responses(404)},
)
def get_thumbnail(seq: SequenceId, i: FramePath, workspace: Ws) -> Response:
    """A small picture of the frame, from the sensor or over all of it."""
    return Response(
        workspace.thumbnail(seq, i), media_type="image/jpeg", headers={"Cache-Control": HOUR}
    )
