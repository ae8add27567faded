"""Bidirectional tracking between painted frames.

It wraps any method.  Frames of a label between two painted frames are tracked forward from the
first and backward from the second; the result changes from the forward to the backward run where
both agree best.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.tracking.duplicates import DistinctFrames, DistinctRun
from pointbrush.tracking.interface import (
    I64,
    FrameKnowledge,
    FrameResult,
    Frames,
    Known,
    Method,
    Seed,
    TrackOptions,
    TrackState,
)
from pointbrush.tracking.permissions import FrameRules, keyframes

Found = tuple[I64 | None, TrackState | None]


@dataclass(frozen=True)
class _Task:
    """Part of a run between painted frames."""

    frames: Frames
    order: Sequence[int]
    known: Known
    options: TrackOptions

    def rules(self, at: int) -> FrameRules:
        """Return the rules of the frame at a position in the order."""
        number = self.order[at]
        return FrameRules(len(self.frames(number).xyz), self.known(number), self.options)

    def known_with(self, at: int, found: Mapping[int, Found]) -> Known:
        """Return ``known`` with the labels ``found`` at a position of the order added."""
        number = self.order[at]

        def known(requested: int) -> FrameKnowledge | None:
            know = self.known(requested)
            if requested != number:
                return know
            count = len(self.frames(number).xyz)
            label = np.zeros(count, np.uint16) if know is None else know.label.copy()
            for n, (points, _) in found.items():
                if points is not None:
                    label[points] = n
            if know is None:
                return FrameKnowledge(label, np.zeros(count, np.uint8), np.zeros(count, np.bool_))
            return replace(know, label=label)

        return known


@dataclass(frozen=True)
class BothSides:
    """A ``method`` with checked inputs, run in both directions between painted frames."""

    method: Method

    def track(
        self,
        frames: Frames,
        order: Sequence[int],
        seeds: Sequence[Seed],
        known: Known,
        options: TrackOptions,
    ) -> Iterator[FrameResult]:
        """See ``Method.track``; raises BadInputError for a bad order or bad seeds."""
        check(frames, order, seeds)
        run = DistinctRun(DistinctFrames(frames), known, options)
        given, labels = run.seeds(order[0], seeds), [seed.label for seed in seeds]
        for result in self._between(run.frames, order, given, run.known, options):
            yield run.of_all(result, labels)

    def _between(
        self,
        frames: Frames,
        order: Sequence[int],
        seeds: Sequence[Seed],
        known: Known,
        options: TrackOptions,
    ) -> Iterator[FrameResult]:
        painted = keyframes(order, [s.label for s in seeds], known, options)
        if options.until_painted:
            ends = {label: (at[0] if at else len(order) - 1) for label, at in painted.items()}
            order = order[: max(ends.values()) + 1]
            painted = {label: at[:1] for label, at in painted.items()}
        else:
            ends = {label: len(order) - 1 for label in painted}
        task = _Task(frames, order, known, options)
        buffer: list[dict[int, Found]] = []
        sent = 0
        for result in self.method.track(frames, order, seeds, known, options):
            at = len(buffer)
            labels = [label for label in result.tracks if at <= ends[label]]
            buffer.append(
                {label: (result.assignments.get(label), result.tracks[label]) for label in labels}
            )
            for start, group in _closing(painted, at).items():
                self._meet(task, start, at, group, buffer)
            still_open = [p for positions in painted.values() for p in _open_since(positions, at)]
            ready = min([at + 1, *still_open])
            for position in range(sent, ready):
                yield _result(order[position], buffer[position])
            sent = max(sent, ready)

    def _meet(
        self, task: _Task, start: int, stop: int, labels: list[int], buffer: list[dict[int, Found]]
    ) -> None:
        """Replace the results after each label's meeting point by the backward run.

        ``start`` and ``stop``: positions of the painted frames at its ends.
        """
        rules = task.rules(stop)
        seeds = [
            Seed(label, points)
            for label in labels
            if (points := rules.keyframe(label)) is not None and len(points)
        ]
        if not seeds or stop - start < 2:
            return
        backward = list(task.order[start + 1 : stop + 1])[::-1]
        options = replace(task.options, until_painted=False, before=())
        known = task.known_with(stop, buffer[stop])
        run = self.method.track(task.frames, backward, seeds, known, options)
        results = list(run)[::-1]
        for label in labels:
            ahead = [buffer[p].get(label, (None, None)) for p in range(start + 1, stop + 1)]
            back = [(r.assignments.get(label), r.tracks.get(label)) for r in results]
            _rebase(back, ahead)
            for offset in range(meeting(ahead, back), len(back)):
                if offset < len(back) - 1:
                    buffer[start + 1 + offset][label] = back[offset]


def meeting(ahead: Sequence[Found], back: Sequence[Found]) -> int:
    """Return the number of first frames to take from ``ahead``; the others come from ``back``."""
    trust = [np.array([_confidence(f) for f in side]) for side in (ahead, back)]
    agree = np.array([_overlap(a[0], b[0]) for a, b in zip(ahead, back, strict=True)])
    best, at = -1.0, 0
    for m in range(len(ahead) + 1):
        seam = agree[max(m - 1, 0) : m + 1]
        score = float(trust[0][:m].sum() + trust[1][m:].sum() + (seam.mean() if len(seam) else 0))
        if score > best + 1e-9:
            best, at = score, m
    return at


def check(frames: Frames, order: Sequence[int], seeds: Sequence[Seed]) -> None:
    """Raise BadInputError unless each seed has points of the start frame, each label once."""
    if len(order) == 0:
        raise BadInputError("order: expected at least the start frame, got no frames")
    steps = np.diff(np.asarray(order))
    if len(steps) and not ((steps > 0).all() or (steps < 0).all()):
        raise BadInputError("order: expected frames in ascending or descending order")
    if not seeds:
        raise BadInputError("seeds: expected at least one label, got none")
    if len({seed.label for seed in seeds}) < len(seeds):
        raise BadInputError("seeds: expected each label once")
    _require(frames, order)
    count = len(frames(order[0]).xyz)
    for seed in seeds:
        if len(seed.indices) == 0:
            raise BadInputError(
                f"label {seed.label}: expected points in the start frame {order[0]}, got none"
            )
        if seed.indices.min() < 0 or seed.indices.max() >= count:
            raise BadInputError(
                f"label {seed.label}: expected point numbers 0 to {count - 1}, "
                f"got {seed.indices.min()} to {seed.indices.max()}"
            )


def _require(frames: Frames, order: Sequence[int]) -> None:
    """Raise BadInputError unless the recording has the frames at both ends of ``order``."""
    for number in (order[0], order[-1]):
        try:
            missing = number < 0 or frames(number) is None
        except LookupError:
            missing = True
        if missing:
            raise BadInputError(f"order: expected frames of the recording, got {number}")


def _closing(painted: dict[int, list[int]], at: int) -> dict[int, list[int]]:
    """Return labels with a segment that ends at ``at``, by start of the segment."""
    groups: dict[int, list[int]] = {}
    for label, positions in painted.items():
        if at in positions:
            before = [p for p in positions if p < at]
            groups.setdefault(before[-1] if before else 0, []).append(label)
    return groups


def _open_since(positions: list[int], at: int) -> list[int]:
    """Return the first frame that a backward run from a later painted frame may still change."""
    if not any(p > at for p in positions):
        return []
    return [max([p for p in positions if p <= at], default=0) + 1]


def _rebase(back: list[Found], ahead: Sequence[Found]) -> None:
    """Make backward poses relative to the run's start frame, through the painted frame."""
    end, first = ahead[-1][1], back[-1][1]
    if end is None or first is None:
        return
    for i, (points, track) in enumerate(back):
        if track is not None:
            back[i] = (points, replace(track, pose=track.pose @ end.pose))


def _confidence(found: Found) -> float:
    return 0.0 if found[1] is None or found[1].state == "lost" else found[1].confidence


def _overlap(a: I64 | None, b: I64 | None) -> float:
    if a is None or b is None or not len(a) or not len(b):
        return 0.0
    both = len(np.intersect1d(a, b, assume_unique=True))
    return both / (len(a) + len(b) - both)


def _result(frame: int, found: dict[int, Found]) -> FrameResult:
    taken: list[I64] = []
    assignments: dict[int, I64] = {}
    tracks: dict[int, TrackState] = {}
    for label, (points, track) in found.items():
        if points is not None:
            # Forward and backward runs may claim the same point: the first label keeps it.
            free = points
            if taken:
                free = np.setdiff1d(points, np.concatenate(taken), assume_unique=True)
            taken.append(free)
            assignments[label] = free
        if track is not None:
            tracks[label] = track if points is None else replace(track, points=len(free))
    return FrameResult(frame, assignments, tracks)
