"""Corrections: what one label painted again in the middle of a recording brings it and the others.

    python benchmarks/bench_corrections.py [--frames 60] [--at 10] [--seeds 1,2]
                                           [--kinds table-top,3-pins,6-pins,walking]

Frame 0 is painted with the truth and tracked to the end.  Then one label after another, each from
there anew, is painted with the truth in frame ``--at`` and tracked on alone, as a person does who
corrects one of several.  Prints the mean IoU over the object-frames after it (40 points or more in
the truth), before and after, of the label itself and of the others; and the processor time of a
correction, where nothing else is labelled and with all others, in one process.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from tracking_frames import LEAST, Frame
from tracking_recordings import KINDS, generated

from pointbrush.tracking import METHODS, FrameKnowledge, Seed, TrackOptions
from pointbrush.tracking.interface import PAINTED

TRACKED = 2
"""Provenance of a point that a run labelled."""
LEAD = 20
"""Frames before its start that a run goes through, as on a server."""


@dataclass
class Labels:
    """Label and provenance of each point of a frame, (N,) each."""

    label: NDArray[np.uint16]
    source: NDArray[np.uint8]

    def paint(self, label: int, points: NDArray[np.int64]) -> None:
        """A person says which points are the label's."""
        self.label[self.label == label] = 0
        self.label[points], self.source[points] = label, PAINTED

    def track(self, label: int, points: NDArray[np.int64]) -> None:
        """A run found the label in these points."""
        old = (self.label == label) & (self.source != PAINTED)
        self.label[old], self.source[old] = 0, 0
        self.label[points] = label
        self.source[points] = np.where(self.source[points] == PAINTED, PAINTED, TRACKED)

    def copy(self) -> Labels:
        """The same, of its own."""
        return Labels(self.label.copy(), self.source.copy())


@dataclass
class Recording:
    """Frames, and what is labelled in them."""

    frames: Sequence[Frame]
    known: list[Labels]

    def knowledge(self, number: int) -> FrameKnowledge:
        """As a label store gives it."""
        is_ = self.known[number].copy()
        return FrameKnowledge(is_.label, is_.source, np.zeros(len(is_.label), np.bool_))

    def paint(self, labels: Sequence[int], at: int) -> None:
        """Paint labels with the truth in a frame, and track them to the end."""
        truth = self.frames[at].truth
        seeds = [Seed(label, np.flatnonzero(truth == label)) for label in labels]
        for seed in seeds:
            self.known[at].paint(seed.label, seed.indices)
        before = tuple(range(max(0, at - LEAD), at))
        options = TrackOptions(continue_lost=True, before=before)
        order = range(at, len(self.frames))
        run = METHODS["auto"]().track(
            self.frames.__getitem__, order, seeds, self.knowledge, options
        )
        for found in list(run)[1:]:
            for label, points in found.assignments.items():
                self.known[found.frame].track(label, points)

    def alone(self, label: int) -> Recording:
        """The same with nothing but one label."""
        kept = [known.copy() for known in self.known]
        for known in kept:
            others = known.label != label
            known.label[others], known.source[others] = 0, 0
        return Recording(self.frames, kept)

    def iou(self, label: int, after: int) -> float:
        """Mean over the frames after one in which the label shows."""
        scores = []
        for frame, known in zip(self.frames[after + 1 :], self.known[after + 1 :], strict=True):
            truth, found = frame.truth == label, known.label == label
            if truth.sum() >= LEAST:
                scores.append(float((truth & found).sum() / (truth | found).sum()))
        return float(np.mean(scores)) if scores else np.nan


def main() -> None:
    """Print a line for each recording."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--at", type=int, default=10)
    parser.add_argument("--seeds", default="1,2")
    parser.add_argument("--kinds", default=",".join(KINDS))
    given = parser.parse_args()
    print(
        "| kind | seed | corrected: before | after | the others: before | after "
        "| s alone | s with others | ratio |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for kind in given.kinds.split(","):
        for seed in map(int, given.seeds.split(",")):
            frames = generated(kind, seed, given.frames)
            print(f"| {kind} | {seed} | {corrected(frames, given.at)} |", flush=True)


def corrected(frames: Sequence[Frame], at: int) -> str:
    """A line's figures."""
    nothing = [Labels(0 * f.truth, np.zeros(len(f.truth), np.uint8)) for f in frames]
    first = Recording(frames, nothing)
    truth = frames[0].truth
    labels = [n for n in np.unique(truth).tolist() if n and np.sum(truth == n) >= LEAST]
    first.paint(labels, 0)
    before = {label: first.iou(label, at) for label in labels}
    figures: list[tuple[float, ...]] = []
    for label in labels:
        if np.sum(frames[at].truth == label) < LEAST:
            continue
        spent = [_seconds(first.alone(label), label, at)]
        again = Recording(frames, [known.copy() for known in first.known])
        spent.append(_seconds(again, label, at))
        others = [n for n in labels if n != label]
        mean = [np.nanmean([before[n] for n in others])]
        mean.append(np.nanmean([again.iou(n, at) for n in others]))
        figures.append((before[label], again.iou(label, at), *map(float, mean), *spent))
    *quality, alone, beside = np.nanmean(figures, axis=0).tolist()
    parts = [f"{figure:.3f}" for figure in quality]
    return " | ".join([*parts, f"{alone:.2f}", f"{beside:.2f}", f"{beside / alone:.2f}"])


def _seconds(recording: Recording, label: int, at: int) -> float:
    """Processor time of painting a label and tracking it on."""
    start = time.process_time()
    recording.paint([label], at)
    return time.process_time() - start


if __name__ == "__main__":
    main()
