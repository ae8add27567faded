"""The state of each frame and label, replayed from the log of reviews."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from pointbrush.teamwork.reviews import Review
from pointbrush.values.kinds import time_of
from pointbrush.values.team.review import ReviewOverview, ReviewState, Standing

State = ReviewState
STATES: tuple[State, ...] = get_args(get_args(State)[0])
"""Not reviewed; waiting for a reviewer; accepted or rejected by a reviewer."""


_FIELDS = ("state", "note", "assignee")
Marks = dict[str, NDArray[np.int32]]


def replay(
    log: Sequence[Review], frames: int, palette: Collection[int], changes: Mapping[int, int]
) -> ReviewOverview:
    """Replay the log into the state of each frame and label of ``palette``, by accounts.

    ``changes``: the revision of the last change by frame, for changed frames.
    """
    changed = np.zeros(frames, np.int64)
    for frame, revision in changes.items():
        changed[frame] = revision
    marks: dict[int, Marks] = {0: _marks(frames)}
    whole: dict[int, Marks] = {}
    for index, entry in enumerate(log):
        if entry.label and entry.label not in palette:
            continue
        if entry.first is None or entry.last is None:
            _set(whole.setdefault(entry.label, _marks(1)), slice(0, 1), index, entry)
        else:
            part = slice(entry.first, entry.last + 1)
            _set(marks.setdefault(entry.label, _marks(frames)), part, index, entry)
    standings = [
        standing for label in sorted(marks) for standing in _runs(log, marks[label], label, changed)
    ]
    return ReviewOverview(
        _counts(standings, frames),
        tuple(standings),
        tuple(_standing(log, whole[label], 0, None, label) for label in sorted(whole)),
        (),
    )


def state_at(overview: ReviewOverview, frame: int, label: int = 0) -> Standing:
    """Return the review state of one frame, or of a label in it."""
    for each in overlapping(overview, frame, frame, label):
        return each
    return Standing(
        frame, frame, label or None, "open", note="", place=None, assignee="", by="", at=None,
        changed=False,
    )  # fmt: skip


def overlapping(overview: ReviewOverview, first: int, last: int, label: int) -> Iterator[Standing]:
    """Yield the states of frames ``first`` to ``last``, or of a label in them, by runs."""
    for each in overview.frames:
        if (each.label or 0) != label or each.first is None or each.last is None:
            continue
        if each.first <= last and first <= each.last:
            yield each


def accepted_all(overview: ReviewOverview, first: int, last: int, label: int) -> bool:
    """Return whether all frames, or a label in them, are accepted and unchanged since."""
    good = sum(
        min(last, each.last) - max(first, each.first) + 1
        for each in overlapping(overview, first, last, label)
        if each.state == "accepted" and not each.changed
        if each.first is not None and each.last is not None
    )
    return good == last - first + 1


def _marks(size: int) -> Marks:
    return {name: np.full(size, -1, np.int32) for name in _FIELDS}


def _set(marks: Marks, part: slice, index: int, entry: Review) -> None:
    for name in _FIELDS:
        if getattr(entry, name) is not None:
            marks[name][part] = index


def _runs(
    log: Sequence[Review], marks: Marks, label: int, changed: NDArray[np.int64]
) -> list[Standing]:
    """Return runs of consecutive frames with equal reviews, except frames without reviews."""
    revisions = np.array([entry.revision for entry in log] or [0], np.int64)
    decided = marks["state"]
    stale = (decided >= 0) & (changed > revisions[np.maximum(decided, 0)])
    rows = np.column_stack([*marks.values(), stale])
    starts = np.flatnonzero(np.r_[True, (rows[1:] != rows[:-1]).any(axis=1)])
    stops = np.r_[starts[1:], len(rows)]
    return [
        _standing(log, marks, int(start), int(stop) - 1, label, changed=bool(stale[start]))
        for start, stop in zip(starts, stops, strict=True)
        if (rows[start, : len(_FIELDS)] >= 0).any()
    ]


def _standing(
    log: Sequence[Review],
    marks: Marks,
    first: int,
    last: int | None,
    label: int,
    *,
    changed: bool = False,
) -> Standing:
    at = {name: int(marks[name][first]) for name in _FIELDS}
    note = log[at["note"]] if at["note"] >= 0 else None
    newest = max(at["state"], at["note"])
    return Standing(
        first=None if last is None else first,
        last=last,
        label=label or None,
        state=log[at["state"]].state if at["state"] >= 0 else "open",  # type: ignore[arg-type]
        note=(note.note or "") if note else "",
        place=note.place if note and note.note else None,
        assignee=(log[at["assignee"]].assignee or "") if at["assignee"] >= 0 else "",
        by=log[newest].author if newest >= 0 else "",
        at=time_of(log[newest].time) if newest >= 0 else None,
        changed=changed,
    )


def _counts(standings: Sequence[Standing], frames: int) -> dict[State, int]:
    counts: dict[State, int] = dict.fromkeys(STATES, 0)
    for each in standings:
        if each.label is None and each.first is not None and each.last is not None:
            counts[each.state] += each.last - each.first + 1
    counts["open"] += frames - sum(counts.values())
    return counts
