"""Lines that commands print, of a workspace here and of one behind a server alike.

A job is followed on the command line: a bar on a terminal, plain lines elsewhere.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from pointbrush.errors import BadInputError, CancelledError, PointbrushError
from pointbrush.job import ENDED

TICK = 0.1
LINE_STEP = 0.1
"""Share of the work between two plain lines."""


class About(Protocol):
    """Facts of a recording."""

    @property
    def id(self) -> str: ...  # noqa: D102
    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def source(self) -> str: ...  # noqa: D102
    @property
    def frames(self) -> int: ...  # noqa: D102
    @property
    def fps(self) -> float: ...  # noqa: D102
    @property
    def points(self) -> Sequence[int]: ...  # noqa: D102
    @property
    def fields(self) -> Sequence[str]: ...  # noqa: D102


class Entry(Protocol):
    """A label of a palette."""

    @property
    def id(self) -> int: ...  # noqa: D102
    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def color(self) -> str: ...  # noqa: D102


class ExportFormat(Protocol):
    """An export format."""

    @property
    def title(self) -> str: ...  # noqa: D102
    @property
    def cannot_hold(self) -> Sequence[str]: ...  # noqa: D102


class Suspicious(Protocol):
    """A suspicious thing in the labels of a recording."""

    @property
    def first(self) -> int | None: ...  # noqa: D102
    @property
    def last(self) -> int | None: ...  # noqa: D102
    @property
    def text(self) -> str: ...  # noqa: D102
    @property
    def settled(self) -> bool: ...  # noqa: D102


def preview(found: Mapping[str, Any]) -> None:
    """Print what an import would do."""
    points = ", ".join(f"{frame['points']:,}" for frame in found["points"])
    said = found["fps_from"]
    rate_from = said if said in ("given", "assumed") else f"from {said}"
    columns = ", ".join(
        column["name"]
        if column["meaning"] in (column["name"].lower(), "xyz")
        else f"{column['name']} ({column['meaning'] or 'left out'})"
        for column in found["columns"]
    )
    frames = "an unknown number of" if found["frames"] is None else found["frames"]
    wide = " x ".join(f"{width:,.1f}" for width in found["units"]["extent"])
    told = {
        "name": found["name"],
        "format": f"{found['format']} ({found['title']})",
        "frames": f"{frames}, {found['order']}",
        "rate": f"{found['fps']:g} frames/s, {rate_from}",
        "points": f"{points} in the first frames",
        "columns": columns,
        "topics": ", ".join(
            f"{topic['name']}{' (read)' if topic['read'] else ''}: {topic['messages']} "
            f"{topic['type']}"
            for topic in found["topics"]
        ),
        "cameras": ", ".join(camera["name"] for camera in found["cameras"]),
        "poses": found["poses"]["source"] if found["poses"] else "none",
        "units": f"{found['units']['name']}, {wide}",
        "up": found["up"],
        "labels": "come with the points" if found["labels"] else "none",
    }
    for name, value in told.items():
        if value:
            print(f"{name:10} {value}")
    for warning in found["warnings"]:
        print(f"warning    {warning}")
    print("nothing was written: this is what an import would do")


def imported(result: Mapping[str, Any]) -> None:
    """Print the result of an import's job."""
    for warning in result["warnings"]:
        print(f"warning: {warning}", file=sys.stderr)
    dropped = f", {result['dropped']:,} invalid left out" if result["dropped"] else ""
    frames = "1 frame" if result["frames"] == 1 else f"{result['frames']} frames"
    points = "1 point" if result["points"] == 1 else f"{result['points']:,} points"
    print(f"imported {result['sequence']}: {frames}, {points}{dropped}")


def labels_imported(result: Mapping[str, Any], frames: int, *, dry_run: bool) -> None:
    """Print the report of labels that were imported into a recording of ``frames`` frames."""
    for warning in result.get("warnings", ()):
        print(f"warning: {warning}", file=sys.stderr)
    for told in result["frames"]:
        print(f"frame {told['frame']}: {told['points']:,} points of {told['file']}")
    for number in result["unknown_classes"]:
        print(f"class {number} has no name: --map FILE gives it one")
    if result["unmatched_frames"]:
        print(f"frames without labels: {', '.join(map(str, result['unmatched_frames']))}")
    if result["unmatched_files"]:
        print(f"files of no frame: {', '.join(result['unmatched_files'])}")
    done = "found" if dry_run else "imported"
    count = result["labelled"] if dry_run else result.get("changed", 0)
    if locked := result.get("locked"):
        print(f"points of locked labels stayed: {', '.join(locked)}")
    print(
        f"{done} {count:,} labelled points in {result['matched']} of {frames} "
        f"frames, {len(result['labels'])} labels, {len(result['new_labels'])} of them new"
    )


def tracked(result: Mapping[str, Any]) -> None:
    """Print the result of a tracking run's job."""
    print(f"tracked {result['frames']} frames, {result['changed']:,} points labelled")


def line(
    sequence: str, known: About | None, damaged: str | None, labels_missing: str | None
) -> None:
    """Print a recording's line of the list; of a damaged one perhaps only the id is known."""
    parts = [sequence]
    if known is not None:
        points = f"{sum(known.points):,} points"
        parts += [f"{known.frames} frames", f"{known.fps:g} fps", points, known.name]
    if damaged is not None:
        parts.append(f"damaged: {damaged}")
    if labels_missing is not None:
        parts.append(f"labels did not come in: {labels_missing}")
    print("\t".join(parts))


def source_labels_imported(sequence: str) -> None:
    """Print that the labels in a recording's own files are in."""
    print(f"the labels in the files of {sequence} are in")


def facts(known: About, revision: int, palette: Iterable[Entry]) -> None:
    """Print what is known of a recording."""
    told: dict[str, Any] = {
        "id": known.id,
        "name": known.name,
        "source": known.source,
        "frames": known.frames,
        "fps": known.fps,
        "points": f"{min(known.points):,} to {max(known.points):,} a frame",
        "fields": ", ".join(known.fields),
        "revision": revision,
    }
    for name, value in told.items():
        print(f"{name:10} {value}")
    for label in palette:
        print(f"label {label.id:<4} {label.color} {label.name}")


def findings(found: Iterable[Suspicious], unchecked: Iterable[str], *, settled: bool) -> None:
    """Print suspicious things, with ``settled`` also those that a reviewer has accepted."""
    wanted = [each for each in found if settled or not each.settled]
    for each in wanted:
        frames = "palette" if each.first is None else f"frame {each.first}"
        if each.last != each.first:
            frames = f"frames {each.first} to {each.last}"
        print(f"{frames}: {each.text}")
    for sentence in unchecked:
        print(f"not looked at: {sentence}", file=sys.stderr)
    print(f"{len(wanted)} suspicious")


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


class Followed(Protocol):
    """A job of this process, or of a server as its client sees it."""

    @property
    def id(self) -> str: ...  # noqa: D102
    @property
    def kind(self) -> str: ...  # noqa: D102
    @property
    def state(self) -> str: ...  # noqa: D102
    @property
    def progress(self) -> float: ...  # noqa: D102
    @property
    def message(self) -> str: ...  # noqa: D102
    @property
    def result(self) -> dict[str, Any] | None: ...  # noqa: D102
    @property
    def error(self) -> str | None: ...  # noqa: D102


Look = Callable[[str], Followed]
"""Return a job as it is now, by its id."""


def follow(look: Look, job: Followed) -> dict[str, Any]:
    """Show ``job`` until it has ended; returns its result.

    Raises PointbrushError with the job's own sentence when it failed, CancelledError when it was
    cancelled.
    """
    show = _bar if sys.stderr.isatty() else _lines
    ended = show(look, job)
    if ended.state == "failed":
        raise PointbrushError(ended.error or "the job failed")
    if ended.state == "cancelled":
        raise CancelledError("cancelled")
    return ended.result or {}


def _bar(look: Look, job: Followed) -> Followed:
    from tqdm import tqdm

    layout = "{desc}: {percentage:3.0f}% |{bar}| {postfix}"
    with tqdm(total=1.0, desc=job.kind, bar_format=layout, leave=True) as bar:
        while job.state not in ENDED:
            time.sleep(TICK)
            job = look(job.id)
            bar.set_postfix_str(job.message, refresh=False)
            bar.update(job.progress - bar.n)
    return job


def _lines(look: Look, job: Followed) -> Followed:
    shown = -1.0
    while job.state not in ENDED:
        time.sleep(TICK)
        job = look(job.id)
        if job.state == "running" and job.progress >= shown + LINE_STEP:
            shown = job.progress
            print(f"{job.kind}: {job.progress:.0%} {job.message}", file=sys.stderr, flush=True)
    return job


def not_held(entry: ExportFormat) -> None:
    """Print what an export in this format leaves out, before it is written."""
    if entry.cannot_hold:
        print(f"{entry.title} does not hold: {', '.join(entry.cannot_hold)}")


# ── labels by example ────────────────────────────────────────────────────────────────────────


class Taught(Protocol):
    """A classifier as the workspace and the client have it."""

    @property
    def id(self) -> str: ...  # noqa: D102
    @property
    def examples(self) -> Mapping[str, int]: ...  # noqa: D102
    @property
    def taught_by(self) -> Mapping[str, int]: ...  # noqa: D102
    @property
    def score(self) -> float | None: ...  # noqa: D102


def classifier(found: Taught) -> None:
    """Print a classifier: what taught it, and how it scores."""
    examples = ", ".join(f"{name} {count}" for name, count in found.examples.items())
    score = "" if found.score is None else f"\tscore {found.score:.2f}"
    print(f"{found.id}\t{examples}\tby {', '.join(found.taught_by) or 'nobody'}{score}")


def predicted(result: Mapping[str, Any]) -> None:
    """Print what a job that applied a classifier did."""
    print(f"labelled {result['changed']:,} points in {result.get('frames', 0)} frames")


def listed(text: str) -> list[str]:
    """Return the parts of a text with commas."""
    return [part.strip() for part in text.split(",") if part.strip()]


def required(name: str, value: str | None) -> str:
    """Return an argument that a command cannot do without; raises BadInputError."""
    if not value:
        raise BadInputError(f"{name}: expected it to be given")
    return value
