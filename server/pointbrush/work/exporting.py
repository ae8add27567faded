"""Labelled frames for export, in source order."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Collection, Iterable, Iterator
from collections.abc import Sequence as ListOf
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush import formats
from pointbrush.errors import BadInputError, DamagedError
from pointbrush.frame import FramePart, PointFrame
from pointbrush.labels import LabelStore
from pointbrush.labels.versions import PastLabels
from pointbrush.sequences import Sequence, StoredFrame, source_blocks
from pointbrush.work.annotate.layers import KeptAnnotation, require_layer

Columns = dict[str, NDArray[Any]]


SENT = ("xyz", "rgb", "intensity", "sensor")
"""Columns of a frame's points in REST responses."""
EXPORTED = (*SENT, "instance")
OF_SENSORS = ("sensor", "sensor_xyz", "pixel")
"""Further columns of recordings of several sensors."""
VERIFIED_AHEAD = 2 << 30
"""Bytes of frames with checksums verified before an export starts, which takes seconds."""
VALIDATION = 5
"""By default about one of so many recordings is for validation."""
NO_VALIDATION = "none"
"""Value of the option for no validation."""
BY_DEFAULT = "default: one recording in five by its id, never all of a workspace"
"""Reason of a default split in ``export.json``."""


def source_columns(
    recording: Sequence, index: int, names: Collection[str] = SENT
) -> Iterator[Columns]:
    """Yield exact columns of a frame in source order and coordinates, in consecutive blocks.

    Raises DamagedError, before the first block, if the frame's files have changed.
    """
    stored = recording[index]
    stored.verify(names)
    return source_blocks(stored, lambda first, stop: stored.read_source(first, stop, names))


def _point_frame(recording: Sequence, index: int, columns: Columns) -> PointFrame:
    stored, manifest = recording[index], recording.manifest
    of_sensors: dict[str, Any] = {}
    if stored.sensors:
        of_sensors = {name: columns.get(name) for name in OF_SENSORS}
        of_sensors |= {"sensors": stored.sensors, "parts": _parts(stored, manifest.shift)}
    return PointFrame(
        xyz=columns["xyz"],
        rgb=columns.get("rgb"),
        intensity=columns.get("intensity"),
        instance=columns.get("instance"),
        pose=stored.pose,
        viewpoint=None if stored.viewpoint is None else stored.viewpoint + manifest.shift,
        timestamp=stored.timestamp,
        **of_sensors,
    )


def _parts(stored: StoredFrame, shift: ListOf[float]) -> tuple[FramePart, ...]:
    """Return the parts of a frame with their mounts in source coordinates."""
    parts = []
    for part in stored.parts:
        T_frame_sensor = part.T_frame_sensor.copy()
        T_frame_sensor[:3, 3] += shift
        parts.append(FramePart(part.sensor, T_frame_sensor, part.timestamp, part.camera))
    return tuple(parts)


def require_sensor(recording: Sequence, name: str) -> None:
    """Raise BadInputError unless ``name`` is one of several sensors of a recording."""
    known = [sensor.name for sensor in recording.manifest.sensors]
    if name not in known:
        raise BadInputError(
            f"sensor: expected one of {', '.join(known) or 'several, the recording has one'}, got "
            f"{name[:80]!r}"
        )


def require_whole(recording: Sequence, frames: range) -> None:
    """Raise DamagedError if a frame of ``frames`` is found damaged before the export.

    All files must exist with their original size; checksums are verified up to VERIFIED_AHEAD.
    """
    compared = 0
    for index in frames:
        stored = recording[index]
        if compared < VERIFIED_AHEAD:
            compared += stored.verify(EXPORTED)


def labeled_frames(
    store: LabelStore | PastLabels,
    recording: Sequence,
    frames: range,
    gaps: list[str] | None = None,
    above: float = 0.0,
) -> Iterator[formats.ExportFrame]:
    """Yield each frame of ``frames`` with its annotation and tracks.

    A frame stored as an octree has blocks.  A damaged frame is left out and added to ``gaps``;
    without ``gaps`` it raises DamagedError.  ``above``: see KeptAnnotation.
    """
    sequence, up = recording.manifest.id, recording.manifest.T_room_local[1, :3]
    tracks: dict[int, list[dict[str, Any]]] = {}
    for track in store.tracks(sequence):
        tracks.setdefault(int(track["frame"]), []).append(track)
    for index in frames:
        try:
            large = _open(recording, index)
        except DamagedError as error:
            if gaps is None:
                raise
            gaps.append(str(error))
            continue
        kept = KeptAnnotation(store, sequence, index, above=above)
        read = partial(_blocks, recording, index, kept, tracks.get(index, []), up)
        if not large:
            yield from read()
            continue
        yield formats.BlockedFrame(
            index=index,
            count=recording[index].count,
            kept=int(kept.sizes.sum()),
            sizes=kept.sizes,
            read=read,
            tracks=tracks.get(index, []),
            up=up,
            header=recording.source_header(index),
            rows=recording.source_rows(index),
            dropped=recording.manifest.dropped[index],
            recording=sequence,
        )


def _open(recording: Sequence, index: int) -> bool:
    """Verify a frame's checksums; return whether it is an octree.  Raises DamagedError."""
    stored = recording[index]
    stored.verify(EXPORTED)
    return stored.large


def _blocks(
    recording: Sequence,
    index: int,
    kept: KeptAnnotation,
    tracks: list[dict[str, Any]],
    up: NDArray[np.float64],
) -> Iterator[formats.LabeledFrame]:
    """Yield blocks of a frame with its annotation in source order."""
    stored = recording[index]
    header, rows = recording.source_header(index), recording.source_rows(index)
    names = {*EXPORTED, *(OF_SENSORS if stored.sensors else ())}

    def read(first: int, stop: int) -> Columns:
        columns = stored.read_source(first, stop, names)
        return columns | kept.read(first, stop)

    first = 0
    for columns in source_blocks(stored, read):
        part = slice(first, first + len(columns["label"]))
        first = part.stop
        frame = formats.LabeledFrame(
            index=index,
            points=_point_frame(recording, index, columns),
            label=columns["label"],
            provenance=columns["provenance"],
            deleted=columns["deleted"],
            tracks=tracks,
            up=up,
            other=recording.other_of(index, part.start, part.stop),
            header=header,
            rows=None if rows is None else rows[part],
            dropped=recording.manifest.dropped[index],
            recording=recording.manifest.id,
        )
        yield formats.with_sensor_fields(frame)


def layer_blocks(
    store: LabelStore | PastLabels, recording: Sequence, index: int, layer: str
) -> tuple[Iterator[NDArray[Any]], int]:
    """Return blocks of a frame's layer in source order, and the revision of its last change.

    Raises DamagedError, before the first block, if the stored order of points has changed.
    """
    require_layer(layer)
    stored = recording[index]
    stored.verify(())
    kept = KeptAnnotation(store, recording.manifest.id, index, (layer,))
    return (columns[layer] for columns in source_blocks(stored, kept.read)), kept.revision


def parse_frames(text: str | None, count: int) -> range:
    """Parse ``I:J`` (J excluded, both optional), ``I``, or None for all frames.

    Raises BadInputError for another form or a range outside the sequence.
    """
    if text is None or text == "":
        return range(count)
    try:
        if ":" in text:
            first, last = text.split(":")
            start, stop = int(first or 0), int(last) if last else count
        else:
            start, stop = int(text), int(text) + 1
    except ValueError:
        raise BadInputError(f"frames: expected I:J or I, got {text!r}") from None
    if not 0 <= start < stop <= count:
        raise BadInputError(
            f"frames: expected a range within 0:{count} that is not empty, got {text!r}"
        )
    return range(start, stop)


def choose_split(
    format: str, validation: str | None, recording: Sequence, known: Callable[[], Collection[str]]
) -> formats.Split:
    """Return the frames for validation, given by ``validation`` or by default.

    ``validation`` is a range of frames ``I:J``, comma-separated ids of recordings (all frames), or
    ``none``.  By default, all frames of about one in five of the ``known`` recordings.  Raises
    BadInputError for a format without splits, a range outside the recording, or an unknown id.
    """
    name, count = recording.manifest.id, len(recording)
    if not formats.EXPORTS[format].splits:
        if validation is not None:
            able = ", ".join(entry.name for entry in formats.EXPORTS.values() if entry.splits)
            raise BadInputError(f"val: expected one of the formats {able} with it, got {format}")
        return formats.Split()
    if validation is None:
        val = name in _validation(known())
        return formats.Split(range(count if val else 0), BY_DEFAULT)
    if ":" in validation:
        return formats.Split(parse_frames(validation, count), f"frames {validation}")
    wanted = set() if validation == NO_VALIDATION else set(validation.split(","))
    if unknown := wanted - set(known()):
        raise BadInputError(
            f"val: expected frames I:J, ids of recordings, or {NO_VALIDATION}, got "
            f"{', '.join(sorted(unknown))[:80]!r}"
        )
    return formats.Split(range(count if name in wanted else 0), f"recordings {validation}")


def _validation(known: Collection[str]) -> set[str]:
    """Return recordings for validation by a hash of their ids; none instead of all.

    Frames of a recording are similar: with frames in both splits, a model would be validated on its
    training data.
    """
    digests = {name: hashlib.sha256(name.encode()).digest()[:8] for name in known}
    chosen = {name for name in known if int.from_bytes(digests[name], "big") % VALIDATION == 0}
    return chosen if len(chosen) < len(known) else set()


def split_frames(
    frames: Iterable[formats.ExportFrame], split: formats.Split
) -> Iterator[formats.ExportFrame]:
    """Yield frames with their split."""
    for frame in frames:
        yield replace(frame, split=split)
