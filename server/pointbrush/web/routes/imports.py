"""Imports and their previews, from paths of the server's machine or uploaded files."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, TypeVar

from fastapi import Path as PathParameter
from fastapi import Request, Response
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import JSONResponse

from pointbrush.database.project_tables import FIRST
from pointbrush.errors import BadInputError
from pointbrush.formats import format_names
from pointbrush.formats.inside import allowed
from pointbrush.formats.sensors.extrinsics import pairs_of
from pointbrush.formats.tables.corrections import Corrections, parse_corrections
from pointbrush.formats.tables.names import DELIMITERS, POSES
from pointbrush.settings.definitions import values_of
from pointbrush.values.base import Patterns
from pointbrush.values.imports import (
    Entry,
    FolderImport,
    FolderRequest,
    ImportOptions,
    ImportPreview,
    ImportRequest,
)
from pointbrush.values.jobs import Job
from pointbrush.values.kinds import VISIBLE
from pointbrush.web.context import ProjectId, Ws, one_of
from pointbrush.web.problems import problem_of
from pointbrush.web.security.auth import Caller, Gate, TheGate, resource
from pointbrush.web.security.roles import needs
from pointbrush.web.upload_files import (
    KeptUploads,
    Upload,
    described,
    files_of,
    is_form,
    parse_form,
    parse_json,
    relative_path,
    save,
    uploaded,
)
from pointbrush.work.imports.requests import bytes_of, recordings_in
from pointbrush.workspace import Workspace

router = resource("imports")
MAX_FIELD = 64 * 1024
MAX_FIELDS = 32
WORDS = ("drop_invalid", "decimal_comma", "by_order")
TEXTS = {
    "columns": "x,y,z,-,intensity", "delimiter": "semicolon", "up": "-y", "sensors": "all",
    "sensor": "left=left,right=right", "extrinsics": "rig.json", "clock_offset": "right=0.01",
}  # fmt: skip
"""Options of a form without a pattern, with an example."""
UploadPath = Annotated[str, PathParameter(pattern="^[0-9a-f]{32}$", description="upload id")]

PATTERNS = Patterns(format=one_of(format_names()), delimiter=one_of(DELIMITERS) + r"|^[^\x00]$")
# The names of formats come from plug-ins too.
JSON_BODY: Any = Annotated[ImportRequest, PATTERNS]
FORM_BODY: Any = Annotated[ImportOptions, PATTERNS]
IMPORT_BODY = described(
    JSON_BODY,
    {
        "name": {"type": "string", "pattern": f"^{VISIBLE}{{1,200}}$"},
        "fps": {"type": "string", "pattern": r"^[1-9][0-9]{0,2}(\.[0-9]{1,6})?$"},
        "scale": {"type": "string", "pattern": r"^[1-9](\.[0-9]{1,6})?$"},
        "format": {"type": "string", "enum": format_names()},
        "id": {"type": "string", "format": "uuid"},
        "poses": {"type": "string", "enum": [*POSES]},
        "project": {"type": "string", "enum": [FIRST]},
        **{word: {"type": "string", "enum": ["true", "false"]} for word in WORDS},
        **{name: {"type": "string", "enum": [example]} for name, example in TEXTS.items()},
    },
)


@dataclass(frozen=True)
class Wanted:
    """A requested import; ``upload``: its uploaded files, if any."""

    paths: list[Path]
    options: ImportOptions
    roots: tuple[Path, ...] = ()
    upload: Upload | None = None

    @property
    def of_workspace(self) -> dict[str, Any]:
        """Fields of an ``ImportRequest``; raises BadInputError."""
        options = self.options
        name = options.name or (self.upload.name if self.upload else None)
        return {
            "name": name, "fps": options.fps, "roots": self.roots,
            "chosen": parse_corrections(values_of(Corrections, options)),
            "project": options.project,
        }  # fmt: skip


@router.post(
    "/sequences",
    status_code=202,
    **needs("manager", 404, 409, 413, 415),
    openapi_extra=IMPORT_BODY,
)
async def import_sequence(request: Request, response: Response, workspace: Ws, who: Caller) -> Job:
    """Import from a path under the allowed roots (JSON), or from uploaded files (multipart)."""
    await run_in_threadpool(workspace.library.require_writable)
    wanted = await _wanted(request, workspace, who)
    kept: KeptUploads = request.app.state.kept_uploads

    def start() -> Job:
        upload = wanted.upload
        job = workspace.imports.begin(
            wanted.paths,
            upload=upload.folder if upload else None,
            owner=who.author,
            job_id=wanted.options.id,
            **wanted.of_workspace,
        )
        if upload is not None:
            kept.forget(upload)
        return job

    try:
        job = await run_in_threadpool(start)
    except BaseException:
        if wanted.upload is not None and not wanted.upload.kept:
            shutil.rmtree(wanted.upload.folder, ignore_errors=True)
        raise
    response.headers["Location"] = f"/api/v1/jobs/{job.id}"
    return job


@router.post("/imports/entries", **needs("manager", 404, 413))
def list_entries(
    body: FolderRequest, workspace: Ws, who: Caller, gate: TheGate, request: Request
) -> list[Entry]:
    """List the entries of a folder under the allowed roots, each of which can be a recording."""
    roots = workspace.import_roots(own=gate.is_own(request, who))
    return [
        Entry(entry.name, str(entry), bytes_of(entry))
        for folder in allowed(body.path, roots)
        for entry in recordings_in(folder)
        if entry.name.isprintable()  # other names cannot be written as JSON
    ]


@router.post("/projects/{p}/imports", status_code=202, **needs("manager", 404, 413))
def import_each(
    p: ProjectId, body: FolderImport, workspace: Ws, who: Caller, gate: TheGate, request: Request
) -> list[Job]:
    """Import each entry of a folder under the allowed roots as a recording of a project."""
    workspace.library.require_writable()
    roots = workspace.import_roots(own=gate.is_own(request, who))
    (folder,) = allowed(body.path, roots)
    options: dict[str, Any] = {"fps": body.fps, "roots": roots, "project": p, "owner": who.author}
    return [workspace.imports.begin([each], **options) for each in recordings_in(folder)]


@router.post(
    "/imports/preview",
    **needs("manager", 404, 409, 413, 415),
    openapi_extra=IMPORT_BODY,
    response_model=ImportPreview,
)
async def preview_import(
    request: Request, workspace: Ws, who: Caller
) -> ImportPreview | JSONResponse:
    """Preview an import without writing anything.

    The server keeps uploaded files for an hour, also if the answer is an error: ``upload`` of the
    answer names them in later previews and in the import.
    """
    await run_in_threadpool(workspace.library.require_writable)
    wanted = await _wanted(request, workspace, who)
    upload = wanted.upload
    if upload is not None:
        kept: KeptUploads = request.app.state.kept_uploads
        upload = await run_in_threadpool(kept.keep, upload)
    named = None if upload is None else upload.id
    try:
        found = await run_in_threadpool(
            lambda: workspace.imports.preview(wanted.paths, **wanted.of_workspace)
        )
    except BadInputError as error:
        if named is None:
            raise
        hidden = BadInputError(workspace.paths.hide(str(error)))
        return problem_of(hidden, {"upload": named})
    return ImportPreview.of(found, upload=named)


@router.delete("/imports/{upload}", status_code=204, **needs("manager", 404))
def drop_upload(upload: UploadPath, request: Request, who: Caller) -> None:
    """Remove the files that were uploaded for a preview."""
    kept: KeptUploads = request.app.state.kept_uploads
    found = kept.find(upload, who.author)
    kept.forget(found)
    shutil.rmtree(found.folder, ignore_errors=True)


async def _wanted(request: Request, workspace: Workspace, who: Caller) -> Wanted:
    if is_form(request):
        return await _uploaded(request, who.author)
    body = parse_json(JSON_BODY, await request.body())
    none, both = (body.path, body.upload) == (None, None), None not in (body.path, body.upload)
    if both or (none and not body.sensor):
        raise BadInputError(
            f"path: expected a path or an upload, got {'both' if both else 'none of them'}"
        )
    if body.upload is not None:
        kept: KeptUploads = request.app.state.kept_uploads
        upload = kept.find(body.upload, who.author)
        return Wanted(list(upload.paths), _within(body, upload), upload=upload)
    gate: Gate = request.app.state.gate
    roots = workspace.import_roots(own=gate.is_own(request, who))
    paths = [] if body.path is None else await run_in_threadpool(allowed, body.path, roots)
    base = next((path if path.is_dir() else path.parent for path in paths), Path())

    def find(option: str, given: str) -> Path:
        (found,) = allowed(given if option == "poses" else str(base / given), roots)
        return found

    options = await run_in_threadpool(_with_paths, body, find)
    named = [Path(pair.partition("=")[2]) for pair in options.sensor or ()]
    return Wanted(paths or named, options, roots)


Options = TypeVar("Options", bound=ImportOptions)


def _with_paths(options: Options, find: Callable[[str, str], Path]) -> Options:
    """Return options with each path that they name replaced by the result of ``find``."""
    changed: dict[str, Any] = {}
    if options.poses not in (None, *POSES):
        changed["poses"] = str(find("poses", options.poses))
    if options.extrinsics is not None:
        changed["extrinsics"] = str(find("extrinsics", options.extrinsics))
    if options.sensor:
        pairs = pairs_of("sensor", options.sensor)
        changed["sensor"] = tuple(f"{name}={find('sensor', pairs[name])}" for name in pairs)
    return replace(options, **changed)


def _within(options: Options, upload: Upload) -> Options:
    """Return options with the paths that they name replaced by those in the upload."""

    def find(option: str, given: str) -> Path:
        place = relative_path(given)
        inside = [upload.folder / place, *upload.folder.glob(f"*/{place}")]
        found = next(
            (p for p in inside if p.is_file() or (option == "sensor" and p.is_dir())), None
        )
        if found is None:
            also = f"{', '.join(POSES)} or " if option == "poses" else ""
            raise BadInputError(f"{option}: expected {also}an uploaded file, got {given[:80]!r}")
        return found

    return _with_paths(options, find)


async def _uploaded(request: Request, owner: str) -> Wanted:
    fields = {"max_fields": MAX_FIELDS, "max_part_size": MAX_FIELD}
    async with uploaded(request, **fields) as (form, folder):
        options = parse_form(FORM_BODY, form)
        saved = await run_in_threadpool(save, files_of(form), folder)
        upload = Upload("", owner, folder, tuple(saved.paths), saved.name)
        return Wanted(saved.paths, _within(options, upload), upload=upload)
