"""Reading the result file of "Check this headset"."""

from __future__ import annotations

from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from pointbrush.errors import BadInputError
from pointbrush.values.headset_checks import HeadsetReportFile

LARGEST = 1 << 20
"""Limit of a file, bytes; a report has a few thousand."""


def read_report(path: Path) -> HeadsetReportFile:
    """Read a report; raises BadInputError for any other file."""
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST + 1)
    except OSError as error:
        raise BadInputError(f"{path}: expected a readable file ({error.strerror})") from None
    if len(data) > LARGEST:
        raise BadInputError(f"{path}: expected a headset report, got more than {LARGEST:,} bytes")
    try:
        return TypeAdapter(HeadsetReportFile).validate_json(data)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(step) for step in first["loc"]) or "the file"
        raise BadInputError(
            f"{path}: expected a headset report of version 1, but {where}: {first['msg']}"
        ) from None
