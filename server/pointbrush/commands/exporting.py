"""The command that exports."""

from __future__ import annotations

import argparse
import shutil
import tempfile
import zipfile
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from pointbrush.commands.answers import Answer
from pointbrush.commands.arguments import FRAMES, SEQUENCE, argument, share, verb
from pointbrush.commands.places import Place
from pointbrush.errors import BadInputError

if TYPE_CHECKING:
    from pointbrush.client import Box, ExportFormat, Label, Snapshot
    from pointbrush.geometry.oriented_box import OrientedBox

Labels: TypeAlias = "Iterable[Label]"
Boxes: TypeAlias = "Iterable[OrientedBox | Box]"


@verb(
    SEQUENCE,
    argument("--format", "a format of docs/formats-written.md", required=True),
    argument("--out", "folder or file to write", required=True, type=Path),
    FRAMES,
    argument(
        "--snapshot", "labels of a snapshot instead of the current ones", metavar="NAME"
    ),
    argument(
        "--above", "minimum confidence of predicted labels, 0 to 1", type=share, default=0.0
    ),
    argument(
        "--sensor", "only the points of this one of several sensors, in its own coordinates",
        metavar="NAME",
    ),
    argument(
        "--val", "frames or recordings for validation in training formats (default: about one "
        "recording in five by its id, never all)", metavar="I:J|SEQ,…|none",
    ),
)  # fmt: skip
def export(given: argparse.Namespace, place: Place) -> Answer:
    """Write points with their labels."""
    from pointbrush.commands.local import LocalClient

    out, local = given.out, isinstance(place, LocalClient)
    zipped = out.suffix.lower() == ".zip"
    if not local and not zipped and out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise BadInputError(f"--out: expected a .zip, or a folder that is new or empty, got {out}")
    recording = place[given.sequence]
    known = {entry.format: entry for entry in place.export_formats()}
    snapshot = given.snapshot
    if snapshot:
        snapshots = place.projects[recording.manifest.project].snapshots()
        snapshot = _snapshot_named(snapshots, snapshot, recording.id)
    write = partial(
        recording.export, given.format, frames=given.frames, val=given.val, above=given.above,
        snapshot=snapshot, sensor=given.sensor,
    )  # fmt: skip
    if not local:
        out.parent.mkdir(parents=True, exist_ok=True)
    if local or zipped:
        write(out)
    else:
        _unpack(out, write)
    labels, boxes = [] if snapshot else recording.labels(), recording.boxes.all()
    return _exported(recording.id, out, known[given.format], labels, boxes)


def _snapshot_named(known: Iterable[Snapshot], text: str, sequence: str) -> str:
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


def _unpack(out: Path, export: Callable[[Path], object]) -> None:
    """Unpack an export beside ``out`` and move it there whole."""
    with tempfile.TemporaryDirectory(prefix=f".{out.name}-", dir=out.parent) as name:
        archive = Path(name) / "export.zip"
        export(archive)
        folder = Path(name) / "unpacked"
        with zipfile.ZipFile(archive) as packed:
            packed.extractall(folder)
        if out.exists():
            out.rmdir()
        shutil.move(folder, out)


def _exported(
    sequence: str, out: Path, entry: ExportFormat, labels: Labels, boxed: Boxes
) -> Answer:
    """Name the place of an export and the content that its format cannot hold.

    A warning names the used ``labels`` without a category; ``boxed`` are the boxes of labels.
    """
    lines = [f"exported {sequence} to {out}"]
    if entry.cannot_hold:
        lines.insert(0, f"{entry.title} does not hold: {', '.join(entry.cannot_hold)}")
    used = {box.label for box in boxed} if entry.classes else set()
    bare = [
        label.name
        for label in labels
        if entry.classes and not label.category and (label.points or label.id in used)
    ]
    warning = f"without a category, each a class of its own in the export: {', '.join(bare)}"
    value = {"sequence": sequence, "out": str(out), "cannot_hold": list(entry.cannot_hold)}
    return Answer(value | {"without_category": bare}, lines, [warning] if bare else [])
