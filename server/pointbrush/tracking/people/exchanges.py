"""Two people who have changed places are changed back once their clothes or statures tell it.

Who meets another is followed by place, and may take the other's.  Later both are well seen, each
dressed, or as tall, as the other: then they exchange their labels, in that frame on.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from pointbrush.tracking.people.observation import Observation
from pointbrush.tracking.people.person import Person
from pointbrush.tracking.people.stature import DECISIVE, ratio

CLEARLY, LIKE = 0.5, 0.7
"""How much more like the other's clothes, in the mean logarithm, than what has his label each has
to be, and how much less than usual at most."""
FRAMES = 3
"""Frames in which that has to be so, one after the other."""


def exchanged(
    sight: Observation, people: Sequence[Person], now: int
) -> Iterator[tuple[Person, Person, bool]]:
    """Pairs of people who are each clearly dressed, or as tall, as the other; and whether both
    statures tell it, for which one frame is enough."""
    seen = [f for f in people if f.named and len(sight.cells_of(f.label))]
    some = {f.label: sight.some(sight.cells_of(f.label)) for f in seen}
    tops = {f.label: f.top(sight) for f in seen}
    for one, other in combinations(seen, 2):
        own, cross = (
            [who.likeness(some[label]) for who, label in zip((one, other), labels, strict=True)]
            for labels in ((one.label, other.label), (other.label, one.label))
        )
        rather = min(np.subtract(cross, own))
        taller = (
            ratio(tops[one.label], other.stature, one.stature),
            ratio(tops[other.label], one.stature, other.stature),
        )
        dressed = rather > CLEARLY and sum(taller) > -DECISIVE
        tall = sum(taller) >= DECISIVE and min(taller) > 0 and rather > -CLEARLY
        certain = tall and min(taller) >= DECISIVE
        well = not (one.elsewhere(sight, now) or other.elsewhere(sight, now))
        if min(cross) > -LIKE and (certain or (well and (dressed or tall))):
            yield one, other, certain


def exchange(sight: Observation, people: Sequence[Person], now: int) -> None:
    """Change back who changed places, and doubt those of whom it is not certain yet."""
    pairs = list(exchanged(sight, people, now))
    for person in people:
        if not any(person in pair[:2] for pair in pairs):
            person.mistaken = 0
    for one, other, certain in pairs:
        one.mistaken, other.mistaken = one.mistaken + 1, other.mistaken + 1
        one.doubts.add(other.label)
        other.doubts.add(one.label)
        if certain or min(one.mistaken, other.mistaken) >= FRAMES:
            mine, others = sight.owner == one.label, sight.owner == other.label
            sight.owner[mine], sight.owner[others] = other.label, one.label
            one.become(other)
