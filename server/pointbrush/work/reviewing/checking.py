"""All checks of a recording, with a cache of unchanged frames."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pointbrush.cache import Cache
from pointbrush.errors import DamagedError
from pointbrush.labels import FrameValues, Label, LabelStore
from pointbrush.labels.types import PREDICTED
from pointbrush.sequences import Sequence as Recording
from pointbrush.values.team.review import Checked, Finding
from pointbrush.work.reviewing.box_checking import BoxChecker
from pointbrush.work.reviewing.checks import counting, positions
from pointbrush.work.reviewing.checks.counting import Counts
from pointbrush.work.reviewing.checks.finding import KINDS, CheckOptions, grouped
from pointbrush.work.reviewing.checks.positions import Sketch, sketch_frame

REMEMBERED = 8
"""Limit of recordings with cached sketches."""
EXCUSED = ("occluded", "painted")
"""States of a track in which missing points are certain."""
Sketches = dict[int, Mapping[int, Sketch]]
Unsure = Mapping[int, tuple[int, int]]
"""By label: number of low-confidence predicted points, and of all predicted ones, if many are."""
Looked = tuple[int, Mapping[int, Sketch], Unsure]
"""The last changed revision of a frame at its check, and the results."""


class Checker:
    """Runs the checks; caches sketches of frames until they change.  Thread-safe."""

    def __init__(self, store: LabelStore, options: CheckOptions | None = None) -> None:
        self._store, self._options = store, options or CheckOptions()
        self._known: Cache[str, dict[int, Looked]] = Cache(REMEMBERED)
        self._boxes = BoxChecker(store, self._options)

    def check(self, recording: Recording, frames: range) -> Checked:
        """Return the findings in ``frames`` of a recording."""
        sequence, count = recording.manifest.id, len(recording)
        palette = self._store.palette(sequence)
        counts = _counts(self._store, sequence, palette, count)
        tracks = self._store.tracks(sequence)
        sketches, unsure, unchecked = self._sketches(recording, counts, frames)
        found = [
            *counting.same_names(palette, counts),
            *counting.no_category(palette, counts, self._boxes.labels(sequence)),
            *counting.few_points(palette, counts, self._options),
            *counting.unlike_neighbours(palette, counts, count, _excused(tracks), self._options),
            *counting.returns(palette, tracks, self._options),
            *counting.unsure_points(palette, unsure),
            *positions.stray_points(palette, sketches),
            *positions.jumps(palette, sketches, self._options),
        ]
        names = {label.id: label.name for label in palette}
        found.extend(self._boxes.check(recording, frames, names, unchecked))
        inside = [each for each in found if each.first is None or each.first in frames]
        placed = [_placed(each, sketches) for each in grouped(inside)]
        return Checked(tuple(sorted(placed, key=_order)), tuple(unchecked))

    def _sketches(
        self, recording: Recording, counts: Mapping[int, Counts], frames: range
    ) -> tuple[Sketches, dict[int, Unsure], list[str]]:
        """Return sketches of labelled frames and their neighbours."""
        if recording.manifest.large:
            return {}, {}, ["positions of points in octree frames"]
        beside = self._options.window + 1
        near = range(max(0, frames.start - beside), min(len(recording), frames.stop + beside))
        found: Sketches = {}
        unsure: dict[int, Unsure] = {}
        unchecked: list[str] = []
        changes = self._store.frame_changes(recording.manifest.id)
        for frame in near:
            if not any(mine[frame] for mine in counts.values()):
                continue
            try:
                found[frame], unsure[frame] = self._sketch(recording, frame, changes.get(frame, 0))
            except DamagedError as error:
                unchecked.append(str(error))
        return found, unsure, unchecked

    def _sketch(
        self, recording: Recording, frame: int, changed: int
    ) -> tuple[Mapping[int, Sketch], Unsure]:
        known = self._known.get(recording.identity, dict)
        there = known.get(frame)
        if there is not None and there[0] == changed:
            return there[1:]
        values = self._store.values(recording.manifest.id, frame)
        stored = recording[frame]
        label = np.where(values.deleted, np.uint16(0), values.label)
        shift = np.array(recording.manifest.shift)
        made = sketch_frame(stored.xyz, label, stored.pose, shift, self._options)
        unsure = _unsure(values, self._options)
        known[frame] = values.changed, made, unsure
        return made, unsure


def _unsure(values: FrameValues, options: CheckOptions) -> Unsure:
    predicted = (values.provenance == PREDICTED) & ~values.deleted
    every = np.bincount(values.label[predicted])
    few = np.bincount(
        values.label[predicted & (values.confidence < options.least_sure)], minlength=len(every)
    )
    many = np.flatnonzero((every > 0) & (few > options.unsure * every)).tolist()
    return {label: (int(few[label]), int(every[label])) for label in many}


def _counts(
    store: LabelStore, sequence: str, palette: Sequence[Label], frames: int
) -> dict[int, Counts]:
    counts = {label.id: np.zeros(frames, np.int64) for label in palette}
    for (frame, label), (points, _) in store.counts(sequence).items():
        if label in counts:
            counts[label][frame] = points
    return counts


def _excused(tracks: Sequence[Mapping[str, Any]]) -> dict[int, set[int]]:
    found: dict[int, set[int]] = {}
    for track in tracks:
        if track["state"] in EXCUSED:
            found.setdefault(int(track["label"]), set()).add(int(track["frame"]))
    return found


def _placed(finding: Finding, sketches: Sketches) -> Finding:
    """Return a finding with a place: its own, or its label's in its frame or a neighbour."""
    if finding.place is not None or finding.first is None or finding.last is None:
        return finding
    for place in _places(finding, sketches):
        return replace(finding, place=place)
    return finding


def _places(finding: Finding, sketches: Sketches) -> Iterator[tuple[float, float, float]]:
    assert finding.first is not None and finding.last is not None  # noqa: S101, PT018
    for frame in (finding.first, finding.first - 1, finding.last + 1):
        for label in reversed(finding.labels):
            if label in sketches.get(frame, {}):
                yield sketches[frame][label].center


def _order(finding: Finding) -> tuple[bool, int, int]:
    """Return the sort key: findings about the palette, then by frames."""
    return finding.first is not None, finding.first or 0, KINDS.index(finding.kind)
