"""Two people who have changed places are changed back once their clothes tell it.

Who meets another is followed by place, and where both are half hidden may take the other's.  Later
both are well seen, each dressed as the other: then they exchange their labels, in that frame on.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from pointbrush.tracking.people.observation import Observation
from pointbrush.tracking.people.person import Person

CLEARLY, LIKE = 0.5, 0.7
"""How much more like the other's clothes, in the mean logarithm, than what has his label each has
to be, and how much less than usual at most."""
FRAMES = 3
"""Frames in which that has to be so, one after the other."""


def exchanged(
    sight: Observation, people: Sequence[Person], now: int
) -> Iterator[tuple[Person, Person]]:
    """Pairs of people who are both well seen, each clearly dressed as the other."""
    if sight.tints is None:
        return
    seen = [f for f in people if f.named and f.worn is not None and not f.elsewhere(sight, now)]
    some = {f.label: sight.some(sight.cells_of(f.label)) for f in seen}
    for one, other in combinations(seen, 2):
        own, cross = (
            [who.likeness(some[label]) for who, label in zip((one, other), labels, strict=True)]
            for labels in ((one.label, other.label), (other.label, one.label))
        )
        if min(cross) > -LIKE and min(np.subtract(cross, own)) > CLEARLY:
            yield one, other


def exchange(sight: Observation, people: Sequence[Person], now: int) -> None:
    """Change back who changed places, and doubt those of whom it is not certain yet."""
    pairs = list(exchanged(sight, people, now))
    for person in people:
        if not any(person in pair for pair in pairs):
            person.mistaken = 0
    for one, other in pairs:
        one.mistaken, other.mistaken = one.mistaken + 1, other.mistaken + 1
        one.doubts.add(other.label)
        other.doubts.add(one.label)
        if min(one.mistaken, other.mistaken) >= FRAMES:
            mine, others = sight.owner == one.label, sight.owner == other.label
            sight.owner[mine], sight.owner[others] = other.label, one.label
            one.become(other)
