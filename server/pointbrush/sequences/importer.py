"""Importing: frames → a folder on disk, all of it or nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.frame import PointFrame
from pointbrush.sequences.columns import POINT_FIELDS, encode_frame, frame_meta
from pointbrush.sequences.octree.ahead import WORKERS, ahead
from pointbrush.sequences.octree.arrays import digest, file_digest, map_npy, read_meta, write_arrays
from pointbrush.sequences.octree.coordinates import Coordinates
from pointbrush.sequences.octree.grid import GridChooser
from pointbrush.sequences.octree.large import LargeFrame
from pointbrush.sequences.pictures import write_pictures
from pointbrush.sequences.record import Record, RecordingInfo, make_manifest, record
from pointbrush.sequences.sensor_chunks import encode_sensors
from pointbrush.sequences.storage.checksums import CHECKSUMS, encode_checksums
from pointbrush.sequences.storage.files import new_folder, write_file
from pointbrush.sequences.storage.frame_files import FRAMES
from pointbrush.sequences.storage.manifest import FILE, Manifest, encode_manifest
from pointbrush.sequences.storage.source_fields import write_source_fields
from pointbrush.sequences.wire.chunk import Grid

if TYPE_CHECKING:
    from pointbrush.formats.cameras.pictures import PictureSource

Progress = Callable[[float, str], None]

LARGE_POINTS = 4_000_000
"""A frame of more points than this becomes an octree, and has no k-d tree.

A frame of several sensors never does: each may have so many points.
"""
JOINED_POINTS = 16_000_000
"""Most points in a frame of several sensors, which is read whole: about a gigabyte of memory."""

_PART_POINTS = 1_000_000
_THREADS = WORKERS + 1
"""Threads that store frames: while one waits for the disk, the others encode."""


def _silent(fraction: float, message: str) -> None:
    """Ignore the progress."""


def import_frames(
    frames: Iterable[PointFrame],
    target: Path,
    info: RecordingInfo,
    *,
    total: int | None = None,
    progress: Progress = _silent,
    pictures: PictureSource | None = None,
) -> Manifest:
    """Import ``frames`` into the new folder ``target``; they are consumed one by one.

    ``progress`` gets a fraction 0..1 and a message after each frame; an error from it cancels.
    ``pictures`` are stored with the frames.
    Nothing is left on any error.  Raises ConflictError when ``target`` exists, BadInputError
    when there is no frame, UnavailableError when the disk is full, and the errors of ``frames``.
    """
    with new_folder(target) as folder:
        (folder / FRAMES).mkdir()
        grid_of = GridChooser()
        records = []
        for stored in _store_all(frames, folder, grid_of):
            records.append(stored)
            done = len(records)
            count = f"{done} of {total}" if total and done <= total else f"{done}"
            progress(min(done / total, 1.0) if total else 0.0, f"imported {count} frames")
        if not records:
            raise BadInputError("expected at least one frame, got none")
        grid = grid_of.grid
        manifest = make_manifest(records, grid, info)
        kept = {} if pictures is None else write_pictures(folder, len(records), pictures.pictures())
        _complete(folder, manifest, records, kept)
    return manifest


def import_large(
    parts: Iterable[PointFrame],
    target: Path,
    info: RecordingInfo,
    *,
    total_points: int | None = None,
    progress: Progress = _silent,
) -> Manifest:
    """Import one frame that comes in ``parts`` (a million points each is good), in little memory.

    The parts have the same fields, one sensor, and are in the source's order.  A frame that turns
    out to fit in memory is stored like any other.  Errors as ``import_frames``.
    """
    parts = iter(parts)
    head: list[PointFrame] = []
    while sum(map(len, head)) <= LARGE_POINTS:
        part = next(parts, None)
        if part is None:
            frames = [join(head)] if head else []
            return import_frames(frames, target, info, total=1, progress=progress)
        head.append(part)
    with new_folder(target) as folder:
        (folder / FRAMES).mkdir()
        grid = GridChooser()(head)
        records = [_store_large(chain(head, parts), 0, grid, folder, total_points, progress)]
        manifest = make_manifest(records, grid, info)
        _complete(folder, manifest, records, {})
        progress(1.0, f"imported {manifest.points[0]:,} points")
    return manifest


def _complete(
    folder: Path, manifest: Manifest, records: list[Record], beside: Mapping[str, str]
) -> None:
    """Write manifest and checksums; ``beside``: checksums of files outside the records."""
    write_file(folder / FILE, encode_manifest(manifest))
    checksums = dict(beside)
    for stored in records:
        checksums |= stored.checksums
    write_file(folder / CHECKSUMS, encode_checksums(checksums))


def join(parts: list[PointFrame]) -> PointFrame:
    """One frame of all parts' points; pose, sensor and time are the first one's.

    Raises BadInputError when the parts' fields differ.
    """
    columns: dict[str, Any] = {}
    for name in ("xyz", *POINT_FIELDS):
        given = [getattr(part, name) for part in parts]
        missing = sum(column is None for column in given)
        if 0 < missing < len(parts):
            raise BadInputError(f"expected {name} in every part of the frame, or in none")
        columns[name] = None if missing else np.concatenate(given)
    return replace(
        parts[0],
        **columns,
        other=_join_other(parts),
        rows=None,
        dropped=sum(part.dropped for part in parts),
    )


def _join_other(parts: list[PointFrame]) -> dict[str, Any]:
    """Further fields that all parts have."""
    return {
        name: np.concatenate([part.other[name] for part in parts])
        for name in parts[0].other
        if all(name in part.other for part in parts)
    }


def split(frame: PointFrame) -> Iterator[PointFrame]:
    """A frame in parts of a million points."""
    for start in range(0, len(frame), _PART_POINTS):
        columns = {
            field.name: getattr(frame, field.name)[start : start + _PART_POINTS]
            for field in fields(frame)
            if field.name in ("xyz", *POINT_FIELDS) and getattr(frame, field.name) is not None
        }
        other = {name: v[start : start + _PART_POINTS] for name, v in frame.other.items()}
        dropped = frame.dropped if start == 0 else 0
        yield replace(frame, **columns, other=other, rows=None, dropped=dropped)


def _store_all(
    frames: Iterable[PointFrame], folder: Path, grid_of: GridChooser
) -> Iterator[Record]:
    """Store frames in order; reading the next ones overlaps with encoding."""

    def store(job: tuple[int, PointFrame, Grid]) -> Record:
        index, frame, grid = job
        return _store_frame(frame, index, grid, folder)

    jobs = ((index, frame, grid_of([frame])) for index, frame in enumerate(frames))
    with ThreadPoolExecutor(_THREADS, "import") as pool:
        yield from ahead(pool, store, jobs)


def _store_frame(frame: PointFrame, index: int, grid: Grid, folder: Path) -> Record:
    if frame.sensors:
        _require_small(frame)
    elif len(frame) > LARGE_POINTS:
        beside = write_source_fields(folder, index, replace(frame, other={}, header=None))
        stored = _store_large(split(frame), index, grid, folder, len(frame), _silent)
        return replace(stored, checksums=stored.checksums | beside)
    encoded = encode_sensors(frame, grid) if frame.sensors else encode_frame(frame, grid)
    stem = folder / FRAMES / f"{index:06d}"
    checksums = write_arrays(stem.with_suffix(".points"), encoded.arrays, frame_meta(frame))
    wire = stem.with_suffix(".wire")
    write_file(wire, encoded.wire)
    checksums[wire.name] = digest(encoded.wire)
    named = {f"{FRAMES}/{key}": value for key, value in checksums.items()}
    named |= write_source_fields(folder, index, frame)
    xyz, dropped = encoded.local, frame.dropped
    stored = record(frame, encoded.arrays, xyz, encoded.error, named, dropped=dropped, large=False)
    return replace(stored, side_error=encoded.side_error, color_error=encoded.color_error)


def _require_small(frame: PointFrame) -> None:
    """Raise BadInputError if a frame of several sensors, or one of them, has too many points."""
    names = [f"sensor {sensor.name}: " for sensor in frame.sensors]
    counts = np.bincount(frame.sensor, minlength=len(names)).tolist()  # type: ignore[arg-type]
    limits = [("", len(frame), JOINED_POINTS)]
    limits += [(name, n, LARGE_POINTS) for name, n in zip(names, counts, strict=True)]
    for name, count, most in limits:
        if count > most:
            raise BadInputError(
                f"{name}expected at most {most:,} points in a frame of several sensors, "
                f"got {count:,}: leave out sensors, or import each on its own"
            )


def _store_large(
    parts: Iterable[PointFrame],
    index: int,
    grid: Grid,
    folder: Path,
    total: int | None,
    progress: Progress,
) -> Record:
    first: list[PointFrame] = []
    dropped = 0

    def watched() -> Iterator[PointFrame]:
        nonlocal dropped
        for part in parts:
            first[:] = first or [replace(part, other={})]
            dropped += part.dropped
            yield part

    beside: dict[str, str] = {}

    def keep(part: PointFrame, number: int) -> None:
        beside.update(write_source_fields(folder, index, replace(part, rows=None), number))

    path = folder / FRAMES / f"{index:06d}"
    error = LargeFrame(path, progress, keep).write(watched(), grid, total)
    progress(0.98, "checksums")
    files = sorted([*path.iterdir(), path.with_suffix(".wire")])
    with ThreadPoolExecutor(WORKERS) as pool:
        digests = pool.map(file_digest, files)
        checksums = {
            str(file.relative_to(folder)): checksum
            for file, checksum in zip(files, digests, strict=True)
        }
    arrays = {file.stem: map_npy(file) for file in path.glob("*.npy")}
    checksums |= beside
    xyz = Coordinates(arrays, read_meta(path), grid.shift)
    return record(first[0], arrays, xyz, error, checksums, dropped=dropped, large=True)
