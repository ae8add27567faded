"""Arguments of commands that more is asked of than argparse can tell."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Protocol

from pointbrush.errors import BadInputError
from pointbrush.printable import Entry


def report_suffix(out: Path) -> str:
    """Return the ending of a report's file; raises BadInputError for one that is no report's."""
    suffix = out.suffix.lower()
    if suffix not in (".html", ".csv"):
        raise BadInputError(f"--out: expected a file .html or .csv, got {out.name!r}")
    return suffix


def label_named(palette: Iterable[Entry], text: str) -> int:
    """Return the id of a label of a palette by its name or id; raises BadInputError."""
    for label in palette:
        if text in (label.name, str(label.id)):
            return label.id
    raise BadInputError(f"--labels: expected names or ids of the palette, got {text!r}")


class Named(Protocol):
    """A snapshot, here or of a server."""

    @property
    def id(self) -> str:
        """Its id."""

    @property
    def name(self) -> str:
        """The name that it was given, perhaps as others were."""

    @property
    def recordings(self) -> Mapping[str, int]:
        """Its recordings, by id."""


def snapshot_named(known: Iterable[Named], text: str, sequence: str) -> str:
    """Return the id of a snapshot of a recording by its id or name; raises BadInputError."""
    there = [each for each in known if sequence in each.recordings]
    found = [each.id for each in there if each.id == text]
    found = found or [each.id for each in there if each.name == text]
    if len(found) == 1:
        return found[0]
    ids = ", ".join(found or [each.id for each in there]) or "there is none"
    raise BadInputError(
        f"--snapshot: expected the name or id of one with {sequence!r} in it ({ids}), got {text!r}"
    )


def listed(text: str) -> list[str]:
    """Return the parts of a text with commas."""
    return [part.strip() for part in text.split(",") if part.strip()]


def imported(given: argparse.Namespace) -> list[list[Path]]:
    """Return the paths of each recording that `import` is to make; raises BadInputError."""
    if not given.each:
        return [given.paths]
    from pointbrush.work.imports.requests import recordings_in  # loads more than `--help` needs

    if given.name:
        raise BadInputError(
            "--name: expected none with --each: recordings are named by their files"
        )
    return [[path] for folder in given.paths for path in recordings_in(folder)]


def required(name: str, value: str | None) -> str:
    """Return an argument that a command cannot do without; raises BadInputError."""
    if not value:
        raise BadInputError(f"{name}: expected it to be given")
    return value
