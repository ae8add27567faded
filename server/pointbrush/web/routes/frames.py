"""A frame's points, annotation layers and wire chunks, camera pictures and placements.

Camera pictures come with projections of the points into them; placements are of the frames that
overlay the shown one.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import PurePath
from typing import Annotated, Any, Literal

import numpy as np
from fastapi import Depends, Header, Path, Query, Request, Response
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import StreamingResponse
from numpy.typing import NDArray

from pointbrush.errors import NotFoundError
from pointbrush.selection import MAX_FRAMES
from pointbrush.sequences.pictures import MEDIA_TYPES
from pointbrush.values.edits import Edit
from pointbrush.values.frames import Camera, ChunkTable, Moving, Placement
from pointbrush.web import npy
from pointbrush.web.context import (
    EditId,
    FramePath,
    IfNoneMatch,
    SequenceId,
    SnapshotQuery,
    Ws,
    body_within,
    etag,
    if_match,
)
from pointbrush.web.problems import BINARY
from pointbrush.web.security.auth import Caller, resource
from pointbrush.web.security.roles import needs, needs_for_file
from pointbrush.work.annotate.layers import require_layer
from pointbrush.work.annotate.overlays import Placement as LocalPlacement
from pointbrush.work.annotate.overlays import placements_round
from pointbrush.work.exporting import SENT, source_columns
from pointbrush.workspace import Workspace

router = resource("frames")
LAYERS = (
    "values: `label` uint16 id, 0 without one; `provenance` uint8, 0 none, 1 painted, 2 tracked, "
    "3 imported, 4 predicted; `deleted` bool"
)
Layer = Annotated[
    Literal["label", "provenance", "deleted", "confidence"],
    Query(description=f"{LAYERS}; `confidence` uint8 of predicted points"),
]
Written = Annotated[Literal["label", "provenance", "deleted"], Query(description=LAYERS)]
WIDEST = 8
"""Bytes a value of the widest type that is read before it is refused as a wrong type."""
FOREVER = "private, max-age=31536000, immutable"
REVALIDATED = "private, no-cache"
HOUR = "private, max-age=3600"
Many = Annotated[
    int, Query(ge=0, le=MAX_FRAMES // 2, description="number of neighbouring frames on this side")
]


@router.get(
    "/sequences/{seq}/frames/{i}/points",
    **needs_for_file("viewer", "Points", npy.MEDIA_TYPE, "application/zip"),
)
def get_points(
    seq: SequenceId,
    i: FramePath,
    workspace: Ws,
    format: Annotated[
        Literal["npy", "npz"],
        Query(description="`npy`: one structured array; `npz`: an array for each field"),
    ] = "npy",
) -> Response:
    """Return all points in source order and coordinates: structured ``.npy``, or ``.npz``.

    ``sensor`` is the number of each point's sensor, if the recording has several.  The ``.npz`` has
    ``pixel`` (N, 2), row and column, for points of a depth image.
    """
    frame = workspace.recording(seq)[i]
    if format == "npz":
        fields = {
            name: _column(workspace, seq, i, name)
            for name in SENT
            if getattr(frame, name) is not None
        }
        if (pixel := workspace.masks.pixel(seq, i)) is not None:
            fields["pixel"] = iter([pixel])
        return StreamingResponse(npy.stream_npz(fields, frame.count), media_type="application/zip")
    length, pieces = npy.stream_points(source_columns(workspace.recording(seq), i), frame.count)
    headers = {"Content-Length": str(length)}
    return StreamingResponse(pieces, media_type=npy.MEDIA_TYPE, headers=headers)


def _column(workspace: Workspace, seq: str, i: int, name: str) -> Iterator[NDArray[Any]]:
    return (columns[name] for columns in source_columns(workspace.recording(seq), i, (name,)))


@router.get(
    "/sequences/{seq}/frames/{i}/annotation",
    **needs_for_file("viewer", "One value a point", npy.MEDIA_TYPE, cached=True),
)
def get_annotation(
    seq: SequenceId,
    i: FramePath,
    workspace: Ws,
    layer: Layer = "label",
    order: Annotated[
        Literal["source", "stored"],
        Query(description="order of points: `source` as in the file, `stored` as in the chunks"),
    ] = "source",
    snapshot: SnapshotQuery = None,
    revision: Annotated[
        int | None, Query(ge=0, lt=2**53, description="labels as they were after this edit")
    ] = None,
    if_none_match: IfNoneMatch = None,
) -> Response:
    """Return one value per point in source order: uint16 labels, uint8 provenance, bool deleted.

    The layer confidence is uint8, and 0 for points that were not predicted.  ``order`` stored: in
    the order of the wire chunks, which the page uses.
    The ``ETag`` is the revision of the frame's last change, in any layer, of the snapshot, or
    the given ``revision``.
    """
    past = None if snapshot is None else workspace.versions.labels(seq, snapshot)
    if revision is not None:
        past = workspace.versions.labels_at(seq, revision)
    stored = order == "stored"
    blocks, found = workspace.annotations.blocks(seq, i, layer, past, stored=stored)
    headers = {"ETag": etag(found), "Cache-Control": REVALIDATED}
    if if_none_match is not None and etag(found) in if_none_match:
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
    return await body_within(request, frame.count * WIDEST + npy.HEADER_ROOM, "annotation")


AnnotationBody = Annotated[bytearray, Depends(annotation_body)]


@router.put(
    "/sequences/{seq}/frames/{i}/annotation",
    **needs("annotator", 404, 409, 413),
    openapi_extra={"requestBody": {"required": True, "content": {npy.MEDIA_TYPE: BINARY}}},
)
def put_annotation(
    seq: SequenceId,
    i: FramePath,
    body: AnnotationBody,
    response: Response,
    workspace: Ws,
    who: Caller,
    layer: Written = "label",
    id: EditId = None,
    if_match_: Annotated[
        str | None,
        Header(
            alias="If-Match",
            pattern=r'^(\*|"?[0-9]{1,18}"?)$',
            description="`ETag` that the values were made from",
        ),
    ] = None,
) -> Edit:
    """Replace a layer, as one edit.

    ``If-Match`` refuses the call (409) if this frame has changed since that revision, or if the
    revision does not exist yet; edits in other frames do not count.
    """
    count = workspace.recording(seq)[i].count
    commit = workspace.annotations.put(
        seq,
        i,
        npy.parse(body, require_layer(layer), count),
        author=who.author,
        layer=layer,
        if_match=if_match(if_match_),
        edit=id,
    )
    response.headers["ETag"] = etag(workspace.annotations.changed(seq, i, commit))
    return commit


@router.get("/sequences/{seq}/frames/{i}/chunks", **needs("viewer", 404))
def get_chunk_table(seq: SequenceId, i: FramePath, workspace: Ws) -> ChunkTable:
    """Return the position, the points and the dequantisation of each wire chunk."""
    recording = workspace.recording(seq)
    frame = recording[i]
    return ChunkTable(i, frame.count, recording.identity, tuple(frame.chunks))


@router.get(
    "/sequences/{seq}/frames/{i}/chunks/{c}",
    **needs_for_file("viewer", "Encoded points", "application/octet-stream", cached=True),
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
    """Return the bytes of a chunk.  With ``identity`` they never change, so caches may store them.

    Without it the URL may later belong to another recording, so caches must revalidate it.
    """
    recording = workspace.recording(seq)
    if identity not in (None, recording.identity, recording.placement):
        raise NotFoundError(f"identity: expected {recording.identity}, got {identity}")
    data = recording[i].wire(c, c + 1)
    tag = f'"{recording.identity}-{i}-{c}"'
    headers = {"ETag": tag, "Cache-Control": REVALIDATED if identity is None else FOREVER}
    if tag in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers)
    return Response(bytes(data), media_type="application/octet-stream", headers=headers)


@router.get(
    "/sequences/{seq}/frames/{i}/thumbnail", **needs_for_file("viewer", "A JPEG", "image/jpeg")
)
def get_thumbnail(
    seq: SequenceId,
    i: FramePath,
    workspace: Ws,
    # For caches only: another import of the name has another address.
    of: Annotated[str, Query(max_length=64, description="the identity; changes nothing")] = "",  # noqa: ARG001
) -> Response:
    """Return a small picture of the frame, from the sensor or of the whole frame."""
    return Response(
        workspace.thumbnail(seq, i), media_type="image/jpeg", headers={"Cache-Control": HOUR}
    )


@router.get("/sequences/{seq}/frames/{i}/cameras", **needs("viewer", 404))
def list_cameras(seq: SequenceId, i: FramePath, workspace: Ws) -> list[Camera]:
    """List the cameras that have a picture of this frame."""
    return list(map(Camera.of, workspace.recording(seq).projections(i)))


@router.get(
    "/sequences/{seq}/frames/{i}/images/{camera}",
    **needs_for_file("viewer", "The picture as it came", *MEDIA_TYPES.values(), cached=True),
)
def get_image(
    seq: SequenceId,
    i: FramePath,
    camera: Annotated[str, Path(max_length=200, description="its name")],
    request: Request,
    workspace: Ws,
) -> Response:
    """Return a camera's picture of this frame, byte for byte as imported."""
    recording = workspace.recording(seq)
    name, content = recording.picture(i, camera)
    tag = f'"{recording.identity}-{name}"'
    headers = {"ETag": tag, "Cache-Control": REVALIDATED}
    if tag in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers)
    return Response(content, media_type=MEDIA_TYPES[PurePath(name).suffix], headers=headers)


@router.get("/sequences/{seq}/frames/{i}/placements", **needs("viewer", 404))
def list_placements(
    seq: SequenceId, i: FramePath, workspace: Ws, before: Many = 0, after: Many = 0
) -> list[Placement]:
    """Return the placement of frame ``i`` and of its neighbours for a stroke with ``frames``.

    The poses of the recording place the frames; its track places the points of a tracked label.
    """
    recording = workspace.recording(seq)
    shift = np.asarray(recording.manifest.shift, np.float64)
    found = placements_round(workspace.labels, recording, i, before, after)
    return [_in_source(placement, shift) for placement in found]


def _in_source(placement: LocalPlacement, shift: NDArray[np.float64]) -> Placement:
    """Return a placement in source coordinates: local coordinates plus ``shift``."""

    def source(T: NDArray[np.float64]) -> NDArray[np.float64]:
        moved = T.copy()
        moved[:3, 3] += shift - T[:3, :3] @ shift
        return moved

    moving = (Moving(label, source(T)) for label, T in sorted(placement.moving.items()))
    return Placement(placement.frame, source(placement.T_shown_frame), tuple(moving))
