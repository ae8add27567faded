"""The commands that import: recordings, and labels made elsewhere."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from pointbrush.commands.answers import Answer, confirmed, merge_answers
from pointbrush.commands.arguments import (
    SEQUENCE,
    argument,
    flags_of,
    switch,
    usage_error,
    verb,
)
from pointbrush.commands.places import Place, finished
from pointbrush.errors import BadInputError
from pointbrush.formats.tables.names import LABEL_FORMATS
from pointbrush.settings.definitions import values_of
from pointbrush.values.imports import ImportOptions, LabelOptions

IMPORT_FLAGS = tuple(each.name for each in fields(ImportOptions) if each.name != "id")


@verb(
    argument("paths", "files, folders, globs or archives", nargs="*", type=Path, metavar="PATH"),
    switch("--each", "import each file and folder in PATH as a recording of its own"),
    *flags_of(ImportOptions, *IMPORT_FLAGS),
    switch("--dry-run", "print the import's result without importing"),
)
def import_(given: argparse.Namespace, place: Place) -> Answer:
    """Import files as one recording."""
    options = {name: getattr(given, name) for name in IMPORT_FLAGS}
    recordings = _recordings(given)
    if given.sensor or given.extrinsics:
        recordings, changed = _with_sensors(given, recordings, place)
        options |= changed
    if given.dry_run:
        return merge_answers(
            _previewed(asdict(place.preview(paths, **options))) for paths in recordings
        )
    jobs = [place.start_import(paths, **options) for paths in recordings]
    return merge_answers(imported(finished(place, job)) for job in jobs)


def _recordings(given: argparse.Namespace) -> list[list[Path]]:
    """Return the paths of each recording of an import; raises BadInputError."""
    if not given.paths and not given.sensor:
        raise usage_error("import", "expected PATH, or --sensor NAME=PATH for each sensor")
    if not given.each:
        return [given.paths]
    from pointbrush.work.imports.requests import recordings_in  # slow to load

    if given.name:
        raise BadInputError(
            "--name: expected none with --each, which names recordings after their files"
        )
    return [[path] for folder in given.paths for path in recordings_in(folder)]


def _with_sensors(
    given: argparse.Namespace, recordings: list[list[Path]], place: Place
) -> tuple[list[list[Path]], dict[str, Any]]:
    """Return the paths of recordings of several sensors, and the options that name them.

    The paths of sensors are within PATH, if there is one.  A server gets all of them as an upload.
    """
    from pointbrush.commands.local import LocalClient
    from pointbrush.formats.sensors.extrinsics import pairs_of

    if given.each and given.sensor:
        raise usage_error("import", "expected no --sensor with --each")
    base = given.paths[0] if given.paths else Path()
    places = {name: base / path for name, path in pairs_of("--sensor", given.sensor or ()).items()}
    if places and not given.paths:
        recordings = [list(places.values())]
    if isinstance(place, LocalClient):
        named = {name: path.absolute() for name, path in places.items()}
        file = None if given.extrinsics is None else str(Path(given.extrinsics).absolute())
    else:
        named = {n: p.relative_to(base) if given.paths else Path(p.name) for n, p in places.items()}
        file = None if given.extrinsics is None else Path(given.extrinsics).name
        beside = [] if given.extrinsics is None else [Path(given.extrinsics)]
        recordings = [[*paths, *beside] for paths in recordings]
    sensor = [f"{name}={path.as_posix()}" for name, path in named.items()] or None
    return recordings, {"sensor": sensor, "extrinsics": file}


def _sensor(sensor: Mapping[str, Any]) -> str:
    """Describe a sensor of a previewed recording."""
    apart = "" if not sensor["apart"] else f", {1000 * sensor['apart']:.1f} ms apart"
    left_out = f", {sensor['left_out']} left out" if sensor["left_out"] else ""
    return f"{sensor['name']} ({sensor['type']}): {sensor['joined']} frames{apart}{left_out}"


def _previewed(found: Mapping[str, Any]) -> Answer:
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
        "sensors": "; ".join(map(_sensor, found["sensors"])),
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
    lines += [
        f"sensor {each['name']} ({each['type']}): {each['frames']} frames"
        for each in result.get("sensors", ())
    ]
    lines += [f"up is {_up(result)}"] if result.get("up_from") == "guessed" else []
    return Answer(result, lines, _warnings(result))


def _warnings(result: Mapping[str, Any]) -> list[str]:
    return [f"warning: {warning}" for warning in result.get("warnings", ())]


@verb(
    SEQUENCE,
    argument(
        "path", "file or folder of labels (default: the labels in the recording's own files, if "
        "they were not imported with it)", type=Path, nargs="?", metavar="PATH",
    ),
    argument(
        "--map", "file with the names of classes: JSON, YAML, XML, or lines 'number name'",
        type=Path, metavar="FILE",
    ),
    argument("--format", f"format of the labels (default: detected): {', '.join(LABEL_FORMATS)}"),
    *flags_of(LabelOptions, "no_ground", "by_order", "field", "allow_empty", "boxes"),
    switch("--dry-run", "print the labels found without importing"),
)  # fmt: skip
def import_labels(given: argparse.Namespace, place: Place) -> Answer:
    """Import labels made elsewhere, as one edit."""
    recording = place[given.sequence]
    if given.path is None:
        recording.import_source_labels()
        return confirmed(
            f"imported the labels in the files of {recording.id}", sequence=recording.id
        )
    job = recording.start_label_import(
        [given.path],
        map=None if given.map is None else _text(given.map),
        dry_run=given.dry_run,
        **values_of(LabelOptions, given),
    )
    result = finished(place, job)
    return _labels_imported(result, len(recording.frames), dry_run=given.dry_run)


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, ValueError) as error:
        raise BadInputError(f"--map: expected a readable text file, got {path}: {error}") from None


def _labels_imported(result: Mapping[str, Any], frames: int, *, dry_run: bool) -> Answer:
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
    if result.get("doubtful"):
        lines.append(f"{result['doubtful']:,} points at borders of masks stay as they are")
    lines.append(
        f"{done} {count:,} labelled points in {result['matched']} of {frames} "
        f"frames, {len(result['labels'])} labels, {len(result['new_labels'])} of them new"
    )
    error = "nothing was labelled" if result.get("refused") else ""
    return Answer(result, lines, _warnings(result), error=error)
