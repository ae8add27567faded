"""Masks of the pictures of a frame: labels from masks, and masks from labels."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from fastapi import Depends, Header, Path, Query, Request, Response
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.streaming.messages import Uuid
from pointbrush.values.masks import MOST_BYTES, MaskEdit, MaskPrompt, MaskSource
from pointbrush.web import npy
from pointbrush.web.context import FramePath, SequenceId, Ws, body_within, etag
from pointbrush.web.problems import BINARY
from pointbrush.web.routes.frames import REVALIDATED
from pointbrush.web.security.auth import Caller, resource
from pointbrush.web.security.roles import needs, needs_for_file

if TYPE_CHECKING:
    from pointbrush.work.masks.classes import Classes

router = resource("masks")
PNG = "image/png"
CameraPath = Annotated[
    str, Path(max_length=200, description="name of the camera; `depth`: the depth image")
]
CONTENT = {PNG: BINARY, npy.MEDIA_TYPE: BINARY}
LONGEST_CLASSES = 32_000
"""Limit of the text of a query's classes; a URL has at most 64 kB."""


async def mask_body(request: Request) -> bytearray:
    """Read the body, if it can be a mask."""
    return await body_within(request, MOST_BYTES, "mask")


@router.put(
    "/sequences/{seq}/frames/{i}/masks/{camera}",
    **needs("annotator", 404, 409, 413),
    openapi_extra={"requestBody": {"required": True, "content": CONTENT}},
)
def put_mask(
    seq: SequenceId,
    i: FramePath,
    camera: CameraPath,
    request: Request,
    body: Annotated[bytearray, Depends(mask_body)],
    workspace: Ws,
    who: Caller,
    classes: Annotated[
        str | None,
        Query(
            max_length=LONGEST_CLASSES,
            description='JSON: label id or name of a label or class by value, `{"1": "car"}`; '
            "label id 0 removes labels; by default the values are label ids",
        ),
    ] = None,
    source: Annotated[
        MaskSource, Query(description="origin of the mask; only `painted` changes painted points")
    ] = "imported",
    id: Annotated[Uuid | None, Query(description="the edit's UUID")] = None,
) -> MaskEdit:
    """Label the points that a camera sees in a mask, as one edit.

    The body is a PNG (8-bit index or grey, 16-bit grey) or ``.npy`` array, of the picture's size.
    Pixels of value 255 (of 16 bits: 65535) that ``classes`` does not name say nothing.
    Points near a border of the mask stay as they are if the points around them do not decide.
    """
    size = workspace.masks.size(seq, i, camera)
    mask = _mask(request, body, size)
    meant = None if classes is None else parse_classes(classes)
    return workspace.masks.set_mask(
        seq, i, {camera: mask}, meant, author=who.author, edit=id, source=source
    )


@router.get(
    "/sequences/{seq}/frames/{i}/masks/{camera}",
    **needs_for_file("viewer", "The mask", *CONTENT, cached=True),
)
def get_mask(
    seq: SequenceId,
    i: FramePath,
    camera: CameraPath,
    workspace: Ws,
    format: Annotated[
        Literal["png", "npy", "picture"],
        Query(
            description="`png`: index or grey; `npy`: uint16, in which no point is 65535; "
            "`picture`: PNG of the labels that are shown, transparent elsewhere"
        ),
    ] = "png",
    if_none_match: Annotated[
        str | None, Header(description="`ETag` of a kept answer, which is confirmed by 304")
    ] = None,
) -> Response:
    """Return the label of each pixel of a camera's picture.

    A PNG with an index and the colours of labels; 255 (transparent): no point is seen there.  If a
    label id is over 254: 16-bit grey, in which no point is 65535.
    """
    from pointbrush.formats.masks.png import draw_mask, write_mask  # loads Pillow

    mask, revision = workspace.masks.mask_of(seq, i, camera)
    colors = {label.id: label.color for label in workspace.labels.palette(seq)}
    headers = {"ETag": etag(revision), "Cache-Control": REVALIDATED}
    if if_none_match is not None and etag(revision) in if_none_match:
        return Response(status_code=304, headers=headers)
    if format == "picture":
        shown = {label.id: label.color for label in workspace.labels.palette(seq) if label.visible}
        return Response(draw_mask(mask, shown), media_type=PNG, headers=headers)
    if format == "png":
        return Response(write_mask(mask, colors), media_type=PNG, headers=headers)
    return Response(npy.of_array(mask), media_type=npy.MEDIA_TYPE, headers=headers)


@router.post(
    "/sequences/{seq}/frames/{i}/masks/{camera}/predict", **needs("annotator", 404, 409, 503)
)
def predict_mask(
    seq: SequenceId, i: FramePath, camera: CameraPath, body: MaskPrompt, workspace: Ws, who: Caller
) -> MaskEdit:
    """Label the points that a camera sees in the masks of a model; one edit of provenance 4."""
    return workspace.masks.predict(seq, i, camera, body, author=who.author)


def _mask(request: Request, body: bytearray, size: tuple[int, int]) -> NDArray[Any]:
    from pointbrush.formats.masks.png import read_mask  # loads Pillow

    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind == npy.MEDIA_TYPE:
        return npy.parse_image(body, (np.dtype(np.uint8), np.dtype(np.uint16)), size)
    return read_mask("mask", bytes(body), size)


def parse_classes(text: str) -> Classes:
    """Return label ids or names by value; raises BadInputError."""
    try:
        given = json.loads(text)
        pairs = {int(value): meant for value, meant in given.items()}
    except (ValueError, AttributeError, RecursionError):
        raise BadInputError(
            f'classes: expected JSON as {{"1": "car", "2": 7}}, got {text[:60]!r}'
        ) from None
    for value, meant in pairs.items():
        if not 0 <= value < 1 << 16 or isinstance(meant, bool) or not isinstance(meant, int | str):
            raise BadInputError(
                "classes: expected values 0 to 65535 with a label id or name each, got "
                f"{value}: {str(meant)[:60]!r}"
            )
    return pairs
