"""Checksums of a sequence's files, and what is wrong with them."""

from __future__ import annotations

import json
from pathlib import Path

from pointbrush.errors import PointbrushError
from pointbrush.sequences.arrays import file_digest
from pointbrush.sequences.manifest import FILE, read_manifest

CHECKSUMS = "checksums.json"


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


def verify(path: Path) -> list[str]:
    """Problems of the sequence in folder ``path``, one sentence each; none when it is whole."""
    problems = []
    try:
        read_manifest(path)
    except PointbrushError as error:
        problems.append(str(error))
    expected = read_checksums(path)
    if expected is None:
        return [*problems, f"{CHECKSUMS}: expected checksums in JSON, it is missing or damaged"]
    for name, checksum in expected.items():
        file = path / name
        if not file.is_file():
            problems.append(f"{name}: expected a file, it is missing")
        elif file_digest(file) != checksum:
            problems.append(f"{name}: expected checksum {checksum}, its bytes have changed")
    here = {str(p.relative_to(path)) for p in path.rglob("*") if p.is_file()}
    extra = sorted(here - set(expected) - {CHECKSUMS, FILE})
    problems += [f"{name}: expected no such file" for name in extra]
    return problems
