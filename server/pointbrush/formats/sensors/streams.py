"""A recording of several sensors, from the recording of each."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.cameras.pictures import moved
from pointbrush.formats.listing import FrameFile, Listing
from pointbrush.formats.options import ReadOptions
from pointbrush.formats.sensors.clocks import MOST_FRAMES, changes, clock_offset
from pointbrush.formats.sensors.extrinsics import Extrinsics
from pointbrush.formats.sensors.joining import JoinedSensor, half_period, joined_frames
from pointbrush.formats.times.timing import SPINNING_FORMATS
from pointbrush.frame import FramePart, PointFrame, Sensor, join_sensors
from pointbrush.geometry.mounts import Matrix
from pointbrush.names import spelled_out
from pointbrush.values.kinds import LONGEST_NAME, MOST_SENSORS, SensorType

log = logging.getLogger(__name__)
Row = tuple[int | None, ...]
"""The frame of each sensor that is in a joined frame, or None."""


@dataclass(frozen=True, slots=True, eq=False)
class Stream:
    """The frames of one sensor, with its mount, type and clock.

    ``world``: ``T_world_sensor`` at each of its frames, in a world that all sensors share; the
    mounts of a joined frame then include the motion between the times of its sensors.
    """

    name: str
    listing: Listing
    known: Extrinsics
    world: Sequence[Matrix] | None = None

    @property
    def mount(self) -> Matrix:
        """The mount; raises BadInputError if it is unknown."""
        if self.known.T_frame_sensor is None:
            raise BadInputError(
                f"{self.name}: expected the mount of the sensor, got none; name a file with "
                "T_frame_sensor (--extrinsics)"
            )
        return self.known.T_frame_sensor

    @property
    def sensor(self) -> Sensor:
        """The sensor, with the type that is usual for its files if it is not stated."""
        format = self.listing.format
        usual: SensorType = "spinning" if format in SPINNING_FORMATS else "unknown"
        return Sensor(
            spelled_out(self.name), self.known.type or ("depth" if format == "rgbd" else usual)
        )

    @property
    def times(self) -> list[float] | None:
        """Times of its frames on the clock of the reference sensor, seconds."""
        own = self.listing.times
        return None if own is None else [time + (self.known.offset or 0.0) for time in own]


def join_streams(streams: Sequence[Stream], options: ReadOptions) -> Listing:
    """List the joined frames of several sensors: the frames of the first one, the reference.

    Warnings count the frames that join nothing.  Raises BadInputError for equal names, a sensor
    without a mount, sensors that cannot be joined, and one of which no frame joins.
    """
    names = [stream.sensor.name for stream in streams]
    too_long = max(map(len, names)) > LONGEST_NAME
    if too_long or len(set(names)) < len(names) or len(names) > MOST_SENSORS:
        raise BadInputError(
            f"sensors: expected up to {MOST_SENSORS} different names of up to {LONGEST_NAME} "
            f"characters, got {', '.join(names)[:300]}"
        )
    for stream in streams:
        _ = stream.mount
    first = streams[0].listing
    streams = [
        stream if k == 0 else _on_clock(streams[0], stream, options)
        for k, stream in enumerate(streams)
    ]
    found = [_joined(streams[0], each, options) for each in streams]
    rows: list[Row] = list(zip(*(numbers for _, numbers in found), strict=True))
    read = partial(_read, tuple(streams))
    if all(_is_one_each(stream.listing) for stream in streams):
        files = [
            FrameFile(file.name, partial(read, [row]))
            for file, row in zip(first.frames, rows, strict=True)
        ]
    else:
        files = [FrameFile(first.frames[0].name, partial(read, rows))]
    return replace(
        first,
        frames=files,
        pictures=moved(first.pictures, _reference_from_frame(streams[0], options.chosen.scale)),
        depth=None,
        sensors=tuple(joined for joined, _ in found),
    )


def _reference_from_frame(reference: Stream, scale: float) -> Matrix:
    """Return ``T_reference_frame`` in units of the files, of ``scale`` metres each."""
    T_reference_frame = np.asarray(np.linalg.inv(reference.mount), np.float64)
    T_reference_frame[:3, 3] /= scale
    return T_reference_frame


def _is_one_each(listing: Listing) -> bool:
    """Return whether each file is a frame."""
    return len(listing.frames) == listing.count


def _joined(
    reference: Stream, stream: Stream, options: ReadOptions
) -> tuple[JoinedSensor, list[int | None]]:
    """Find the frame of a sensor for each frame of the reference sensor."""
    count, own = reference.listing.count, stream.listing.count
    if count is None or own is None:
        raise BadInputError(
            f"{stream.name}: expected files with a known number of frames, got "
            f"{stream.listing.format} files; convert each frame to a file"
        )
    if stream is reference:
        return JoinedSensor(stream.sensor, count, 0, 0.0), list(range(count))
    at, times = reference.times, stream.times
    if options.chosen.by_order or (at is None and times is None):
        if count != own:
            raise BadInputError(
                f"{stream.name}: expected {count} frames, as {reference.name} has, or times of "
                f"the frames of both (timestamps.txt), got {own} frames"
            )
        return JoinedSensor(stream.sensor, own, 0), list(range(own))
    for each, known in ((reference, at), (stream, times)):
        if known is None or (np.diff(known) < 0).any():
            got = "none" if known is None else "times that go back"
            raise BadInputError(
                f"{each.name}: expected increasing times of its frames (timestamps.txt), got "
                f"{got}; by_order joins frames in their order"
            )
    return _by_time(reference, stream, at or [], times or [])


def _on_clock(reference: Stream, stream: Stream, options: ReadOptions) -> Stream:
    """Return a sensor with its clock offset, estimated from the first frames if it is asked for.

    A warning states the estimate.  Raises BadInputError if it is not clear.
    """
    at, times = reference.times, stream.times
    if stream.known.offset is not None:
        return stream
    if at is None or times is None:
        raise BadInputError(
            f"{stream.name if times is None else reference.name}: expected times of its frames "
            "(timestamps.txt) for an estimate of the clock offset, got none"
        )
    seen = [
        changes(_frames(each.listing, range(min(len(known), MOST_FRAMES)), options))
        for each, known in ((reference, at), (stream, times))
    ]
    found = clock_offset(seen[0], at, seen[1], times)
    if not found.is_clear:
        raise BadInputError(
            f"{stream.name}: expected motion that {reference.name} sees as well for an estimate of "
            f"the clock offset, got a correlation of {found.correlation:.2f} by {len(seen[1])} "
            "changes at best; name it in seconds (--clock-offset)"
        )
    log.warning(
        "%s: its clock offset is estimated from motion: %.3f s, by a correlation of %.2f",
        stream.name, found.seconds, found.correlation,
    )  # fmt: skip
    return replace(stream, known=replace(stream.known, offset=found.seconds))


def _by_time(
    reference: Stream, stream: Stream, at: list[float], times: list[float]
) -> tuple[JoinedSensor, list[int | None]]:
    found = joined_frames(at, times)
    apart = [abs(times[k] - at[i]) for i, k in enumerate(found) if k is not None]
    if not apart:
        raise BadInputError(
            f"{stream.name}: expected frames at the times of {reference.name}, "
            f"{at[0]:.3f} to {at[-1]:.3f} s, got {times[0]:.3f} to {times[-1]:.3f} s; if both "
            f"began together, its clock offset is {at[0] - times[0]:.3f} s "
            f"(--clock-offset {stream.name}={at[0] - times[0]:.3f})"
        )
    alone, without = len(times) - len(apart), len(at) - len(apart)
    if alone:
        log.warning(
            "%s: %d of %d frames are left out: no frame of %s that has none yet is within half a "
            "period, %.4g s",
            stream.name, alone, len(times), reference.name,
            half_period(np.array(at), np.array(times)),
        )  # fmt: skip
    if without:
        log.warning("%d of %d frames have no points of %s", without, len(at), stream.name)
    return JoinedSensor(stream.sensor, len(apart), alone, float(np.median(apart))), found


def _read(
    streams: tuple[Stream, ...], rows: Sequence[Row], options: ReadOptions
) -> Iterator[PointFrame]:
    """Yield the joined frames of ``rows``."""
    sensors = tuple(stream.sensor for stream in streams)
    frames = [
        _frames(stream.listing, [row[k] for row in rows], options)
        for k, stream in enumerate(streams)
    ]
    for row in rows:
        given = {k: next(frames[k]) for k, number in enumerate(row) if number is not None}
        parts = [(_part(streams, row, k, frame), frame) for k, frame in given.items()]
        (first, reference), *_ = parts
        pose = reference.pose
        joined = join_sensors(
            sensors,
            parts,
            pose=None if pose is None else pose @ np.linalg.inv(first.T_frame_sensor),
            timestamp=first.timestamp,
        )
        yield replace(joined, rows=_rows(list(given.values())))


def _part(streams: Sequence[Stream], row: Row, number: int, frame: PointFrame) -> FramePart:
    """Return a sensor's part of a joined frame, at its time on the clock of the recording."""
    offset, time = streams[number].known.offset, frame.timestamp
    time = time + offset if offset and time is not None else time
    return FramePart(number, _mount(streams, row, number), time)


def _rows(frames: Sequence[PointFrame]) -> NDArray[np.int64] | None:
    """Number the rows of all sources one after the other; None if all of them became points."""
    if all(frame.rows is None for frame in frames):
        return None
    found, first = [], 0
    for frame in frames:
        found.append(first + (np.arange(len(frame)) if frame.rows is None else frame.rows))
        first += len(frame) + frame.dropped
    return np.concatenate(found).astype(np.int64)


def _mount(streams: Sequence[Stream], row: Row, number: int) -> Matrix:
    """Return ``T_frame_sensor`` of a sensor in a joined frame."""
    first, stream = streams[0], streams[number]
    at, own = row[0], row[number]
    if not number or first.world is None or stream.world is None or at is None or own is None:
        return stream.mount
    T_reference_sensor = np.linalg.inv(first.world[at]) @ stream.world[own]
    return np.asarray(first.mount @ T_reference_sensor)


def _frames(
    listing: Listing, wanted: Sequence[int | None], options: ReadOptions
) -> Iterator[PointFrame]:
    """Yield the frames of the numbers ``wanted``, which increase; None for no frame."""
    numbers = [number for number in wanted if number is not None]
    if _is_one_each(listing):
        yield from (_only_frame(listing.frames[number], options) for number in numbers)
        return
    each = (f for file in listing.frames for f in file.read(replace(options, known=file.known)))
    done = 0
    for number in numbers:
        for frame in islice(each, number - done, number - done + 1):
            yield options.chosen.applied(frame)
        done = number + 1


def _only_frame(file: FrameFile, options: ReadOptions) -> PointFrame:
    """Read the frame of a file; raise BadInputError if it has several, or none."""
    frames = list(islice(file.read(replace(options, known=file.known)), 2))
    if len(frames) != 1:
        raise BadInputError(
            f"{file.name}: expected one frame a file in a recording of several sensors, got "
            f"{'several' if frames else 'none'}; write each frame to a file"
        )
    return options.chosen.applied(frames[0])
