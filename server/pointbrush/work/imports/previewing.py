"""Preview of an import: format, order, rate, columns, poses, units and up, without writing."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor
from concurrent.futures import TimeoutError as FutureTimeoutError
from dataclasses import asdict
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, UnavailableError
from pointbrush.formats.cameras.pictures import PictureSource
from pointbrush.formats.geometry.alignment import agree_better_without
from pointbrush.formats.listing import Listing
from pointbrush.formats.options import Limits, ReadOptions
from pointbrush.formats.readers.las import read_chunks
from pointbrush.formats.registry import format_named
from pointbrush.formats.ros.bag import SENSOR
from pointbrush.formats.source import Source, open_source, reported
from pointbrush.formats.times.timing import ASSUMED
from pointbrush.frame import PointFrame
from pointbrush.jobs.worker import local_processes
from pointbrush.sequences.floor import Kind, find_floor
from pointbrush.sequences.room import nearest_axis
from pointbrush.values.imports import (
    FileFrame,
    Preview,
    PreviewedColumn,
    PreviewedFrame,
    PreviewedPoses,
    PreviewedSensor,
    PreviewedTopic,
    UnitGuess,
)
from pointbrush.work.imports.importing import (
    PART_POINTS,
    SINGLE_FPS,
    large_scan,
    no_points,
    up_source,
)
from pointbrush.work.imports.requests import ImportRequest

MOST_LISTED = 100
"""Limit of listed files."""
FRAMES = 3
"""Number of frames to read."""
SINGLE = "a single scan"
"""Source of the rate of a single frame."""
SURVEYS = ("las", "e57")
"""Formats with coordinates in metres or map units by definition."""
DEPTHS = ("rgbd",)
"""Formats with units known to the reader."""


SECONDS = 120.0
"""Timeout for reading the first frames."""
FAR = 1e4
"""Distance from the origin beyond which coordinates are map coordinates, metres."""
SAMPLE = 20_000
"""Number of points used to estimate the up axis."""


def preview(request: ImportRequest, limits: Limits) -> Preview:
    """Read the first frames of a recording and return a preview of its import.

    Raises the errors of ``open_source``, and BadInputError for unreadable frames.
    """
    chosen = request.chosen
    columns: dict[str, str] = {}

    def note(found: Mapping[str, str]) -> None:
        for column, meaning in found.items():
            columns.setdefault(column, meaning)

    with (
        reported() as warnings,
        open_source(request.paths, limits=limits, chosen=chosen, columns_found=note) as source,
    ):
        frames = _first_frames(request, limits, source.frames)
        if not any(len(frame) for frame in frames):
            raise no_points(source.origins, sum(frame.dropped for frame in frames))
        listing = source.listings[0]
        first = next(frame for frame in frames if len(frame))
        poses = _poses(listing, frames, warnings)
        units = guess_units(first.xyz, listing.format)
        # Unknown for files with several frames, as counting would read all of them; bags count.
        uncounted = not listing.topics and any(each.place for each in source.origins)
        count = None if uncounted else source.count
        fps, fps_from = source.rate(request.fps)
        if count == 1 and fps_from == ASSUMED:
            fps, fps_from = SINGLE_FPS, SINGLE
        up, up_from = _up(first, chosen.up)
        if chosen.scale == 1.0 and units.scale != 1.0:
            warnings.setdefault(
                f"the first frame is {max(units.extent):,.0f} units wide: they seem to be "
                f"{units.name}; scale {units.scale:g} makes them metres"
            )
        return Preview(
            name=request.name or source.name,
            format=listing.format,
            title=format_named(listing.format).title,
            frames=count,
            fps=fps,
            fps_from=fps_from,
            order=listing.order,
            files=_files(source),
            points=tuple(PreviewedFrame(len(f), f.dropped) for f in frames),
            columns=tuple(PreviewedColumn(*pair) for pair in columns.items()),
            topics=_topics(listing),
            cameras=tuple(_cameras(listing, source.pictures)),
            sensors=tuple(
                PreviewedSensor.of(each, name=each.sensor.name, type=each.sensor.type)
                for each in listing.sensors
            ),
            poses=poses,
            units=units,
            up=up,
            up_from=up_from,
            labels=any(frame.label is not None and frame.label.any() for frame in frames),
            corrections={k: v for k, v in asdict(chosen).items() if v not in (None, ())},
            warnings=tuple(warnings),
        )


def _files(source: Source) -> tuple[FileFrame, ...]:
    """Return the file of each frame, as far as known without reading all; at most MOST_LISTED."""
    names = [file.name for listing in source.listings for file in listing.frames]
    if source.count != len(names):
        names = [origin.file for origin in source.origins]
    return tuple(FileFrame(name, frame) for frame, name in enumerate(names[:MOST_LISTED]))


def _first_frames(
    request: ImportRequest, limits: Limits, frames: Iterator[PointFrame]
) -> list[PointFrame]:
    """Return the first frames, or the first part of a scan that is too large to read whole."""
    scan = large_scan(request.paths, limits)
    if scan is None:
        return list(islice(frames, FRAMES))
    options = ReadOptions(limits=limits, chosen=request.chosen)
    return [next(map(request.chosen.applied, read_chunks(scan, PART_POINTS, options)))]


def _up(frame: PointFrame, given: str | None) -> tuple[str, str]:
    """Return the coordinate axis nearest to up, as found by an import, and its source."""
    step = -(-len(frame) // SAMPLE)
    points = frame.xyz[::step].astype(np.float64)
    viewpoints = np.empty((0, 3)) if frame.viewpoint is None else frame.viewpoint[None]
    far = float(np.abs(points).max()) > FAR
    camera = frame.in_camera_axes
    kind: Kind = "camera" if camera else "survey" if far else "unknown"
    found = given or nearest_axis(find_floor(points, viewpoints, kind).up)
    return found, up_source(given, camera=camera, far=far)


def _topics(listing: Listing) -> tuple[PreviewedTopic, ...]:
    read = {topic.partition(SENSOR)[0] for topic in listing.topic.split(",")}
    return tuple(
        PreviewedTopic(each.name, each.type, each.count, each.has_clouds, each.name in read)
        for each in listing.topics
    )


def _cameras(listing: Listing, pictures: PictureSource | None) -> list[dict[str, Any]]:
    """Return the depth camera with properties of its images, or else the cameras of pictures."""
    if listing.depth is not None:
        return [{"name": "depth", "projects": True, **asdict(listing.depth)}]
    return [
        {"name": each.name, "projects": each.K is not None and each.T_camera_frame is not None}
        for each in (pictures.cameras if pictures is not None else ())
    ]


def _poses(
    listing: Listing, frames: Sequence[PointFrame], warnings: dict[str, None]
) -> PreviewedPoses | None:
    posed = [frame for frame in frames if frame.pose is not None]
    if not posed:
        return None
    source = listing.poses_from or "the frames' own files"
    worse = agree_better_without(posed)
    if worse:
        warnings.setdefault(
            f"consecutive frames match better without the poses of {source}; poses 'none' imports "
            "without them"
        )
    return PreviewedPoses(source, None if worse is None else not worse)


def guess_units(xyz: NDArray[Any], format: str) -> UnitGuess:
    """Guess the unit of coordinates (N, 3) by their extent; metres if it is ambiguous.

    Another unit is chosen only if metres are implausible: scanners have a range of a few hundred
    metres at most, and rooms are several metres wide in all directions.
    """
    low, high = np.quantile(xyz, [0.02, 0.98], axis=0)
    extent = (high - low).astype(np.float64)
    wide, thin = float(extent.max()), float(extent.min())
    name, scale = "metres", 1.0
    if format not in (*SURVEYS, *DEPTHS):
        if wide > 1000:
            name, scale = "millimetres", 0.001
        elif thin > 100:
            name, scale = "centimetres", 0.01
    x, y, z = extent.tolist()
    return UnitGuess(name, scale, (x, y, z))


class Previews:
    """Previews in a separate process, which a damaged file may crash; thread-safe."""

    def __init__(self) -> None:
        self._pool: ProcessPoolExecutor | None = None
        self._lock = threading.Lock()

    def of(self, request: ImportRequest, limits: Limits) -> Preview:
        """Preview a recording; raises the errors of ``preview``, UnavailableError on a timeout."""
        with self._lock:
            self._pool = self._pool or local_processes(1)
            pool = self._pool
        try:
            return pool.submit(preview, request, limits).result(SECONDS)
        except (BrokenExecutor, FutureTimeoutError) as error:
            self._end(pool)
            if isinstance(error, BrokenExecutor):
                raise BadInputError("expected readable files; the reader process crashed") from None
            raise UnavailableError(
                f"the first frames could not be read within {SECONDS:.0f} s"
            ) from None

    def close(self) -> None:
        """End the process."""
        with self._lock:
            pool, self._pool = self._pool, None
        if pool is not None:
            self._end(pool)

    def _end(self, pool: ProcessPoolExecutor) -> None:
        with self._lock:
            if self._pool is pool:
                self._pool = None
        processes = list((pool._processes or {}).values())
        pool.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.terminate()
