"""Two recordings of the same points, labelled by two people, side by side."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.labels import Label, LabelStore
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences import source_blocks
from pointbrush.work.annotate.kept import KeptAnnotation
from pointbrush.work.reviewing.confusion import Agreement, agreement, pairs
from pointbrush.work.reviewing.picture import Difference, draw

By = Literal["name", "category"]
SAME_PLACE = 1e-3
"""Metres that the bounds of two imports of the same points may differ by."""


def compare(
    store: LabelStore, first: Recording, second: Recording, by: By, frames: range
) -> Agreement:
    """Return how far the labels of two recordings of the same points agree.

    ``by``: labels are the same whose names are, or whose categories are.
    Raises BadInputError for recordings of other points.
    """
    require_same_points(first, second)
    found = {frame: _pairs(store, first, second, frame) for frame in frames}
    names = (_names(store.palette(each.manifest.id), by) for each in (first, second))
    return agreement(found, *names)


def picture(store: LabelStore, first: Recording, second: Recording, by: By, frame: int) -> bytes:
    """Return a PNG of a frame from above, in the room: where the labels differ.

    Raises BadInputError for recordings of other points, and for the frame of an octree.
    """
    require_same_points(first, second)
    if first.manifest.large:
        raise BadInputError("frame: expected one that is no octree, to draw all its points")
    names = [_names(store.palette(each.manifest.id), by) for each in (first, second)]
    # Both in the first one's room; stored order of the second may be another.
    stored = first[frame]
    labels = [
        _by_name(np.concatenate(list(_labels(store, each, frame))), known)
        for each, known in zip((first, second), names, strict=True)
    ]
    xyz = stored.to_source(stored.xyz).astype(np.float64)
    room = first.manifest.T_room_local
    above = xyz @ room[:3, :3].T + room[:3, 3]
    return draw(above[:, [0, 2]], _difference(*labels))


def require_same_points(first: Recording, second: Recording) -> None:
    """Raise BadInputError unless two recordings have the same frames of as many points there."""
    one, other = first.manifest, second.manifest
    if list(one.points) != list(other.points):
        raise BadInputError(
            f"with: expected a recording of the same points, {other.id!r} has other frames"
        )
    bounds = [np.array([each.lo, each.hi]) + np.array(each.shift) for each in (one, other)]
    if not np.allclose(bounds[0], bounds[1], rtol=0, atol=SAME_PLACE):
        raise BadInputError(
            f"with: expected a recording of the same points, those of {other.id!r} lie elsewhere"
        )


def _pairs(
    store: LabelStore, first: Recording, second: Recording, frame: int
) -> Counter[tuple[int, int]]:
    total: Counter[tuple[int, int]] = Counter()
    blocks = (_labels(store, each, frame) for each in (first, second))
    for mine, theirs in zip(*blocks, strict=True):
        total += pairs(mine, theirs)
    return total


def _labels(store: LabelStore, recording: Recording, frame: int) -> Iterator[NDArray[np.uint16]]:
    """Yield labels in source order, in blocks; deleted points have none."""
    kept = KeptAnnotation(store, recording.manifest.id, frame, ("label", "deleted"))
    for columns in source_blocks(recording[frame], kept.read):
        yield np.where(columns["deleted"], np.uint16(0), columns["label"])


def _names(palette: Sequence[Label], by: By) -> dict[int, str]:
    if by == "name":
        return {label.id: label.name.strip() for label in palette}
    return {label.id: label.category.strip() or label.name.strip() for label in palette}


def _by_name(label: NDArray[np.uint16], names: dict[int, str]) -> NDArray[np.str_]:
    table = np.full(1 << 16, "", dtype=f"U{max([1, *map(len, names.values())])}")
    for number, name in names.items():
        table[number] = name
    return table[label]


def _difference(first: NDArray[np.str_], second: NDArray[np.str_]) -> NDArray[np.uint8]:
    """Return what each point is: see ``Difference``."""
    found = np.full(len(first), Difference.UNLABELLED, np.uint8)
    found[(first != "") & (first == second)] = Difference.SAME
    found[(first != "") & (second == "")] = Difference.FIRST
    found[(first == "") & (second != "")] = Difference.SECOND
    found[(first != "") & (second != "") & (first != second)] = Difference.OTHER
    return found
