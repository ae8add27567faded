"""Agreement of the boxes of two recordings of the same points: average precision, recall, HOTA."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.geometry.box_overlap import iou_matrix
from pointbrush.geometry.oriented_box import OrientedBox
from pointbrush.labels import Label, LabelStore
from pointbrush.sequences import Sequence as Recording
from pointbrush.values.team.review import BoxAgreement, BoxScore, ClassAgreement
from pointbrush.work.reviewing.comparing import require_same_points

Floats = NDArray[np.float64]
AT = (0.5, 0.7)
"""3D IoU thresholds of equal boxes."""


@dataclass(frozen=True, slots=True, eq=False)
class _Set:
    """Boxes of a class in a frame: ``tracks`` (N,) ids, confidences, sizes, transforms."""

    tracks: NDArray[np.int64]
    confidence: Floats
    sizes: Floats
    transforms: Floats

    @classmethod
    def of(cls, boxes: Sequence[OrientedBox], frame: int) -> _Set:
        poses = [box.poses[frame] for box in boxes]
        return cls(
            np.array([box.label for box in boxes], np.int64),
            np.array([pose.confidence for pose in poses], np.float64),
            np.array([box.size for box in boxes], np.float64).reshape(-1, 3),
            np.array([pose.transform for pose in poses], np.float64).reshape(-1, 4, 4),
        )


@dataclass(frozen=True, slots=True, eq=False)
class _Pair:
    """Boxes of a class in a frame of both recordings, and their IoU (N, M)."""

    first: _Set
    second: _Set
    iou: Floats


def compare_boxes(
    store: LabelStore, first: Recording, second: Recording, frames: range
) -> BoxAgreement:
    """Compare boxes by class; the first recording's boxes are the ground truth.

    Raises BadInputError for recordings of other points.
    """
    require_same_points(first, second)
    sides = []
    for each in (first, second):
        name = each.manifest.id
        sides.append(_by_class(store.boxes.listing(name).boxes, store.palette(name)))
    names = sorted(sides[0].keys() | sides[1].keys(), key=str.lower)
    pairs = {
        name: [_pair(sides[0].get(name, []), sides[1].get(name, []), f) for f in frames]
        for name in names
    }
    classes = tuple(_class_agreement(name, each) for name, each in pairs.items())
    kept = tuple(each for each in classes if each.first or each.second)
    return BoxAgreement(kept, _hota(list(pairs.values())))


def _by_class(
    boxes: Iterable[OrientedBox], palette: Iterable[Label]
) -> dict[str, list[OrientedBox]]:
    names = {label.id: label.category.strip() or label.name.strip() for label in palette}
    found: dict[str, list[OrientedBox]] = {}
    for box in boxes:
        found.setdefault(names[box.label], []).append(box)
    return found


def _pair(mine: Sequence[OrientedBox], theirs: Sequence[OrientedBox], frame: int) -> _Pair:
    a, b = (_Set.of([box for box in e if frame in box.poses], frame) for e in (mine, theirs))
    return _Pair(a, b, iou_matrix(a.sizes, a.transforms, b.sizes, b.transforms))


def _class_agreement(name: str, pairs: Sequence[_Pair]) -> ClassAgreement:
    count, others = (sum(len(side.tracks) for side in e) for e in zip(*_sides(pairs), strict=True))
    overlaps = [iou for pair in pairs for _, iou in _matches(pair, 0.0).values()]
    scores = tuple(_score(pairs, at, count) for at in AT)
    return ClassAgreement(
        name, count, others, float(np.mean(overlaps)) if overlaps else None, scores
    )


def _sides(pairs: Sequence[_Pair]) -> Iterable[tuple[_Set, _Set]]:
    return ((pair.first, pair.second) for pair in pairs)


def _matches(pair: _Pair, least: float) -> dict[int, tuple[int, float]]:
    """Return matches of second to first boxes, highest confidence first, then IoU."""
    rows, columns = np.nonzero((pair.iou >= least) & (pair.iou > 0))
    order = np.lexsort((-pair.iou[rows, columns], -pair.second.confidence[columns]))
    found: dict[int, tuple[int, float]] = {}
    taken: set[int] = set()
    for row, column in zip(rows[order].tolist(), columns[order].tolist(), strict=True):
        if column not in found and row not in taken:
            found[column] = row, float(pair.iou[row, column])
            taken.add(row)
    return found


def _score(pairs: Sequence[_Pair], at: float, truth: int) -> BoxScore:
    confidence = np.concatenate([pair.second.confidence for pair in pairs] or [np.empty(0)])
    hit = np.zeros(len(confidence))
    start = 0
    for pair in pairs:
        hit[[start + column for column in _matches(pair, at)]] = 1
        start += len(pair.second.tracks)
    hits, boxes = float(hit.sum()), len(hit)
    precision, recall = hits / boxes if boxes else 0.0, hits / truth if truth else 0.0
    return BoxScore(at, _average_precision(confidence, hit, truth), precision, recall)


def _average_precision(confidence: Floats, hit: Floats, truth: int) -> float:
    """Return the area under the precision-recall curve; equal confidences form one step."""
    if not truth or not len(hit):
        return 0.0
    order = np.argsort(-confidence, kind="stable")
    last = np.flatnonzero(np.append(np.diff(confidence[order]) != 0, True))
    hits = np.cumsum(hit[order])[last]
    precision = np.maximum.accumulate((hits / (last + 1))[::-1])[::-1]
    return float(np.sum(np.diff(hits / truth, prepend=0.0) * precision))


def _hota(classes: Sequence[Sequence[_Pair]]) -> float | None:
    """Return HOTA of all classes; boxes of different classes never match."""
    try:
        with redirect_stdout(io.StringIO()):  # it prints missing optional packages
            from trackeval.metrics import HOTA
    except ImportError:
        return None
    per_frame = list(zip(*classes, strict=True))
    sides = [_numbered([[s[k] for s in _sides(row)] for row in per_frame]) for k in (0, 1)]
    totals = [sum(map(len, ids)) for ids, _ in sides]
    if not all(totals):
        return None
    data: dict[str, Any] = {"similarity_scores": [_blocks([p.iou for p in r]) for r in per_frame]}
    for kind, (ids, count), total in zip(("gt", "tracker"), sides, totals, strict=True):
        data |= {f"{kind}_ids": ids, f"num_{kind}_ids": count, f"num_{kind}_dets": total}
    data["num_timesteps"] = len(per_frame)
    with redirect_stdout(io.StringIO()):
        return float(np.mean(HOTA().eval_sequence(data)["HOTA"]))


def _numbered(frames: Sequence[Sequence[_Set]]) -> tuple[list[NDArray[np.int64]], int]:
    """Return numbers from 0 of the objects in each frame (N,), and the number of objects."""
    known: dict[int, int] = {}
    found = []
    for row in frames:
        tracks = [track for each in row for track in each.tracks.tolist()]
        found.append(np.array([known.setdefault(t, len(known)) for t in tracks], np.int64))
    return found, len(known)


def _blocks(parts: Sequence[Floats]) -> Floats:
    """Return a block-diagonal matrix."""
    whole = np.zeros(tuple(sum(part.shape[axis] for part in parts) for axis in (0, 1)))
    row = column = 0
    for part in parts:
        whole[row : row + part.shape[0], column : column + part.shape[1]] = part
        row, column = row + part.shape[0], column + part.shape[1]
    return whole
