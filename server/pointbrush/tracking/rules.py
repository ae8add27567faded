"""Which points of a frame a run may take, and which a person has already decided."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from pointbrush.tracking.interface import I64, PAINTED, FrameKnowledge, Known, Mask, TrackOptions

FEWEST = 10
"""Painted points under which a label does not count as painted in a frame."""


class FrameRules:
    """The rules of one frame of ``count`` points; ``taken`` grows as labels are assigned."""

    def __init__(self, count: int, knowledge: FrameKnowledge | None, asked: TrackOptions) -> None:
        self.count = count
        self._knowledge = knowledge
        self._options = asked
        self._taken = np.zeros(count, np.bool_)

    @property
    def _empty(self) -> bool:
        know = self._knowledge
        return know is None or not (know.label.any() or know.provenance.any() or know.deleted.any())

    def free(self, labels: Iterable[int]) -> Mask:
        """(N,) points that a run of ``labels`` may take and nobody else has taken."""
        know = self._knowledge
        free = ~self._taken
        if know is None or self._empty:
            return free
        mine = np.isin(know.label, list(labels)) & (know.label > 0)
        free &= ~know.deleted & ~np.isin(know.label, list(self._options.locked))
        if self._options.overwrite != "all":
            # A point painted with a label of this run stays, whoever finds it.
            free &= know.provenance != PAINTED
        if self._options.overwrite == "never":
            free &= mine | (know.label == 0)
        return free

    def anchors(self, label: int) -> I64:
        """Points painted with ``label``: certain, whatever a method finds."""
        know = self._knowledge
        if know is None or self._options.overwrite == "all":
            return np.empty(0, np.int64)
        return np.flatnonzero((know.label == label) & (know.provenance == PAINTED) & ~know.deleted)

    def keyframe(self, label: int) -> I64 | None:
        """All points of ``label`` where a person painted it in this frame, else None."""
        if len(self.anchors(label)) < FEWEST or self._knowledge is None:
            return None
        return np.flatnonzero((self._knowledge.label == label) & ~self._knowledge.deleted)

    def labelled(self) -> dict[int, I64]:
        """Label → its points, of labels that have enough of them."""
        if self._knowledge is None or self._empty:
            return {}
        label = np.where(self._knowledge.deleted, 0, self._knowledge.label)
        counts = np.bincount(label)
        counts[0] = 0
        return {n: np.flatnonzero(label == n) for n in np.flatnonzero(counts >= FEWEST).tolist()}

    def untouched(self, label: int) -> bool:
        """Whether nothing of ``label`` may be taken by those that have others."""
        return self._options.overwrite == "never" or label in self._options.locked

    def take(self, indices: I64) -> None:
        """No other label may have these points."""
        self._taken[indices] = True


def keyframes(
    order: Iterable[int], labels: Iterable[int], known: Known, asked: TrackOptions
) -> dict[int, list[int]]:
    """Label → positions in ``order`` (0 excepted) of the frames where a person painted it."""
    found: dict[int, list[int]] = {label: [] for label in labels}
    for position, number in enumerate(order):
        know = known(number) if position else None
        if know is None or asked.overwrite == "all":
            continue
        painted = know.label[(know.provenance == PAINTED) & ~know.deleted]
        counts = np.bincount(painted, minlength=1) if len(painted) else np.zeros(1, np.int64)
        for label, positions in found.items():
            if label < len(counts) and counts[label] >= FEWEST:
                positions.append(position)
    return found
