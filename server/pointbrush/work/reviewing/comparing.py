"""Agreement of two recordings of the same points, labelled by two people, with a picture."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from enum import IntEnum
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.labels import Label, LabelStore
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences import source_blocks
from pointbrush.values.team.review import Agreement, FrameAgreement, LabelAgreement
from pointbrush.work.annotate.layers import KeptAnnotation

Names = Mapping[int, str]
"""Key for the comparison by label: name or category; for 0, no label, it is ""."""
BITS = 16
SIZE = 720
"""Longer side of the picture, pixels."""
DOT = 2
"""Side of a drawn point, pixels; differing points have twice the side."""
MARGIN = 0.15
"""Margin around the labelled points, as a share of their extent."""
OUTLIERS = 1.0
"""Percent of points at each end that the shown extent ignores."""
BACKGROUND = (17, 19, 24)
By = Literal["name", "category"]
SAME_PLACE = 1e-3
"""Allowed difference between bounds of two imports of the same points, metres."""


def pairs(first: NDArray[np.uint16], second: NDArray[np.uint16]) -> Counter[tuple[int, int]]:
    """Return the number of points of each pair of label ids; both (N,)."""
    joined = first.astype(np.uint32) << BITS | second
    values, numbers = np.unique(joined, return_counts=True)
    return Counter(
        {
            (int(value) >> BITS, int(value) & 0xFFFF): int(number)
            for value, number in zip(values, numbers, strict=True)
        }
    )


def agreement(
    frames: Mapping[int, Counter[tuple[int, int]]], first: Names, second: Names
) -> Agreement:
    """Return the agreement for each frame's pairs of label ids, compared by name."""
    alone: tuple[Counter[str], Counter[str]] = (Counter(), Counter())
    both: Counter[str] = Counter()
    by_frame = []
    for frame, counts in sorted(frames.items()):
        labelled = differ = 0
        for (mine, theirs), points in counts.items():
            a, b = first.get(mine, ""), second.get(theirs, "")
            alone[0][a] += points
            alone[1][b] += points
            labelled += points if a or b else 0
            if a == b:
                both[a] += points
            else:
                differ += points
        by_frame.append(FrameAgreement(frame, labelled, differ))
    names = sorted((alone[0].keys() | alone[1].keys()) - {""}, key=str.lower)
    labels = tuple(_label(n, alone[0][n], alone[1][n], both[n]) for n in names)
    labelled, differ = (sum(getattr(f, n) for f in by_frame) for n in ("labelled", "differ"))
    return Agreement(
        miou=float(np.mean([each.iou for each in labels])) if labels else None,
        same=1 - differ / labelled if labelled else None,
        labels=labels,
        frames=tuple(by_frame),
    )


def _label(name: str, first: int, second: int, both: int) -> LabelAgreement:
    return LabelAgreement(name, both / max(1, first + second - both), first, second, both)


class Difference(IntEnum):
    """Comparison of two annotations at a point, in drawing order."""

    UNLABELLED = 0
    SAME = 1
    FIRST = 2
    SECOND = 3
    OTHER = 4


COLORS = {
    Difference.UNLABELLED: (58, 62, 72),
    Difference.SAME: (150, 156, 168),
    Difference.FIRST: (64, 156, 255),
    Difference.SECOND: (255, 159, 28),
    Difference.OTHER: (255, 64, 129),
}
"""Colours that are distinct with red-green colour blindness."""


def draw(places: NDArray[np.float64], what: NDArray[np.uint8]) -> bytes:
    """Return a PNG of points at (N, 2), right and down in metres; ``what`` (N,): differences."""
    from PIL import Image  # slow to import

    low, high = _window(places, what)
    scale = SIZE / max(float((high - low).max()), 1e-6)
    width, height = (max(1, int(np.ceil(side * scale))) for side in (high - low))
    canvas = np.empty((height, width, 3), np.uint8)
    canvas[:] = BACKGROUND
    pixels = np.floor((places - low) * scale).astype(np.int64)
    for kind, color in COLORS.items():
        _dots(canvas, pixels[what == kind], color, DOT * (1 + (kind >= Difference.FIRST)))
    out = io.BytesIO()
    Image.fromarray(canvas).save(out, "PNG")
    return out.getvalue()


def _window(
    places: NDArray[np.float64], what: NDArray[np.uint8]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the shown rectangle: the labelled points with a margin, or all points."""
    shown = places[what != Difference.UNLABELLED] if what.any() else places
    if not len(shown):
        return np.zeros(2), np.ones(2)
    low, high = np.percentile(shown, [OUTLIERS, 100 - OUTLIERS], axis=0)
    room = max(0.1, MARGIN * float((high - low).max()))
    return low - room, high + room


def _dots(
    canvas: NDArray[np.uint8], pixels: NDArray[np.int64], color: tuple[int, int, int], size: int
) -> None:
    height, width, _ = canvas.shape
    for right in range(size):
        for down in range(size):
            x, y = pixels[:, 0] + right, pixels[:, 1] + down
            inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
            canvas[y[inside], x[inside]] = color


def compare(
    store: LabelStore, first: Recording, second: Recording, by: By, frames: range
) -> Agreement:
    """Compare the labels of two recordings of the same points.

    ``by``: labels are equal by name, or by category.  Raises BadInputError for recordings of other
    points.
    """
    require_same_points(first, second)
    found = {frame: _pairs(store, first, second, frame) for frame in frames}
    names = (_names(store.palette(each.manifest.id), by) for each in (first, second))
    return agreement(found, *names)


def picture(store: LabelStore, first: Recording, second: Recording, by: By, frame: int) -> bytes:
    """Return a PNG with the differences of labels in a frame, from above.

    Raises BadInputError for recordings of other points, and for a frame stored as an octree.
    """
    require_same_points(first, second)
    if first.manifest.large:
        raise BadInputError("frame: expected one that is no octree, to draw all its points")
    names = [_names(store.palette(each.manifest.id), by) for each in (first, second)]
    # In source order and the first recording's room, as stored orders may differ.
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
    """Raise BadInputError unless two recordings have equal numbers of points and bounds."""
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
    """Yield labels in source order, in blocks; 0 for deleted points."""
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
    """Return the ``Difference`` of each point."""
    found = np.full(len(first), Difference.UNLABELLED, np.uint8)
    found[(first != "") & (first == second)] = Difference.SAME
    found[(first != "") & (second == "")] = Difference.FIRST
    found[(first == "") & (second != "")] = Difference.SECOND
    found[(first != "") & (second != "") & (first != second)] = Difference.OTHER
    return found
