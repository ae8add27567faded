"""Surfaces that the model has looked at in the frames before."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.masks.people.options import PeopleOptions
from pointbrush.masks.people.segments import Place, Surface


@dataclass(slots=True)
class _Known:
    """A surface: its probability in frame ``looked``, and where it was in frame ``seen``."""

    middle: Place
    area: float
    chance: float
    looked: int
    seen: int


class Memory:
    """Probabilities of surfaces by their place and size, for some frames."""

    def __init__(self, options: PeopleOptions) -> None:
        self._options, self._frame, self._known = options, 0, list[_Known]()

    def begin_frame(self) -> None:
        """Forget old surfaces."""
        self._frame += 1
        self._known = [each for each in self._known if self._is_fresh(each)]

    def recall(self, group: list[Surface]) -> NDArray[np.float64] | None:
        """Return the probabilities (n,) of surfaces; None if too much of them is unknown.

        An unknown surface has the mean of the others.
        """
        found = [self._find(each) for each in group]
        counts = np.array([len(each.rows) for each in group])
        new = np.array([each is None for each in found])
        if not group or counts[new].sum() > self._options.new_share * counts.sum():
            return None
        for each, surface in zip(found, group, strict=True):
            if each is not None:
                each.middle, each.area, each.seen = surface.middle, surface.area, self._frame
        usual = float(np.mean([each.chance for each in found if each is not None]))
        return np.array([usual if each is None else each.chance for each in found])

    def remember(self, group: list[Surface], chance: NDArray[np.float64]) -> None:
        """Keep the probabilities (n,) of surfaces that the model has looked at."""
        for surface, each in zip(group, chance.tolist(), strict=True):
            known = _Known(surface.middle, surface.area, each, self._frame, self._frame)
            self._known.append(known)

    def _is_fresh(self, each: _Known) -> bool:
        unseen, unchecked = self._frame - each.seen, self._frame - each.looked
        return unseen <= self._options.forgotten and unchecked <= self._options.looked_again

    def _find(self, surface: Surface) -> _Known | None:
        least = self._options.least_resize
        for each in self._known:
            if math.dist(each.middle, surface.middle) > self._options.largest_step:
                continue
            if least <= each.area / surface.area <= 1 / least:
                return each
        return None
