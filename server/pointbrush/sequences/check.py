"""Checksums of a sequence's files, and what is wrong with them."""

from __future__ import annotations

import json
from pathlib import Path

from pointbrush.errors import DamagedError, PointbrushError
from pointbrush.sequences.files import replace_file
from pointbrush.sequences.manifest import FILE, read_manifest
from pointbrush.sequences.octree.arrays import file_digest, read_array, read_layout
from pointbrush.sequences.other import FIELDS

CHECKSUMS = "checksums.json"
SENSOR = "sensor.json"
"""Facts about the recording's sensor that tracking keeps; the file may be missing."""


def encode_checksums(checksums: dict[str, str]) -> bytes:
    """The file: checksum by path in the sequence's folder."""
    return json.dumps(dict(sorted(checksums.items())), indent=0).encode()


def read_checksums(path: Path) -> dict[str, str] | None:
    """The checksums of the sequence in folder ``path``; None when they are missing or damaged."""
    try:
        content = json.loads((path / CHECKSUMS).read_bytes())
    except (OSError, ValueError):
        return None
    return content if isinstance(content, dict) else None


NO_CHECKSUMS = (
    f"{CHECKSUMS}: expected checksums in JSON, it is missing or damaged: changed bytes of the "
    "frames cannot be noticed"
)


def verify(path: Path, *, contents: bool = True) -> list[str]:
    """Problems of the sequence in folder ``path``, one sentence each; none when it is whole.

    Without ``contents`` no frame is read: the manifest must be whole and all files there.
    """
    problems = []
    try:
        read_manifest(path)
    except PointbrushError as error:
        problems.append(str(error))
    expected = read_checksums(path)
    if expected is None:
        return [*problems, NO_CHECKSUMS, *_unreadable(path)]
    for name, checksum in expected.items():
        file = path / name
        if not file.is_file():
            problems.append(f"{name}: expected a file, it is missing")
        elif contents and file_digest(file) != checksum:
            problems.append(f"{name}: expected checksum {checksum}, its bytes have changed")
    # Imports of before manifest version 4 noted no checksums of a source's further fields.
    extra = sorted(
        name for name in _files(path) - set(expected) if not name.startswith(f"{FIELDS}/")
    )
    problems += [f"{name}: expected no such file" for name in extra]
    return problems


def note_checksums(path: Path) -> bool:
    """Write checksums of what is there, if there are none and all of it can be read.

    Whether they were written.  Raises OSError.
    """
    try:
        read_manifest(path)
    except PointbrushError:
        return False
    if read_checksums(path) is not None or _unreadable(path):
        return False
    checksums = {name: file_digest(path / name) for name in _files(path)}
    replace_file(path / CHECKSUMS, encode_checksums(checksums))
    return True


def _files(path: Path) -> set[str]:
    here = {str(file.relative_to(path)) for file in path.rglob("*") if file.is_file()}
    return here - {CHECKSUMS, FILE, SENSOR}


def _unreadable(path: Path) -> list[str]:
    """List faults of frames' files by what they say of themselves."""
    problems = []
    for file in sorted(path.glob("frames/*.points")):
        try:
            layout = read_layout(file)
            chunks = read_array(file, layout, "chunks")
            wire = file.with_suffix(".wire")
            nbytes = int((chunks["offset"] + chunks["nbytes"]).max(initial=0))
            if "depth_ends" in layout.entries:
                nbytes = int(read_array(file, layout, "depth_ends")[-1])
            if not wire.is_file() or wire.stat().st_size != nbytes:
                problems.append(f"frames/{wire.name}: expected {nbytes:,} bytes")
        except DamagedError as error:
            problems.append(str(error))
    return problems
