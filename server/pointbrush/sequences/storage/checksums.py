"""The file of a sequence's checksums, and the name of a file that is written after the import."""

from __future__ import annotations

import json

CHECKSUMS = "checksums.json"
SENSOR = "sensor.json"
"""Facts about the recording's sensor that tracking keeps; the file may be missing."""


def encode_checksums(checksums: dict[str, str]) -> bytes:
    """The file: checksum by path in the sequence's folder."""
    return json.dumps(dict(sorted(checksums.items())), indent=0).encode()


def parse_checksums(data: bytes) -> dict[str, str] | None:
    """Return the checksums in the file's bytes; None when they are damaged."""
    try:
        content = json.loads(data)
    except ValueError:
        return None
    return content if isinstance(content, dict) else None
