"""Import of labels of other tools."""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any, get_args

from fastapi import Depends, Query, Request, Response
from fastapi.concurrency import run_in_threadpool

from pointbrush.formats.inside import allowed
from pointbrush.formats.tables.class_maps import parse_map
from pointbrush.formats.tables.names import LABEL_FORMATS
from pointbrush.settings.definitions import values_of
from pointbrush.values.base import Patterns
from pointbrush.values.edits import Edit
from pointbrush.values.imports import (
    ImportedBoxes,
    LabelImportOptions,
    LabelImportRequest,
    LabelOptions,
)
from pointbrush.values.jobs import Job
from pointbrush.web import npy
from pointbrush.web.context import EditId, SequenceId, Ws, body_within, one_of
from pointbrush.web.problems import BINARY
from pointbrush.web.routes.frames import Written
from pointbrush.web.security.auth import Caller, Gate, resource
from pointbrush.web.security.roles import needs
from pointbrush.web.upload_files import (
    described,
    files_of,
    is_form,
    parse_form,
    parse_json,
    save,
    uploaded,
)
from pointbrush.work.annotate.layers import require_layer
from pointbrush.workspace import Workspace

router = resource("annotations")
MAX_FIELD = 1 << 20
DryRun = Annotated[bool, Query(description="report the labels without writing anything")]


PATTERNS = Patterns(format=one_of(LABEL_FORMATS))
JSON_BODY: Any = Annotated[LabelImportRequest, PATTERNS]
FORM_BODY: Any = Annotated[LabelImportOptions, PATTERNS]
IMPORT_BODY = described(
    JSON_BODY,
    {
        "format": {"type": "string", "enum": list(LABEL_FORMATS)},
        "no_ground": {"type": "string", "enum": ["true", "false"]},
        "by_order": {"type": "string", "enum": ["true", "false"]},
        "allow_empty": {"type": "string", "enum": ["true", "false"]},
        "field": {"type": "string", "maxLength": 200},
        "boxes": {"type": "string", "enum": list(get_args(get_args(ImportedBoxes)[0]))},
        "id": {"type": "string", "format": "uuid"},
    },
)


@router.post(
    "/sequences/{seq}/annotations",
    status_code=202,
    **needs("annotator", 404, 409, 413, 415),
    openapi_extra=IMPORT_BODY,
)
async def import_labels(
    seq: SequenceId,
    request: Request,
    response: Response,
    workspace: Ws,
    who: Caller,
    *,
    dry_run: DryRun = False,
) -> Job:
    """Import labels of other tools as one edit; the result of the job counts labels and points."""
    if is_form(request):
        job = await _uploaded(request, workspace, seq, who.author, dry_run=dry_run)
    else:
        body = parse_json(JSON_BODY, await request.body())
        gate: Gate = request.app.state.gate
        roots = workspace.import_roots(own=gate.is_own(request, who))
        (place,) = await run_in_threadpool(allowed, body.path, roots)
        more = _more(body) | {"dry_run": dry_run, "roots": roots}
        begin = partial(workspace.imports.begin_labels, seq, place, who.author, **more)
        job = await run_in_threadpool(begin)
    response.headers["Location"] = f"/api/v1/jobs/{job.id}"
    return job


async def arrays_body(request: Request) -> bytearray:
    """Read the body, within the server's limit."""
    limit: int = request.app.state.workspace.settings.max_body
    return await body_within(request, limit, "annotations")


@router.put(
    "/sequences/{seq}/annotations",
    **needs("annotator", 404, 409, 413),
    openapi_extra={"requestBody": {"required": True, "content": {"application/zip": BINARY}}},
)
def put_annotations(
    seq: SequenceId,
    body: Annotated[bytearray, Depends(arrays_body)],
    workspace: Ws,
    who: Caller,
    layer: Written = "label",
    id: EditId = None,
) -> Edit:
    """Replace a layer in several frames, as one edit: ``.npz`` with an array ``I`` of frame I."""
    counts = workspace.recording(seq).manifest.points
    arrays = npy.parse_by_frame(body, require_layer(layer), counts)
    return workspace.annotations.put_many(seq, arrays, author=who.author, layer=layer, edit=id)


def _more(options: LabelImportOptions) -> dict[str, Any]:
    """Arguments of ``Imports.begin_labels`` that are the caller's choice; raises BadInputError."""
    names = {} if options.map is None else parse_map("map", options.map)
    return values_of(LabelOptions, options) | {"names": names, "job_id": options.id}


async def _uploaded(
    request: Request, workspace: Workspace, seq: str, author: str, *, dry_run: bool
) -> Job:
    async with uploaded(request, max_fields=16, max_part_size=MAX_FIELD) as (form, folder):
        more = _more(parse_form(FORM_BODY, form)) | {"dry_run": dry_run, "upload": folder}
        await run_in_threadpool(save, files_of(form), folder)
        begin = partial(workspace.imports.begin_labels, seq, folder, author, **more)
        return await run_in_threadpool(begin)
