"""Checks that need only the palette, the counts and the tracks."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.labels import Label
from pointbrush.values.team.review import Finding
from pointbrush.work.doubts import is_doubtful
from pointbrush.work.reviewing.checks.finding import CheckOptions, Kind, finding

NAMED = 3
"""Limit of labels named in a finding."""
UNSEEN = ("occluded", "lost")
"""States of a track that was not found in a frame."""
Counts = NDArray[np.int64]
"""Number of points of a label in each frame (F,)."""


def same_names(palette: Sequence[Label], counts: Mapping[int, Counts]) -> Iterator[Finding]:
    """Yield labels with equal names, also of different categories."""
    by_name: dict[str, list[Label]] = defaultdict(list)
    for label in palette:
        by_name[label.name.strip().casefold()].append(label)
    for labels in by_name.values():
        if len(labels) > 1:
            ids = tuple(label.id for label in labels)
            where = [int(np.flatnonzero(counts[n])[0]) for n in ids if counts[n].any()]
            frame = where[-1] if where else None
            text = f"{len(labels)} labels are called “{labels[0].name}”"
            yield finding("name", text, ids, frame, frame)


def no_category(
    palette: Sequence[Label], counts: Mapping[int, Counts], boxed: Collection[int]
) -> Iterator[Finding]:
    """Yield one finding for used labels without a category; ``boxed``: labels with boxes.

    A recording without boxes may use only names: there is no finding if no label has a category.
    """
    used = [label for label in palette if label.id in boxed or counts[label.id].any()]
    bare = [label for label in used if not label.category]
    if bare and (boxed or len(bare) < len(used)):
        yield _without("category", bare, "no category: exports write the name as a class")


def _without(kind: Kind, labels: Sequence[Label], lacking: str) -> Finding:
    """Return a finding about labels that lack something, with names of the first ones."""
    names = ", ".join(f"“{label.name}”" for label in labels[:NAMED])
    more = f" and {len(labels) - NAMED} more" if len(labels) > NAMED else ""
    have = "has" if len(labels) == 1 else "have"
    ids = tuple(label.id for label in labels)
    return finding(kind, f"{names}{more} {have} {lacking}", ids)


def few_points(
    palette: Sequence[Label], counts: Mapping[int, Counts], options: CheckOptions
) -> Iterator[Finding]:
    """Yield labels with few points in a frame, and one finding for labels without points."""
    empty = [label for label in palette if not counts[label.id].any()]
    if empty:
        yield _without("few", empty, "no points in any frame")
    for label in palette:
        mine = counts[label.id]
        for frame in np.flatnonzero((mine > 0) & (mine <= options.few_points)).tolist():
            points = "1 point" if mine[frame] == 1 else f"{mine[frame]} points"
            yield finding("few", f"“{label.name}” has only {points}", (label.id,), frame, frame)


def empty_frames(counts: Mapping[int, Counts], frames: int, options: CheckOptions) -> list[int]:
    """Return the unlabelled frames between labelled frames."""
    some = np.zeros(frames, bool)
    for mine in counts.values():
        some |= mine > 0
    return _holes(some, options.gap)


def unlike_neighbours(
    palette: Sequence[Label],
    counts: Mapping[int, Counts],
    frames: int,
    excused: Mapping[int, set[int]],
    options: CheckOptions,
) -> Iterator[Finding]:
    """Yield unlabelled frames, missing labels, and counts unlike in neighbouring frames.

    ``excused``: frames by label in which it is known to be invisible.
    """
    empty = empty_frames(counts, frames, options)
    for frame in empty:
        yield finding("unlike", "no labels here, but in the neighbouring frames", (), frame, frame)
    for label in palette:
        mine = counts[label.id]
        known = excused.get(label.id, set()) | set(empty)
        for frame in _holes(mine > 0, options.gap):
            if frame not in known:
                text = f"“{label.name}” is missing here, but not in the neighbouring frames"
                yield finding("unlike", text, (label.id,), frame, frame)
        yield from _odd_counts(label, mine, known, options)


def unsure_points(
    palette: Sequence[Label], unsure: Mapping[int, Mapping[int, tuple[int, int]]]
) -> Iterator[Finding]:
    """Yield labels with uncertain predictions.

    ``unsure``: number of uncertain and of all predicted points by frame and label.
    """
    names = {label.id: label.name for label in palette}
    for frame, labels in unsure.items():
        for label, (few, every) in labels.items():
            if label in names:
                text = f"“{names[label]}”: {few:,} of {every:,} predicted points are unsure"
                yield finding("predicted", text, (label,), frame, frame)


def returns(
    palette: Sequence[Label], tracks: Sequence[Mapping[str, Any]], options: CheckOptions
) -> Iterator[Finding]:
    """Yield labels that a track found again after it was out of sight, with lasting doubt.

    Each up to where it is out of sight once more, or was painted.
    """
    names = {label.id: label.name for label in palette}
    by_label: dict[int, dict[int, Mapping[str, Any]]] = {}
    for track in tracks:
        by_label.setdefault(int(track["label"]), {})[int(track["frame"])] = track
    for label in by_label.keys() & names.keys():
        mine = by_label[label]
        states = {frame: track["state"] for frame, track in mine.items()}
        for first in mine:
            if states.get(first - 1) not in UNSEEN or states[first] != "tracked":
                continue
            last = next(n for n in count(first) if states.get(n + 1) != "tracked")
            start = range(first, min(first + options.returned, last + 1))
            if all(is_doubtful(mine[frame]) for frame in start):
                text = f"Is this still “{names[label]}”? It was out of sight before."
                yield finding("returned", text, (label,), first, last)


def _odd_counts(
    label: Label, mine: Counts, known: set[int], options: CheckOptions
) -> Iterator[Finding]:
    for frame in np.flatnonzero(mine > options.few_points).tolist():
        near = mine[max(0, frame - options.window) : frame + options.window + 1]
        others = np.delete(near, min(frame, options.window))
        others = others[others > 0]
        if len(others) < options.window or frame in known:
            continue
        usual = float(np.median(others))
        if max(usual, mine[frame]) < options.sizable:
            continue
        if not options.share <= mine[frame] / usual <= 1 / options.share:
            text = f"“{label.name}” has {mine[frame]:,} points here, about {usual:,.0f} nearby"
            yield finding("unlike", text, (label.id,), frame, frame)


def _holes(there: NDArray[np.bool_], longest: int) -> list[int]:
    """Return indices in runs of at most ``longest`` False between True."""
    at = np.flatnonzero(there)
    return [
        frame
        for before, after in zip(at[:-1].tolist(), at[1:].tolist(), strict=True)
        if after - before - 1 <= longest
        for frame in range(before + 1, after)
    ]
