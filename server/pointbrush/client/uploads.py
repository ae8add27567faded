"""Calls that upload files of this machine, or name a path on the server."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

from typing_extensions import TypedDict

from pointbrush.client.steps import Request
from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.values.imports import ImportedBoxes, Sensors


class UploadFile:
    """A file that is open only while it is sent, since a process can open only some files."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file: BinaryIO | None = None

    def tell(self) -> int:
        """Return the position in the file."""
        return 0 if self._file is None else self._file.tell()

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Set the position, and return it; the end does not open the file."""
        if whence == os.SEEK_END:
            return self._path.stat().st_size + offset
        self._close()
        if offset:
            self._file = self._path.open("rb")
            self._file.seek(offset)
        return offset

    def read(self, size: int = -1) -> bytes:
        """Return the next bytes; the file is closed at its end."""
        if self._file is None:
            self._file = self._path.open("rb")
        block = self._file.read(size)
        if not block:
            self._close()
        return block

    def _close(self) -> None:
        if self._file is not None:
            self._file.close()
            self._file = None


Parts = list[tuple[str, tuple[str, Any]]]
AnyPath = str | os.PathLike[str]
"""A path of this machine."""
Files = AnyPath | Sequence[AnyPath]
"""Files and folders of this machine, or one of them."""


class ImportKeywords(TypedDict, total=False):
    """Corrections of an import's files, the fields of ``ImportOptions``; None: as in the files."""

    name: str | None
    fps: float | None
    format: str | None
    columns: str | Sequence[str] | None
    delimiter: str | None
    decimal_comma: bool | None
    scale: float | None
    up: str | None
    topic: str | Sequence[str] | None
    sensor: str | Sequence[str] | None
    sensors: Sensors | None
    extrinsics: str | None
    clock_offset: str | Sequence[str] | None
    poses: str | None
    by_order: bool
    drop_invalid: bool
    project: str


class LabelKeywords(TypedDict, total=False):
    """Choices on how label files are read, the fields of ``LabelImportOptions``."""

    format: str | None
    no_ground: bool
    by_order: bool
    allow_empty: bool
    field: str | None
    boxes: ImportedBoxes
    map: str | None


def parts_of(given: Files) -> Parts:
    """Return files, and files in folders with their relative paths, as parts of an upload.

    Hidden files are left out.  Raises NotFoundError; BadInputError for a folder without files.
    """
    found: Parts = []
    for each in [given] if isinstance(given, str | os.PathLike) else given:
        path = Path(each)
        if not path.exists():
            raise NotFoundError(
                f"files: expected a file or folder of this machine, got {path}; server_path= names "
                "a path on the server"
            )
        if path.is_file():
            files = {path.name: path}
        else:
            top = path.resolve().name
            inside = [(file.relative_to(path), file) for file in sorted(path.rglob("*"))]
            files = {
                f"{top}/{place.as_posix()}": file
                for place, file in inside
                if file.is_file() and not any(part.startswith(".") for part in place.parts)
            }
        if not files:
            raise BadInputError(f"files: expected files in the folder, got none in {path}")
        found += [("files", (name, UploadFile(file))) for name, file in files.items()]
    return found


def upload(
    path: str,
    files: Files | None,
    options: Mapping[str, Any],
    server_path: AnyPath | None = None,
    *,
    query: dict[str, str] | None = None,
    patience: float = 0.0,
) -> Request:
    """Return the call that uploads ``files``, or that names a path on the server.

    ``options`` are sent as JSON or in the form; options that are None are left out.  Raises
    BadInputError unless exactly one of ``files`` and ``server_path`` is given.
    """
    if (files is None) == (server_path is None):
        raise BadInputError(
            "files: expected files of this machine, or server_path= with a path on the server, got "
            + ("neither" if files is None else "both")
        )
    given = {name: value for name, value in options.items() if value is not None}
    if files is None:
        body: dict[str, Any] = {"json": {"path": os.fspath(server_path or ""), **given}}
    else:
        texts = {name: _text(value) for name, value in given.items()}
        body = {"files": parts_of(files), "data": texts}
    return Request("POST", path, {**body, "params": query or {}}, patience=patience)


def _text(value: Any) -> str:
    """Return the text of an option in a form."""
    if isinstance(value, str):
        return value
    return ",".join(value) if isinstance(value, list | tuple) else json.dumps(value)
