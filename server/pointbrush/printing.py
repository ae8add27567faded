"""Answers of commands, the same for a workspace of this machine and of a server."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, is_dataclass
from pathlib import Path
from typing import Any

from pointbrush.printable import (
    About,
    Agreeing,
    Boxed,
    ComparedClass,
    CountedEntry,
    ExportFormat,
    Suspicious,
    Taught,
    TokenEntry,
)


@dataclass(frozen=True, slots=True)
class Answer:
    """Answer of a command.

    `--json` prints ``value``.  Otherwise ``lines`` are printed, on a terminal below ``head`` with
    the names of their columns, and ``warnings`` on standard error.  With an ``error`` the command
    prints the answer and fails.
    """

    value: Any
    lines: Sequence[str]
    warnings: Sequence[str] = ()
    head: str = ""
    error: str = ""

    def show(self, *, as_json: bool) -> None:
        """Print the answer as one JSON document or as lines."""
        if as_json:
            print(json.dumps(self.value, default=_plain, ensure_ascii=False, indent=1))
            return
        for warning in self.warnings:
            print(warning, file=sys.stderr)
        for line in (self.head, *self.lines) if sys.stdout.isatty() else self.lines:
            if line:
                print(line)


def _plain(value: object) -> object:
    """Return a value that JSON cannot hold as one that it can."""
    return asdict(value) if is_dataclass(value) and not isinstance(value, type) else str(value)


def preview(found: Mapping[str, Any]) -> Answer:
    """Describe an import that was not carried out."""
    points = ", ".join(f"{frame['points']:,}" for frame in found["points"])
    left_out = sum(frame["left_out"] for frame in found["points"])
    source = found["fps_from"]
    rate_from = source if source in ("given", "assumed") else f"from {source}"
    columns = ", ".join(
        column["name"]
        if column["meaning"] in (column["name"].lower(), "xyz")
        else f"{column['name']} ({column['meaning'] or 'left out'})"
        for column in found["columns"]
    )
    frames = "an unknown number of" if found["frames"] is None else found["frames"]
    wide = " x ".join(f"{width:,.1f}" for width in found["units"]["extent"])
    shown = {
        "name": found["name"],
        "format": f"{found['format']} ({found['title']})",
        "frames": f"{frames}, {found['order']}",
        "rate": f"none, {source}"
        if source == "a single scan"
        else f"{found['fps']:g} frames/s, {rate_from}",
        "points": f"{points} in the first frames"
        + (f", {left_out:,} invalid left out" if left_out else ""),
        "columns": columns,
        "topics": ", ".join(
            f"{topic['name']}{' (read)' if topic['read'] else ''}: {topic['messages']} "
            f"{topic['type']}"
            for topic in found["topics"]
        ),
        "cameras": ", ".join(map(_camera, found["cameras"])),
        "poses": found["poses"]["source"] if found["poses"] else "none",
        "units": f"{found['units']['name']}, {wide}",
        "up": _up(found),
        "labels": "come with the points" if found["labels"] else "none",
    }
    lines = [f"{name:10} {value}" for name, value in shown.items() if value]
    lines += [f"warning    {warning}" for warning in found["warnings"]]
    lines.append("dry run: nothing was imported")
    return Answer(found, lines)


def _up(found: Mapping[str, Any]) -> str:
    """Describe the up axis; a guess is called one."""
    guess = ", guessed from the points; --up changes it" if found["up_from"] == "guessed" else ""
    return f"{found['up']}{guess}"


def _camera(camera: Mapping[str, Any]) -> str:
    if "color" not in camera:
        return str(camera["name"])
    unused = f"; unused: {', '.join(camera['unused'])}" if camera["unused"] else ""
    return (
        f"{camera['name']} (colour: {camera['color']}; intrinsics: {camera['intrinsics']}{unused})"
    )


def imported(result: Mapping[str, Any]) -> Answer:
    """Describe the result of an import's job."""
    dropped = f", {result['dropped']:,} invalid left out" if result["dropped"] else ""
    frames = "1 frame" if result["frames"] == 1 else f"{result['frames']} frames"
    points = "1 point" if result["points"] == 1 else f"{result['points']:,} points"
    lines = [f"imported {result['sequence']}: {frames}, {points}{dropped}"]
    lines += [f"up is {_up(result)}"] if result.get("up_from") == "guessed" else []
    return Answer(result, lines, _warnings(result))


def together(answers: Iterable[Answer]) -> Answer:
    """Join several results; return a single result unchanged."""
    found = list(answers)
    if len(found) == 1:
        return found[0]
    lines = [line for each in found for line in each.lines]
    warnings = [warning for each in found for warning in each.warnings]
    return Answer([each.value for each in found], lines, warnings)


def _warnings(result: Mapping[str, Any]) -> list[str]:
    return [f"warning: {warning}" for warning in result.get("warnings", ())]


def labels_imported(result: Mapping[str, Any], frames: int, *, dry_run: bool) -> Answer:
    """Describe labels that were imported into a recording of ``frames`` frames."""
    lines = [
        f"frame {frame['frame']}: {frame['points']:,} points of {frame['file']}"
        for frame in result["frames"]
    ]
    lines += [
        f"class {number} has no name; name it in a file for --map"
        for number in result["unknown_classes"]
    ]
    if result["unmatched_frames"]:
        lines.append(f"frames without labels: {', '.join(map(str, result['unmatched_frames']))}")
    if result["unmatched_files"]:
        lines.append(f"files without a frame: {', '.join(result['unmatched_files'])}")
    done = "found" if dry_run else "imported"
    count = result["labelled"] if dry_run else result.get("changed", 0)
    if locked := result.get("locked"):
        lines.append(f"points of locked labels unchanged: {', '.join(locked)}")
    lines.append(
        f"{done} {count:,} labelled points in {result['matched']} of {frames} "
        f"frames, {len(result['labels'])} labels, {len(result['new_labels'])} of them new"
    )
    error = "nothing was labelled" if result.get("refused") else ""
    return Answer(result, lines, _warnings(result), error=error)


def tracked(result: Mapping[str, Any]) -> Answer:
    """Describe the result of a tracking run's job."""
    line = f"tracked {result['frames']} frames, {result['changed']:,} points labelled"
    return Answer(result, [line])


def fitted(result: Mapping[str, Any]) -> Answer:
    """Describe the result of a job that fitted boxes."""
    count = len(result["fitted"])
    lines = ["fitted 1 box" if count == 1 else f"fitted {count} boxes"]
    lines += [f"label {label}: {why}" for label, why in result["skipped"].items()]
    return Answer(result, lines)


@dataclass(frozen=True, slots=True)
class Row:
    """A recording's row of the list; ``known`` is None for an unreadable recording."""

    id: str
    known: About | None
    damaged: str | None
    labels_missing: str | None

    @property
    def line(self) -> str:
        """The columns, separated by tabs."""
        parts = [self.id]
        if self.known is not None:
            points = f"{sum(self.known.points):,} points"
            parts += [f"{self.known.frames} frames", f"{self.known.fps:g} fps", points]
            parts.append(self.known.name)
        if self.damaged is not None:
            parts.append(f"damaged: {self.damaged}")
        if self.labels_missing is not None:
            parts.append(f"labels did not come in: {self.labels_missing}")
        return "\t".join(parts)


def recordings(rows: Iterable[Row]) -> Answer:
    """List the recordings of a workspace."""
    listed = list(rows)
    value = [
        (_facts(row.known) if row.known else {"id": row.id})
        | {"damaged": row.damaged, "labels_missing": row.labels_missing}
        for row in listed
    ]
    head = "ID\tFRAMES\tRATE\tPOINTS\tNAME"
    return Answer(value, [row.line for row in listed], head=head if listed else "")


def _facts(known: About) -> dict[str, Any]:
    return {
        "id": known.id,
        "name": known.name,
        "source": known.source,
        "frames": known.frames,
        "fps": known.fps,
        "points": list(known.points),
        "fields": list(known.fields),
    }


def confirmed(line: str, **value: Any) -> Answer:
    """Return an answer of one line, with ``value`` as JSON."""
    return Answer(value, [line])


def deleted(sequence: str) -> Answer:
    """Confirm that a recording is deleted."""
    return confirmed(
        f"deleted {sequence}; `pointbrush undelete {sequence}` restores it within 30 days",
        sequence=sequence,
    )


def undeleted(sequence: str) -> Answer:
    """Confirm that a recording is restored."""
    return confirmed(f"restored {sequence}", sequence=sequence)


def renamed(sequence: str, name: str) -> Answer:
    """Confirm a recording's new name."""
    return confirmed(f"renamed {sequence} to {name!r}", sequence=sequence, name=name)


def tokens(found: Iterable[TokenEntry]) -> Answer:
    """List tokens, without their secrets."""
    rows = [
        {"id": each.id, "role": each.role, "name": each.name, "status": _status(each)}
        for each in found
    ]
    if not rows:
        return Answer(rows, ["no tokens; `pointbrush token add NAME --role annotator` adds one"])
    return table(rows, ("ID", "ROLE", "NAME", "STATUS"), [list(row.values()) for row in rows])


def _status(token: TokenEntry) -> str:
    return "valid" if token.valid else "revoked" if token.revoked else "expired"


def source_labels_imported(sequence: str) -> Answer:
    """Confirm an import of the labels in a recording's own files."""
    return confirmed(f"imported the labels in the files of {sequence}", sequence=sequence)


def labels(palette: Iterable[CountedEntry]) -> Answer:
    """List the labels of a palette with their numbers of points."""
    listed = list(palette)
    rows = [(each.id, each.color, each.name, each.category, each.points) for each in listed]
    return table(listed, ("ID", "COLOUR", "NAME", "CATEGORY", "POINTS"), rows)


def table(value: Sequence[object], head: Sequence[str], rows: Iterable[Sequence[object]]) -> Answer:
    """List ``value`` in rows of columns that tabs separate; the head is for a terminal."""
    lines = ["\t".join("" if cell is None else str(cell) for cell in row) for row in rows]
    return Answer(value, lines, head="\t".join(head) if lines else "")


def facts(known: About, revision: int, palette: Iterable[CountedEntry]) -> Answer:
    """Describe a recording."""
    listed = list(palette)
    shown: dict[str, Any] = {
        "id": known.id,
        "name": known.name,
        "source": known.source,
        "frames": known.frames,
        "fps": known.fps,
        "points": f"{min(known.points):,} to {max(known.points):,} a frame",
        "fields": ", ".join(known.fields),
        "revision": revision,
    }
    lines = [f"{name:10} {value}" for name, value in shown.items()]
    lines += [f"label {label.id:<4} {label.color} {label.name}" for label in listed]
    return Answer(_facts(known) | {"revision": revision, "labels": listed}, lines)


def findings(
    found: Iterable[Suspicious], unchecked: Sequence[str], *, settled: bool, fail: bool
) -> Answer:
    """List suspicious labels; ``settled``: with findings that a reviewer has accepted.

    ``fail``: the command fails if the list is not empty.
    """
    wanted = [each for each in found if settled or not each.settled]
    lines = []
    for each in wanted:
        frames = "palette" if each.first is None else f"frame {each.first}"
        if each.last != each.first:
            frames = f"frames {each.first} to {each.last}"
        lines.append(f"{frames}: {each.text}")
    lines.append(f"{len(wanted)} suspicious")
    value = {"findings": wanted, "unchecked": list(unchecked)}
    error = f"{len(wanted)} suspicious" if fail and wanted else ""
    return Answer(value, lines, [f"not checked: {each}" for each in unchecked], error=error)


def labels_compared(labels: Sequence[Agreeing], miou: float | None) -> Answer:
    """List the IoU of labels of two recordings."""
    lines = [f"{each.iou:.3f}  {each.name}" for each in labels]
    lines.append(
        "neither recording has labels" if miou is None else f"{miou:.3f}  mean of all labels"
    )
    value = [{"name": each.name, "iou": each.iou} for each in labels]
    return Answer({"labels": value, "miou": miou}, lines, head="IoU    label")


def boxes_compared(classes: Sequence[ComparedClass], hota: float | None) -> Answer:
    """List the agreement of boxes by class, with a line for each minimum 3D IoU of a match."""
    lines = [
        f"{one.name}: {one.second} boxes for {one.first}, IoU from {at.iou}: "
        f"AP {at.ap:.3f}, precision {at.precision:.3f}, recall {at.recall:.3f}"
        for one in classes
        for at in one.scores
    ]
    if not classes:
        lines.append("neither recording has boxes")
    elif hota is None:
        lines.append("HOTA: not computed; 'pip install trackeval'")
    else:
        lines.append(f"HOTA {hota:.3f}")
    return Answer({"classes": list(classes), "hota": hota}, lines)


def checked(
    recordings: int, problems: Sequence[str], rebuilt: Sequence[str], *, readable: bool
) -> Answer:
    """List the faults of a workspace; ``readable``: other users of the machine can read it."""
    lines = [*rebuilt, *problems]
    if not problems:
        lines.append(f"{recordings} recordings and their labels are sound")
        if readable:
            lines.append(
                "other users of this machine can read the workspace: chmod -R go= closes it"
            )
    value = {"recordings": recordings, "problems": problems, "rebuilt": rebuilt}
    return Answer(value, lines, error=f"{len(problems)} problems found" if problems else "")


def exported(
    sequence: str,
    out: Path,
    entry: ExportFormat,
    labels: Iterable[CountedEntry],
    boxed: Iterable[Boxed],
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


# ── labels by example ────────────────────────────────────────────────────────────────────────


def classifiers(found: Iterable[Taught]) -> Answer:
    """List classifiers with their examples, recordings and scores."""
    listed = list(found)
    if not listed:
        return Answer(listed, ["no classifiers; `pointbrush example SEQ` trains one"])
    lines = [_classifier(each) for each in listed]
    return Answer(listed, lines, head="ID\tEXAMPLES\tTAUGHT BY\tSCORE")


def classifier(found: Taught) -> Answer:
    """Describe a classifier with its examples, recordings and score."""
    return Answer(found, [_classifier(found)])


def _classifier(found: Taught) -> str:
    examples = ", ".join(f"{name} {count}" for name, count in found.examples.items())
    score = "" if found.score is None else f"\tscore {found.score:.2f}"
    return f"{found.id}\t{examples}\tby {', '.join(found.taught_by) or 'no recording'}{score}"


def applied(found: Taught, result: Mapping[str, Any]) -> Answer:
    """Describe a classifier and the result of a job that applied it."""
    done = f"labelled {result['changed']:,} points in {result.get('frames', 0)} frames"
    return Answer({"classifier": found, "applied": result}, [_classifier(found), done])
