"""Labelled frames on their way to a file, in source order."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.formats import LabeledFrame
from pointbrush.frame import PointFrame
from pointbrush.labels import LabelStore
from pointbrush.sequences import Sequence, StoredFrame


def source_frame(recording: Sequence, index: int) -> PointFrame:
    """A stored frame as it was in its file: source order, source coordinates, exact."""
    stored: StoredFrame = recording[index]
    manifest = recording.manifest
    pose, shift = manifest.poses[index], np.asarray(manifest.shift)
    return PointFrame(
        xyz=stored.source_xyz(),
        rgb=None if stored.rgb is None else stored.to_source(stored.rgb),
        intensity=None if stored.intensity is None else stored.to_source(stored.intensity),
        instance=None if stored.instance is None else stored.to_source(stored.instance),
        pose=None if pose is None else np.array(pose).reshape(4, 4),
        viewpoint=None if stored.viewpoint is None else stored.viewpoint + shift,
        timestamp=manifest.timestamps[index],
    )


def labeled_frames(store: LabelStore, recording: Sequence, frames: range) -> Iterator[LabeledFrame]:
    """Each frame of ``frames`` with its annotation and tracks, one at a time."""
    sequence = recording.manifest.id
    tracks: dict[int, list[dict[str, Any]]] = {}
    for track in store.tracks(sequence):
        tracks.setdefault(int(track["frame"]), []).append(track)
    for index in frames:
        stored = recording[index]
        values = store.values(sequence, index)
        yield LabeledFrame(
            index=index,
            points=source_frame(recording, index),
            label=stored.to_source(values.label),
            provenance=stored.to_source(values.provenance),
            deleted=stored.to_source(values.deleted),
            tracks=tracks.get(index, []),
            up=recording.manifest.T_room_local[1, :3],
        )


def parse_frames(text: str | None, count: int) -> range:
    """``I:J`` (J not included, either may be left out), ``I``, or None for all frames.

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
