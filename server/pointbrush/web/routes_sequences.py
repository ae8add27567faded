"""Recordings: list, manifest, change, delete, import."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, Query, Request, Response
from fastapi.concurrency import run_in_threadpool
from pydantic import TypeAdapter, ValidationError
from starlette.datastructures import FormData, UploadFile
from starlette.exceptions import HTTPException

from pointbrush.errors import BadInputError
from pointbrush.formats import format_named, format_names
from pointbrush.jobs import Job
from pointbrush.streaming.encoding import describe
from pointbrush.streaming.status import MalformedError
from pointbrush.web.auth import Caller, Gate
from pointbrush.web.context import SequenceId, Ws
from pointbrush.web.problems import responses
from pointbrush.web.schemas import (
    FloorBody,
    Name,
    SequenceOut,
    SequencePatch,
)
from pointbrush.web.schemas_work import ImportBody, JobOut
from pointbrush.web.upload_files import Saved, save
from pointbrush.work.roots import allowed
from pointbrush.work.uploads import Uploads
from pointbrush.workspace import Workspace

DeletedQuery = Annotated[bool, Query(description="those that can be restored, newest first")]

router = APIRouter(tags=["sequences"])
MAX_FILES = 20_000
MAX_FIELD = 64 * 1024
COPY_BLOCK = 1 << 20


def _out(workspace: Workspace, sequence: str) -> SequenceOut:
    workspace.recording(sequence)
    return SequenceOut.listed(workspace.entry(sequence))


@router.get("/sequences", responses=responses())
def list_sequences(workspace: Ws, *, deleted: DeletedQuery = False) -> list[SequenceOut]:
    """All recordings, by name, also damaged ones; or those deleted that can be restored."""
    if deleted:
        return [SequenceOut.removed(entry) for entry in workspace.deleted_sequences()]
    return [SequenceOut.listed(entry) for entry in workspace.listing()]


@router.get("/sequences/{seq}", responses=responses(404))
def get_sequence(seq: SequenceId, workspace: Ws) -> SequenceOut:
    """One recording's manifest."""
    return _out(workspace, seq)


@router.patch("/sequences/{seq}", responses=responses(404, 409, 413))
def patch_sequence(seq: SequenceId, patch: SequencePatch, workspace: Ws) -> SequenceOut:
    """Change a recording's name, rate or the transform that stands it on the floor."""
    fields = {name: value for name, value in patch.model_dump().items() if value is not None}
    if patch.room is not None:
        fields["room"] = np.array(patch.room).reshape(4, 4)
    if fields:
        workspace.update_sequence(seq, **fields)
    return _out(workspace, seq)


@router.post("/sequences/{seq}/floor", responses=responses(404, 409, 413))
def stand_on_floor(seq: SequenceId, body: FloorBody, workspace: Ws) -> SequenceOut:
    """Stand a recording on the surface that rays point at; one is enough, three level it better."""
    samples = [sample.model_dump() for sample in body.samples]
    workspace.stand_on_floor(seq, body.frame, samples)
    return _out(workspace, seq)


@router.delete("/sequences/{seq}/floor", responses=responses(404, 409))
def reset_floor(seq: SequenceId, workspace: Ws) -> SequenceOut:
    """Stand a recording as the import found it."""
    workspace.reset_floor(seq)
    return _out(workspace, seq)


@router.delete("/sequences/{seq}", status_code=204, responses=responses(404, 409))
def delete_sequence(seq: SequenceId, workspace: Ws) -> None:
    """Delete a recording with everything painted on it; it can be restored for 30 days."""
    workspace.delete_sequence(seq)


@router.post("/sequences/{seq}/restore", responses=responses(404, 409))
def restore_sequence(seq: SequenceId, workspace: Ws) -> SequenceOut:
    """Bring a deleted recording back with all its labels, by its id or its ``identity``.

    Of several with this id the last one deleted.  If the id is taken meanwhile, it gets another.
    """
    return SequenceOut.listed(workspace.entry(workspace.restore_sequence(seq)))


IMPORT_BODY: dict[str, Any] = {
    "requestBody": {
        "required": True,
        "content": {
            "application/json": {"schema": ImportBody.model_json_schema()},
            "multipart/form-data": {
                "schema": {
                    "type": "object",
                    "required": ["files"],
                    "properties": {
                        "files": {
                            "type": "array",
                            "minItems": 1,
                            "items": {"type": "string", "format": "binary"},
                        },
                        "name": {"type": "string", "pattern": r"^[^\x00-\x1f\x7f]{1,200}$"},
                        "fps": {"type": "string", "pattern": r"^[1-9][0-9]{0,2}(\.[0-9]{1,6})?$"},
                        "format": {"type": "string", "enum": format_names()},
                        "drop_invalid": {"type": "string", "enum": ["true", "false"]},
                    },
                }
            },
        },
    }
}


@router.post(
    "/sequences",
    status_code=202,
    responses=responses(404, 409, 413, 415),
    openapi_extra=IMPORT_BODY,
)
async def import_sequence(
    request: Request, response: Response, workspace: Ws, who: Caller
) -> JobOut:
    """Import from a path under the allowed roots (JSON), or from uploaded files (multipart)."""
    await run_in_threadpool(workspace.require_importable)
    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind == "multipart/form-data":
        job = await _import_upload(request, workspace, who.author)
    elif kind not in ("", "application/json"):
        raise HTTPException(415, f"expected JSON or multipart/form-data, got {kind[:80]!r}")
    else:
        body = _parse(ImportBody, await request.body())
        gate: Gate = request.app.state.gate
        roots = workspace.import_roots(own=gate.is_own(request, who))
        job = await run_in_threadpool(_import_path, workspace, body, who.author, roots)
    response.headers["Location"] = f"/api/v1/jobs/{job.id}"
    return JobOut.of(job)


def _parse(model: type[ImportBody], body: bytes) -> ImportBody:
    try:
        return model.model_validate_json(body)
    except ValidationError as error:
        found = error.errors()
        kind = MalformedError if found[0]["type"] == "json_invalid" else BadInputError
        raise kind(describe(found)) from None


def _import_path(workspace: Workspace, body: ImportBody, owner: str, roots: Sequence[Path]) -> Job:
    return workspace.import_paths(
        allowed(body.path, roots),
        name=body.name,
        fps=body.fps,
        file_format=body.format,
        drop_invalid=body.drop_invalid,
        roots=roots,
        owner=owner,
    )


async def _import_upload(request: Request, workspace: Workspace, owner: str) -> Job:
    uploads: Uploads = request.app.state.uploads
    folder = uploads.new()
    try:
        async with request.form(
            max_files=MAX_FILES, max_fields=16, max_part_size=MAX_FIELD
        ) as form:
            saved = await run_in_threadpool(_save, form, folder)
            fields = {"name": saved.name, **_fields(form)}
        return await run_in_threadpool(
            lambda: workspace.import_paths(saved.paths, cleanup=folder, owner=owner, **fields)
        )
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise


def _save(form: FormData, folder: Path) -> Saved:
    return save([file for file in form.getlist("files") if isinstance(file, UploadFile)], folder)


_NAME: TypeAdapter[str] = TypeAdapter(Name)


def _fields(form: FormData) -> dict[str, Any]:
    fields: dict[str, Any] = {}
    for name, key in (("name", "name"), ("fps", "fps"), ("format", "file_format")):
        value = form.get(name)
        if isinstance(value, str) and value:
            fields[key] = value
    with contextlib.suppress(KeyError):
        fields["name"] = _plain_name(fields["name"])
    with contextlib.suppress(KeyError):
        fields["fps"] = _rate(fields["fps"])
    if "file_format" in fields:
        format_named(fields["file_format"])
    drop = form.get("drop_invalid") or "false"
    if drop not in ("true", "false"):
        raise BadInputError(f"drop_invalid: expected true or false, got {str(drop)[:40]!r}")
    fields["drop_invalid"] = drop == "true"
    return fields


def _plain_name(text: str) -> str:
    try:
        return _NAME.validate_python(text)
    except ValidationError:
        raise BadInputError(
            f"name: expected 1 to 200 printable characters, got {text[:80]!r}"
        ) from None


def _rate(text: str) -> float:
    try:
        rate = float(text)
    except ValueError:
        rate = 0.0
    if not 0 < rate <= 1000:
        raise BadInputError(f"fps: expected a number above 0 and up to 1000, got {text[:40]!r}")
    return rate
