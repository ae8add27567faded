"""Two people who have changed places are changed back once their clothes or statures tell it.

Who meets another is followed by place, and may take the other's.  Later both are well seen, each
dressed, or as tall, as the other: then they exchange their labels, in that frame on.  So does who
is doubted with somebody without a label, who came since he was surely himself.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from pointbrush.tracking.people.observation import Observation
from pointbrush.tracking.people.person import Person
from pointbrush.tracking.people.stature import ratio


def exchanged(
    sight: Observation, people: Sequence[Person], now: int
) -> Iterator[tuple[Person, Person, bool]]:
    """Pairs of people who are each clearly dressed, or as tall, as the other; and whether both
    statures tell it, for which one frame is enough."""
    options = sight.options
    seen = [f for f in people if len(sight.cells_of(f.label))]
    some = {f.label: sight.some(sight.cells_of(f.label)) for f in seen}
    tops = {f.label: f.top(sight) for f in seen}
    for one, other in combinations(seen, 2):
        named = [(f, g) for f, g in ((one, other), (other, one)) if f.named]
        if not named or not all(g.named or _may_have_taken(f, g) for f, g in named):
            continue
        cross = [f.likeness(some[g.label]) for f, g in named]
        rather = min(np.subtract(cross, [f.likeness(some[f.label]) for f, _ in named]))
        taller = (
            ratio(tops[one.label], other.identity.stature, one.identity.stature),
            ratio(tops[other.label], one.identity.stature, other.identity.stature),
        )
        dressed = (
            rather > options.arrivals.exchange_log
            and sum(taller) > -options.stature.decisive_log_odds
        )
        tall = (
            sum(taller) >= options.stature.decisive_log_odds
            and min(taller) > 0
            and rather > -options.arrivals.exchange_log
        )
        certain = tall and min(taller) >= options.stature.decisive_log_odds
        well = not (one.elsewhere(sight, now) or other.elsewhere(sight, now))
        if min(cross) > -options.arrivals.exchange_usual_log and (
            certain or (well and (dressed or tall))
        ):
            yield one, other, certain


def _may_have_taken(person: Person, stranger: Person) -> bool:
    """Whether somebody may have the place of a stranger, who has his."""
    return bool(person.identity.doubts) and stranger.since > person.identity.sure


def exchange(sight: Observation, people: Sequence[Person], now: int) -> None:
    """Change back who changed places, and doubt those of whom it is not certain yet."""
    pairs = list(exchanged(sight, people, now))
    for person in people:
        if not any(person in pair[:2] for pair in pairs):
            person.mistaken = 0
    for one, other, certain in pairs:
        one.mistaken, other.mistaken = one.mistaken + 1, other.mistaken + 1
        if one.named and other.named:
            one.doubt(other)
        if certain or min(one.mistaken, other.mistaken) >= sight.options.arrivals.exchange_frames:
            mine, others = sight.owner == one.label, sight.owner == other.label
            sight.owner[mine], sight.owner[others] = other.label, one.label
            one.become(other)
            for stranger in (f for f in (one, other) if not f.named):
                stranger.since = now
