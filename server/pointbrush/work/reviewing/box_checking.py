"""Checks of a recording's boxes, with a cache of unchanged frames."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pointbrush.cache import Cache
from pointbrush.errors import DamagedError
from pointbrush.geometry.oriented_box import OrientedBox
from pointbrush.labels import LabelStore
from pointbrush.sequences import Sequence as Recording
from pointbrush.values.team.review import Finding
from pointbrush.work.reviewing.checks import boxes as checks
from pointbrush.work.reviewing.checks.boxes import BoxSketch, sketch_boxes
from pointbrush.work.reviewing.checks.finding import CheckOptions

REMEMBERED = 20_000
"""Limit of cached sketches of frames."""


class BoxChecker:
    """Checks boxes; caches sketches of frames until they change.  Thread-safe."""

    def __init__(self, store: LabelStore, options: CheckOptions) -> None:
        self._store, self._options = store, options
        self._known: Cache[tuple[str, int], tuple[Hashable, BoxSketch]] = Cache(REMEMBERED)

    def labels(self, sequence: str) -> set[int]:
        """Return the labels with boxes."""
        return {box.label for box in self._store.boxes.listing(sequence).boxes}

    def check(
        self, recording: Recording, frames: range, names: Mapping[int, str], unchecked: list[str]
    ) -> Iterator[Finding]:
        """Yield suspicious boxes in ``frames``; add a sentence about each unchecked frame."""
        boxes = self._store.boxes.listing(recording.manifest.id).boxes
        if not boxes:
            return
        beside = self._options.window + 1
        near = range(max(0, frames.start - beside), min(len(recording), frames.stop + beside))
        world = _poses(recording, near)
        yield from checks.jumps(names, boxes, world, self._options)
        yield from checks.sizes(names, boxes, self._options)
        yield from checks.headings(names, boxes)
        yield from checks.overlaps(names, boxes, frames, self._options)
        if not recording.manifest.large:  # reported by Checker
            sketches = self._sketches(recording, frames, boxes, unchecked)
            yield from checks.around(names, boxes, sketches, self._options)

    def _sketches(
        self,
        recording: Recording,
        frames: range,
        boxes: Sequence[OrientedBox],
        unchecked: list[str],
    ) -> dict[int, BoxSketch]:
        changes = self._store.frame_changes(recording.manifest.id)
        found: dict[int, BoxSketch] = {}
        for frame in frames:
            visible = [box for box in boxes if frame in box.poses]
            if not visible:
                continue
            key = (changes.get(frame, 0), *(_key(box, frame) for box in visible))
            place = (recording.placement, frame)
            known = self._known.known(place)
            if known is None or known[0] != key:
                try:
                    known = key, self._sketch(recording, frame, visible)
                except DamagedError as error:
                    if str(error) not in unchecked:
                        unchecked.append(str(error))
                    continue
                self._known.put(place, known)
            found[frame] = known[1]
        return found

    def _sketch(self, recording: Recording, frame: int, visible: list[OrientedBox]) -> BoxSketch:
        values, stored = self._store.values(recording.manifest.id, frame), recording[frame]
        label = np.where(values.deleted, np.uint16(0), values.label)
        xyz = stored.xyz.astype(np.float64) + np.array(recording.manifest.shift)
        return sketch_boxes(xyz, label, visible, frame, self._options)


def _key(box: OrientedBox, frame: int) -> Hashable:
    pose = box.poses[frame]
    return box.id, box.label, *box.size.tolist(), *pose.centre.tolist(), *pose.quaternion.tolist()


def _poses(recording: Recording, frames: range) -> dict[int, NDArray[np.float64]]:
    """Return ``T_world_frame`` of readable frames with a pose."""
    found = {}
    for frame in frames:
        try:
            pose = recording[frame].pose
        except DamagedError:
            continue
        if pose is not None:
            found[frame] = pose
    return found
