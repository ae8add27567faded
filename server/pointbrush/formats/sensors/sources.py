"""Recordings of several sensors in folders: named ones, calibrated ones, and data sets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.formats.cameras.image_pairs import folders_in
from pointbrush.formats.folder import list_files, list_folder
from pointbrush.formats.inside import require_inside
from pointbrush.formats.listing import Listing
from pointbrush.formats.options import ReadOptions
from pointbrush.formats.sensors.drives import argoverse_streams, nuscenes_streams
from pointbrush.formats.sensors.extrinsics import (
    FILES,
    MOST_BYTES,
    Extrinsics,
    pairs_of,
    read_extrinsics,
    with_offsets,
)
from pointbrush.formats.sensors.streams import Stream, join_streams
from pointbrush.names import composed


def list_recording(folder: Path, format: str | None, options: ReadOptions) -> Listing:
    """List the recording in a folder: of several sensors, or of one.

    A folder has several sensors if the user names a calibration file or if one is in it that names
    two of its folders, and if all sensors of a data set are asked for.
    """
    streams, top = [], _top(folder, options)
    if options.chosen.sensors == "all":
        alone = _of_one(options)
        streams = argoverse_streams(top, alone) or nuscenes_streams(top, alone)
        known = {stream.name: stream.known for stream in streams}
        known = with_offsets(known, list(known), options.chosen.clock_offset) if known else {}
        streams = [replace(stream, known=known[stream.name]) for stream in streams]
    if not streams and (known := _calibration(top, options)):
        places = {composed(each.name): each for each in folders_in(top)}
        named = {name: places[name] for name in known if name in places}
        streams = _streams(named, known, format, options)
    return join_streams(streams, options) if streams else list_folder(folder, format, options)


def _top(folder: Path, options: ReadOptions) -> Path:
    """Return the folder in a folder of an archive or an upload, beside the named calibration."""
    beside = Path(options.chosen.extrinsics or folder).name
    inside = [p for p in folder.iterdir() if p.name[0] != "." and p.name != beside]
    only = inside[0] if len(inside) == 1 else folder
    descends = only != folder and only.is_dir() and not only.is_symlink()
    return _top(only, options) if descends else folder


def list_named(format: str | None, options: ReadOptions) -> Listing | None:
    """List the sensors that the user named with a path each; None without any.

    Raises NotFoundError, ForbiddenError, BadInputError.
    """
    named = pairs_of("sensor", options.chosen.sensor)
    if not named:
        return None
    if len(named) == 1:
        raise BadInputError("sensor: expected two sensors or more, got one")
    places = {name: Path(path) for name, path in named.items()}
    if options.limits.roots:
        require_inside(list(places.values()), options.limits.roots)
    stated = options.chosen.extrinsics
    known = {} if stated is None else read_extrinsics(Path(stated), options.limits)
    return join_streams(_streams(places, known, format, options), options)


def _calibration(folder: Path, options: ReadOptions) -> dict[str, Extrinsics]:
    """Read the named calibration file, or the one in a folder that names two of its folders."""
    if options.chosen.extrinsics is not None:
        return read_extrinsics(Path(options.chosen.extrinsics), options.limits)
    inside = {composed(each.name) for each in folders_in(folder)}
    for path in (folder / name for name in FILES if (folder / name).is_file()):
        try:
            known = read_extrinsics(path, options.limits)
        except BadInputError:
            # The file may be of another tool, unless it names a folder.
            with path.open("rb") as file:
                text = file.read(MOST_BYTES).decode("utf-8", "replace")
            if any(f'"{name}"' in text for name in inside):
                raise
            continue
        if len(inside & known.keys()) > 1:
            return known
    return {}


def _streams(
    places: Mapping[str, Path],
    known: Mapping[str, Extrinsics],
    format: str | None,
    options: ReadOptions,
) -> list[Stream]:
    if len(places) < 2:
        raise BadInputError(
            f"extrinsics: expected the names of two folders or more, got {', '.join(known)}; "
            "--sensor NAME=PATH names other places"
        )
    stated = with_offsets(known, list(places), options.chosen.clock_offset)
    alone = _of_one(options)
    # Only the poses of the reference sensor are used.
    others = replace(alone, chosen=replace(alone.chosen, poses="none"))
    return [
        Stream(name, _list_one(path, format, others if number else alone), stated[name])
        for number, (name, path) in enumerate(places.items())
    ]


def _of_one(options: ReadOptions) -> ReadOptions:
    """Return options for reading one of the sensors."""
    chosen = replace(options.chosen, sensor=(), sensors="one", extrinsics=None, clock_offset=())
    return replace(options, chosen=chosen)


def _list_one(path: Path, format: str | None, options: ReadOptions) -> Listing:
    if path.is_dir():
        return list_folder(path, format, options)
    if not path.is_file():
        raise NotFoundError(f"sensor: expected a file or folder, there is no {path.name}")
    return list_files([path], format, path.parent, options)
