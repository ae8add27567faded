"""Masks of the pictures of a frame: labels from masks, and masks from labels."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from fastapi import Depends, Path, Query, Request, Response
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.values.masks import MOST_BYTES, VOID, MaskEdit, MaskPrompt, MaskSource
from pointbrush.web import npy
from pointbrush.web.context import EditId, FramePath, IfNoneMatch, SequenceId, Ws, body_within, etag
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
"""Most characters of a query's classes; a URL has at most 64 kB."""


async def mask_body(request: Request) -> bytearray:
    """Return the body; raises TooLargeError for one that is too large for a mask."""
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
    id: EditId = None,
) -> MaskEdit:
    """Label the points that a camera sees in a mask, as one edit.

    The body is a PNG (8-bit index or grey, 16-bit grey) or ``.npy`` array, of the picture's size.
    The value 255 (of 16 bits: 65535) changes no points unless ``classes`` names it.
    Points near a border of the mask keep their label if the points around them do not decide.
    """
    size = workspace.masks.size(seq, i, camera)
    mask = _mask(request, body, size)
    labels = None if classes is None else parse_classes(classes)
    return workspace.masks.set_mask(
        seq, i, {camera: mask}, labels, author=who.author, edit=id, source=source
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
            description="`png`: index or grey; `npy`: uint16, 65535 without a point; "
            "`picture`: PNG of the visible labels, transparent elsewhere"
        ),
    ] = "png",
    if_none_match: IfNoneMatch = None,
) -> Response:
    """Return the label of each pixel of a camera's picture.

    A PNG of 8-bit indices with the colours of the labels; 255 (transparent): the camera sees no
    point there.  If a label id is over 254: 16-bit grey, 65535 without a point.
    """
    from pointbrush.formats.masks.png import write_mask, write_overlay  # loads Pillow

    mask, revision = workspace.masks.label_mask(seq, i, camera)
    headers = {"ETag": etag(revision), "Cache-Control": REVALIDATED}
    if if_none_match is not None and etag(revision) in if_none_match:
        return Response(status_code=304, headers=headers)
    if format == "npy":
        return Response(npy.of_array(mask), media_type=npy.MEDIA_TYPE, headers=headers)
    palette = workspace.labels.palette(seq)
    overlay = format == "picture"
    colors = {label.id: label.color for label in palette if label.visible or not overlay}
    content = write_overlay(mask, colors) if overlay else write_mask(mask, colors)
    return Response(content, media_type=PNG, headers=headers)


@router.post(
    "/sequences/{seq}/frames/{i}/masks/{camera}/predict", **needs("annotator", 404, 409, 503)
)
def predict_mask(
    seq: SequenceId, i: FramePath, camera: CameraPath, body: MaskPrompt, workspace: Ws, who: Caller
) -> MaskEdit:
    """Label the points behind the masks of a model, as one edit with the provenance 4."""
    return workspace.masks.predict(seq, i, camera, body, author=who.author)


def _mask(request: Request, body: bytearray, size: tuple[int, int]) -> NDArray[Any]:
    """Return the mask (H, W) in a body of PNG or ``.npy``; ``size``: width and height."""
    from pointbrush.formats.masks.png import read_mask  # loads Pillow

    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind == npy.MEDIA_TYPE:
        return npy.parse_image(body, (np.dtype(np.uint8), np.dtype(np.uint16)), size)
    return read_mask("mask", bytes(body), size)


def parse_classes(text: str) -> Classes:
    """Return label ids or names by value from JSON; raises BadInputError."""
    try:
        classes = {int(value): label for value, label in json.loads(text).items()}
    except (ValueError, AttributeError, RecursionError):
        raise BadInputError(
            f'classes: expected JSON as {{"1": "car", "2": 7}}, got {text[:60]!r}'
        ) from None
    for value, label in classes.items():
        if not 0 <= value <= VOID or isinstance(label, bool) or not isinstance(label, int | str):
            raise BadInputError(
                f"classes: expected values 0 to {VOID} with a label id or name each, got "
                f"{value}: {str(label)[:60]!r}"
            )
    return classes
