"""What a run knows of its sensor, and of the scene that stands still before it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pointbrush.tracking.background import Background, ImageBackground, Waver, measure_waver
from pointbrush.tracking.earlier import TreeBackground
from pointbrush.tracking.interface import F32, I64, Frames
from pointbrush.tracking.view import View, find_lens

CALM = 4
"""Frames from which the noise of each place is measured."""
SURVEY = 16
"""Frames that are looked through for what large things hide."""


class Scene:
    """The frames ``order`` of a recording as one sensor sees them.

    ``first`` frame; ``lens`` of the sensor, or None; ``background`` as far as it was learnt.
    """

    def __init__(self, frames: Frames, order: list[int], reach: Callable[[F32], F32]) -> None:
        """``reach``: see ``TreeBackground``."""
        self._frames, self._order = frames, order
        poses = [frames(n).pose for n in (order[0], order[-1])]
        self._moves = poses[0] is not None and not (
            poses[1] is not None and np.allclose(poses[0], poses[1], atol=1e-6)
        )
        self.lens = find_lens(frames(order[0]))
        self.first = self.view(order[0])
        self._waver = Waver(0.004, 0.002)
        self.background: Background = TreeBackground(reach)
        if self.lens is not None and not self._moves:
            depth = self.first.depth
            if len(order) > 1:
                self._waver = measure_waver(depth, self.view(order[1]).depth)
            unknown = np.full_like(depth, np.nan)
            self.background = ImageBackground(self._waver, unknown, unknown, np.ones_like(unknown))

    def view(self, number: int) -> View:
        """Frame ``number`` with what is known of the sensor."""
        frame = self._frames(number)
        return View(number, frame, self.lens, frame.pose if self._moves else None)

    def noise(self, view: View, indices: I64) -> float:
        """Median depth noise at some points, metres."""
        if self.lens is None or not len(indices):
            return 0.0
        return float(np.median(self._waver(view.cells[1][indices])))

    def learn_first(self, *, survey: bool) -> None:
        """Take in the first frame, whose labels are a person's.

        ``survey``: learn what is behind large things from the whole recording.
        """
        if not isinstance(self.background, ImageBackground):
            self.background.learn(self.first, first=True)
            return
        self.background.calm(self.first, self._views(self._order[1:CALM]))
        self.background.learn(self.first, first=True)
        if survey:
            last = len(self._order) - 1
            apart = np.linspace(1, last, min(SURVEY, last)).astype(int)
            self.background.survey(self.first, self._views([self._order[i] for i in apart]))

    def _views(self, numbers: Sequence[int]) -> list[View]:
        return [self.view(number) for number in numbers]
