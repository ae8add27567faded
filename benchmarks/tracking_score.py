"""How a run fared against the truth: IoU, survival, time, and whether the confidence was right."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from tracking_frames import LEAST, Frame

from pointbrush.tracking import FrameResult, Seed, TrackOptions
from pointbrush.tracking.interface import Method

SURVIVING, GOOD = 0.5, 0.8
"""IoU under which an object is lost, and over which it is good."""


@dataclass
class Score:
    """One entry per visible object-frame, and one per object in ``lasted`` and ``survived``."""

    iou: list[float] = field(default_factory=list)
    confidence: list[float] = field(default_factory=list)
    flagged: list[bool] = field(default_factory=list)
    wrong: list[float] = field(default_factory=list)
    """Confidence of each result most of whose points are another object's, visible or not."""
    ms: list[float] = field(default_factory=list)
    """CPU milliseconds per object, one entry per frame."""
    lasted: list[int] = field(default_factory=list)
    """Frames until the IoU was under ``SURVIVING``; all there are when it never was."""
    survived: list[bool] = field(default_factory=list)
    """Whether it never was."""
    last: list[float] = field(default_factory=list)
    """IoU in the last frame where the object is visible."""

    def run(self, frames: Sequence[Frame], method: Method) -> None:
        """Paint frame 0 with the truth, track to the end without help."""
        first = frames[0].truth
        labels = [n for n in np.unique(first).tolist() if n and np.sum(first == n) >= LEAST]
        seeds = [Seed(n, np.flatnonzero(first == n)) for n in labels]
        found: dict[int, list[tuple[int, float]]] = {label: [] for label in labels}
        options = TrackOptions(continue_lost=True)
        order, clock = range(len(frames)), _StepClock(frames)
        run = method.track(clock.frame, order, seeds, lambda _: None, options)
        for result in clock.timed(run):
            if result.frame:
                self._compare(frames[result.frame], result, found)
        self.ms += [1e3 * seconds / len(labels) for seconds in clock.seconds]
        for history in found.values():
            self._follow(history, len(frames))

    def _compare(
        self, frame: Frame, result: FrameResult, found: dict[int, list[tuple[int, float]]]
    ) -> None:
        for label, history in found.items():
            truth = frame.truth == label
            points = result.assignments.get(label, np.empty(0, np.int64))
            both = truth[points].sum()
            track = result.tracks.get(label)
            others = np.count_nonzero(frame.truth[points]) - both
            if track is not None and len(points) >= LEAST and 2 * others > len(points):
                self.wrong.append(track.confidence)
            if truth.sum() < LEAST:
                continue
            iou = float(both / (truth.sum() + len(points) - both))
            lost = track is None or track.state in ("lost", "occluded") or track.confidence < 0.5
            self.iou.append(iou)
            self.confidence.append(track.confidence if track else 0.0)
            self.flagged.append(lost)
            history.append((result.frame, iou))

    def _follow(self, history: list[tuple[int, float]], count: int) -> None:
        if not history:
            return
        end = next((frame for frame, iou in history if iou < SURVIVING), None)
        self.lasted.append(count if end is None else end)
        self.survived.append(end is None)
        self.last.append(history[-1][1])

    def quality(self) -> str:
        """Cells: IoU, frames until lost, share never lost, share held at the end, ms, p95."""
        held = np.mean(np.array(self.last) >= SURVIVING)
        return (
            f"{np.mean(self.iou):.3f} | {np.mean(self.lasted):.0f} | {np.mean(self.survived):.2f} "
            f"| {held:.2f} | {np.median(self.ms):.1f} | {np.percentile(self.ms, 95):.0f}"
        )

    def calibration(self) -> str:
        """Cells: of sure frames the share that is good, of bad ones the share flagged; counts."""
        iou, sure = np.array(self.iou), np.array(self.confidence) > 0.9
        bad, flagged = iou < SURVIVING, np.array(self.flagged)
        return (
            f"{_share(iou[sure] > GOOD)} | {np.mean(sure):.2f} "
            f"| {_share(flagged[bad])} | {_share(flagged[iou > GOOD])}"
        )


class _StepClock:
    """CPU ``seconds`` of each step of a run, from its asking for a new frame to the next.

    Between two results there may be several steps, as a method may hold results back.
    """

    def __init__(self, frames: Sequence[Frame]) -> None:
        self.seconds: list[float] = []
        self._frames, self._newest, self._clock = frames, 0, 0.0
        self._begun = False

    def frame(self, number: int) -> Frame:
        """A frame; the first to be asked for after the newest until now begins a step."""
        if self._begun and number > self._newest:
            self._count()
            self._newest = number
            self.seconds.append(0.0)
        return self._frames[number]

    def timed(self, run: Iterator[FrameResult]) -> Iterator[FrameResult]:
        """The results; what is done with them takes no time, nor what comes before the first."""
        for result in run:
            self._count()
            yield result
            self._begun, self._clock = True, time.process_time()
        self._count()

    def _count(self) -> None:
        now = time.process_time()
        if self.seconds:
            self.seconds[-1] += now - self._clock
        self._clock = now


def together(scores: Iterable[Score]) -> Score:
    """One score over several kinds."""
    total = Score()
    for score in scores:
        for name in vars(total):
            getattr(total, name).extend(getattr(score, name))
    return total


def _share(which: np.ndarray) -> str:
    return f"{np.mean(which):.2f} of {len(which)}" if len(which) else "none"
