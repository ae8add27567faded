"""Arguments of commands that need more than argparse checks."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Protocol

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.names import composed
from pointbrush.options import WORKSPACE
from pointbrush.printable import Entry
from pointbrush.settings import CLIENTS, LOCAL, REMOTE, STORAGE, Settings, options


def on_server(given: argparse.Namespace, settings: Settings) -> bool:
    """Return whether a command works on a server's workspace, not on one of this machine.

    Flags of a workspace or its storage win over POINTBRUSH_SERVER.  Raises BadInputError if the
    command cannot work where the flags and the environment say.
    """
    command, local = given.command, _storage_flag(given)
    if local and getattr(given, "server", None):
        raise BadInputError(f"--server: expected no {local}, which names a workspace here")
    if command in CLIENTS and command not in REMOTE and not settings.server:
        raise BadInputError(
            f"pointbrush {command} works on a server: give --server URL or set POINTBRUSH_SERVER; "
            "`pointbrush serve` starts a server of a workspace"
        )
    if not settings.server or local:
        return False
    if command in LOCAL:
        raise BadInputError(
            f"pointbrush {command} works on a workspace's folder; POINTBRUSH_SERVER is set: unset "
            "it or give --workspace"
        )
    return command in CLIENTS


def _storage_flag(given: argparse.Namespace) -> str:
    """Return the first given flag of a workspace or its storage, or ""."""
    storage = (each for each in options() if each.definition.group in (WORKSPACE, STORAGE))
    found = (each.flag for each in storage if getattr(given, each.name, None) is not None)
    return next(found, "")


class Named(Protocol):
    """Something with an id and a name that others may have as well."""

    @property
    def id(self) -> str: ...  # noqa: D102
    @property
    def name(self) -> str: ...  # noqa: D102


def recording_named(known: Iterable[Named], text: str) -> str:
    """Return the id of a recording by its id or else by its name.

    Raises NotFoundError, and BadInputError for a name that several recordings have.
    """
    listed = list(known)
    found = [each.id for each in listed if each.id == text]
    found = found or [each.id for each in listed if each.name == text]
    if not found:
        raise NotFoundError(f"sequence: expected a recording's id or name, got {text!r}")
    if len(found) > 1:
        raise BadInputError(
            f"sequence: expected the name of one recording, got the name of {', '.join(found)}"
        )
    return found[0]


def report_suffix(out: Path) -> str:
    """Return the suffix of a report's file; raises BadInputError for another suffix."""
    suffix = out.suffix.lower()
    if suffix not in (".html", ".csv"):
        raise BadInputError(f"--out: expected a file .html or .csv, got {out.name!r}")
    return suffix


def labels_named(text: str | None, palette: Callable[[], Iterable[Entry]]) -> list[int] | None:
    """Return the ids of labels by their names or ids, which commas separate; None for no text.

    ``palette`` returns the labels to choose from.  Raises BadInputError.
    """
    if not text:
        return None
    listed = list(palette())
    ids = {str(label.id): label.id for label in listed} | {label.name: label.id for label in listed}
    wanted = composed(text).split(",")
    for part in wanted:
        if part not in ids:
            raise BadInputError(f"--labels: expected names or ids of the palette, got {part!r}")
    return [ids[part] for part in wanted]


class Snapshot(Named, Protocol):
    """A snapshot of a project."""

    @property
    def recordings(self) -> Mapping[str, int]: ...  # noqa: D102


def snapshot_named(known: Iterable[Snapshot], text: str, sequence: str) -> str:
    """Return the id of a snapshot of a recording by its id or name; raises BadInputError."""
    there = [each for each in known if sequence in each.recordings]
    found = [each.id for each in there if each.id == text]
    found = found or [each.id for each in there if each.name == text]
    if len(found) == 1:
        return found[0]
    ids = ", ".join(found or [each.id for each in there]) or "there is none"
    raise BadInputError(
        f"--snapshot: expected the name or id of a snapshot of {sequence!r} ({ids}), got {text!r}"
    )


def listed(text: str) -> list[str]:
    """Return the parts of a text that commas separate."""
    return [part.strip() for part in text.split(",") if part.strip()]


def imported(given: argparse.Namespace) -> list[list[Path]]:
    """Return the paths of each recording of an `import`; raises BadInputError."""
    if not given.each:
        return [given.paths]
    from pointbrush.work.imports.requests import recordings_in  # slow to load

    if given.name:
        raise BadInputError(
            "--name: expected none with --each, which names recordings after their files"
        )
    return [[path] for folder in given.paths for path in recordings_in(folder)]


def required(name: str, value: str | None) -> str:
    """Return a required argument; raises BadInputError if it was not given."""
    if not value:
        raise BadInputError(f"{name}: expected a value, got none")
    return value
