"""Agreement of two annotations of the same points."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Names = Mapping[int, str]
"""Key by which a label is compared: name or category; 0, no label, is "" and compared too."""
BITS = 16


@dataclass(frozen=True, slots=True)
class LabelAgreement:
    """Points that the first, the second, and both gave a label of this name; ``iou`` 0..1."""

    name: str
    first: int
    second: int
    both: int

    @property
    def iou(self) -> float:
        """Intersection over union."""
        return self.both / max(1, self.first + self.second - self.both)


@dataclass(frozen=True, slots=True)
class FrameAgreement:
    """Points of a frame that either labelled, and those of them that differ."""

    frame: int
    labelled: int
    differ: int


@dataclass(frozen=True, slots=True)
class Agreement:
    """Per label by name, per frame; ``miou`` is the mean over the names that either used.

    ``same``: the share of points with a label in either that have the same in both.
    """

    labels: Sequence[LabelAgreement]
    frames: Sequence[FrameAgreement]

    @property
    def miou(self) -> float | None:
        """Mean of the labels' IoU; None where neither has labelled anything."""
        return float(np.mean([each.iou for each in self.labels])) if self.labels else None

    @property
    def same(self) -> float | None:
        """Share of labelled points that agree; None where there are none."""
        labelled = sum(each.labelled for each in self.frames)
        differ = sum(each.differ for each in self.frames)
        return 1 - differ / labelled if labelled else None


def pairs(first: NDArray[np.uint16], second: NDArray[np.uint16]) -> Counter[tuple[int, int]]:
    """Return how many points have each pair of label ids; both (N,)."""
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
    """Return the agreement from each frame's pairs of label ids, labels compared by name."""
    alone: tuple[Counter[str], Counter[str]] = (Counter(), Counter())
    both: Counter[str] = Counter()
    told = []
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
        told.append(FrameAgreement(frame, labelled, differ))
    names = sorted((alone[0].keys() | alone[1].keys()) - {""}, key=str.lower)
    labels = [LabelAgreement(n, alone[0][n], alone[1][n], both[n]) for n in names]
    return Agreement(labels, told)
