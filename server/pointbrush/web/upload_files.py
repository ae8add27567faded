"""Calls that take uploaded files in a form, or a JSON body with the same options.

Names of files are checked, and folders stay as they were chosen.  Files of a preview are kept for
an hour or until they are imported.
"""

from __future__ import annotations

import shutil
import threading
import time
from collections.abc import AsyncIterator, Callable, Collection, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError
from starlette.datastructures import FormData, UploadFile
from starlette.exceptions import HTTPException
from starlette.requests import Request

from pointbrush.errors import BadInputError, NotFoundError, TooLargeError
from pointbrush.streaming.shared.status import MalformedError
from pointbrush.values.base import Body
from pointbrush.values.validation import describe
from pointbrush.work.imports.uploads import Uploads

Model = TypeVar("Model", bound=Body)
MAX_FILES = 20_000
"""Most files of a form."""
COPY_BLOCK = 1 << 20
TOGETHER = "upload"
"""The folder of several chosen folders, in the upload's folder."""
KEPT_SECONDS = 3600.0
"""Time for which files of a preview are kept."""
MOST_KEPT = 16
"""Most uploads that a server keeps; the oldest are removed."""


def is_form(request: Request) -> bool:
    """Return whether a body is a form with files, not JSON; raises HTTPException for others."""
    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind not in ("", "application/json", "multipart/form-data"):
        raise HTTPException(415, f"expected JSON or multipart/form-data, got {kind[:80]!r}")
    return kind == "multipart/form-data"


@asynccontextmanager
async def uploaded(request: Request, **limits: int) -> AsyncIterator[tuple[FormData, Path]]:
    """Read a form; yield it with the path of a new folder for its files, removed after an error.

    ``limits`` of the form, see Starlette.
    """
    uploads: Uploads = request.app.state.uploads
    folder = uploads.new()
    try:
        async with request.form(max_files=MAX_FILES, **limits) as form:
            yield form, folder
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise


def files_of(form: FormData) -> list[UploadFile]:
    """Return the files of a form."""
    return [file for file in form.getlist("files") if isinstance(file, UploadFile)]


def described(model: Any, options: dict[str, Any]) -> dict[str, Any]:
    """Describe both bodies in OpenAPI: ``model`` as JSON, ``options`` of a form with ``files``."""
    files = {"type": "array", "minItems": 1, "items": {"type": "string", "format": "binary"}}
    form = {"type": "object", "required": ["files"], "properties": {"files": files, **options}}
    return {
        "requestBody": {
            "required": True,
            "content": {
                "application/json": {"schema": TypeAdapter(model).json_schema()},
                "multipart/form-data": {"schema": form},
            },
        }
    }


def parse_json(model: type[Model], body: bytes) -> Model:
    """Validate a JSON body; raises MalformedError for no JSON, BadInputError for other fields."""
    try:
        found: Model = TypeAdapter(model).validate_json(body)
        return found
    except ValidationError as error:
        errors = error.errors()
        kind = MalformedError if errors[0]["type"] == "json_invalid" else BadInputError
        raise kind(describe(errors)) from None


def parse_form(model: type[Model], form: FormData) -> Model:
    """Validate the options of a form, which are all text; raise BadInputError."""
    adapter: TypeAdapter[Model] = TypeAdapter(model)
    values = {}
    for name, schema in adapter.json_schema()["properties"].items():
        text = form.get(name)
        if isinstance(text, str) and text:
            values[name] = _of_text(name, text, {each["type"] for each in _options(schema)})
    try:
        return adapter.validate_python(values)
    except ValidationError as error:
        raise BadInputError(describe(error.errors())) from None


def _options(schema: dict[str, Any]) -> list[dict[str, Any]]:
    options: list[dict[str, Any]] = schema.get("anyOf", [schema])
    return options


def _of_text(name: str, text: str, kinds: Collection[str]) -> Any:
    if "boolean" in kinds:
        if text not in ("true", "false"):
            raise BadInputError(f"{name}: expected true or false, got {text[:40]!r}")
        return text == "true"
    if "number" not in kinds:
        return text
    try:
        return float(text)
    except ValueError:
        raise BadInputError(f"{name}: expected a number, got {text[:40]!r}") from None


@dataclass(frozen=True)
class NameLimits:
    """Bounds on the names of one upload."""

    depth: int = 16
    """Folders above a file, and the file."""
    part_bytes: int = 200
    path_bytes: int = 1000
    folders: int = 2000


LIMITS = NameLimits()
PORTS = {f"{port}{number}" for port in ("com", "lpt") for number in range(10)}
DEVICES = {"con", "prn", "aux", "nul", *PORTS}
"""Names that mean a device on Windows, with any ending."""
RESERVED = set('<>:"|?*')
"""Characters that Windows does not allow in names."""


@dataclass(frozen=True)
class Saved:
    """Files of an import: paths, and the name of the chosen folder, if any."""

    paths: list[Path]
    name: str | None


def relative_path(given: str, limits: NameLimits = LIMITS) -> PurePosixPath:
    """Return an uploaded file's path below its chosen folder, "/" between its parts.

    Raises BadInputError for paths that are absolute, contain "..", or are hidden, reserved,
    unprintable, too long or too deep.
    """
    parts = given.replace("\\", "/").split("/")
    if len(parts) > limits.depth or len(given.encode()) > limits.path_bytes:
        raise BadInputError(
            f"files: expected paths of at most {limits.depth} parts and {limits.path_bytes} bytes, "
            f"got {given[:80]!r}"
        )
    if not all(_is_plain(part, limits) for part in parts):
        raise BadInputError(
            "files: expected a plain file name, with the folders it lies in, none of them hidden, "
            f"reserved or '..', got {given[:80]!r}"
        )
    return PurePosixPath(*parts)


def _is_plain(part: str, limits: NameLimits) -> bool:
    return (
        0 < len(part.encode()) <= limits.part_bytes
        and part.isprintable()
        and not part.startswith(".")
        and not part.endswith((".", " "))
        and not RESERVED & set(part)
        and part.partition(".")[0].strip().lower() not in DEVICES
    )


def save(uploads: Sequence[UploadFile], folder: Path, limits: NameLimits = LIMITS) -> Saved:
    """Write uploaded files into a new ``folder``, in the folders of their names.

    All names are checked before anything is written.  Raises BadInputError, TooLargeError.
    """
    if not uploads:
        raise BadInputError("files: expected at least one file in the field 'files', got none")
    places = [relative_path(upload.filename or "", limits) for upload in uploads]
    folders = {parent for place in places for parent in place.parents[:-1]}
    if len(folders) > limits.folders:
        raise TooLargeError(f"files: expected at most {limits.folders} folders, got {len(folders)}")
    both = sorted(str(place) for place in set(places) & folders)
    if both:
        raise BadInputError(f"files: expected {both[0][:80]!r} as a file or a folder, got both")
    tops = {place.parts[0] for place in places}
    target = folder / TOGETHER if folders and len(tops) > 1 else folder
    folder.mkdir(parents=True)
    for each in sorted(folders):
        (target / each).mkdir(parents=True, exist_ok=True)
    target.mkdir(exist_ok=True)
    files = [_write(upload, target / place) for upload, place in zip(uploads, places, strict=True)]
    if not folders:
        return Saved(files, None)
    top = min(tops)
    return Saved([target], None) if len(tops) > 1 else Saved([folder / top], top)


def _write(upload: UploadFile, wanted: Path) -> Path:
    path = unused(wanted)
    with path.open("xb") as target:
        shutil.copyfileobj(upload.file, target, COPY_BLOCK)
    return path


def unused(path: Path) -> Path:
    """Return ``path``, or the first of "name-2", "name-3", … that does not exist."""
    number, free = 1, path
    while free.exists():
        number += 1
        free = path.with_name(f"{path.stem}-{number}{path.suffix}")
    return free


@dataclass(frozen=True)
class Upload:
    """Uploaded files: ``paths`` within ``folder``; ``name``: the chosen folder's name, if any.

    ``id`` is "" until the files are kept, ``since`` the time from which they are.
    """

    id: str
    owner: str
    folder: Path
    paths: tuple[Path, ...]
    name: str | None
    since: float = 0.0

    @property
    def kept(self) -> bool:
        """Return whether the files are kept for another call."""
        return bool(self.id)


class KeptUploads:
    """The uploads that this server keeps; thread-safe."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._uploads: dict[str, Upload] = {}
        self._lock = threading.Lock()

    def keep(self, upload: Upload) -> Upload:
        """Keep files for later calls, and remove expired ones."""
        now = self._clock()
        # A folder's name ends in 32 random hex digits.
        kept = replace(upload, id=upload.folder.name.rpartition(".")[2], since=now)
        with self._lock:
            self._uploads.pop(kept.id, None)
            self._uploads[kept.id] = kept
            waiting = [u for u in self._uploads.values() if u.id != kept.id]
            surplus = waiting[: max(0, len(self._uploads) - MOST_KEPT)]
            old = {
                u.id: u for u in (*surplus, *(w for w in waiting if now - w.since > KEPT_SECONDS))
            }
            for each in old:
                del self._uploads[each]
        for left in old.values():
            shutil.rmtree(left.folder, ignore_errors=True)
        return kept

    def find(self, upload: str, owner: str) -> Upload:
        """Find an upload of ``owner``; raises NotFoundError."""
        with self._lock:
            found = self._uploads.get(upload)
        if found is None or found.owner != owner or self._clock() - found.since > KEPT_SECONDS:
            raise NotFoundError("upload: expected waiting files, there are none; send them again")
        return found

    def forget(self, upload: Upload) -> None:
        """Stop keeping files that the caller imports or removes."""
        with self._lock:
            self._uploads.pop(upload.id, None)
