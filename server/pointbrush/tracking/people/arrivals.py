"""People entering, returning, or exchanged with each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np
from scipy.spatial import cKDTree

from pointbrush.tracking.compute.graph import parts
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.model.appearance import ColourHistogram
from pointbrush.tracking.model.confidence import squashed
from pointbrush.tracking.people.observation import PersonObservation
from pointbrush.tracking.people.person import Person
from pointbrush.tracking.people.stature import beneath_heads, ratio, top_of


def find_exchanged_people(
    observation: PersonObservation, people: Sequence[Person], now: int
) -> Iterator[tuple[Person, Person, bool]]:
    """Yield exchanged pairs of people, by clothes or stature of each other.

    The third value is whether both statures are decisive, for which one frame is enough.
    """
    options = observation.options
    seen = [f for f in people if len(observation.cells_of(f.label))]
    some = {f.label: observation.some(observation.cells_of(f.label)) for f in seen}
    tops = {f.label: f.top(observation) for f in seen}
    for one, other in combinations(seen, 2):
        named = [(f, g) for f, g in ((one, other), (other, one)) if f.named]
        if not named or not all(g.named or _may_have_taken(f, g) for f, g in named):
            continue
        cross = [f.likeness(some[g.label]) for f, g in named]
        clothes_log_ratio = min(np.subtract(cross, [f.likeness(some[f.label]) for f, _ in named]))
        stature_log_odds = (
            ratio(tops[one.label], other.identity.stature, one.identity.stature),
            ratio(tops[other.label], one.identity.stature, other.identity.stature),
        )
        by_clothes = (
            clothes_log_ratio > options.arrivals.exchange_log
            and sum(stature_log_odds) > -options.stature.decisive_log_odds
        )
        by_stature = (
            sum(stature_log_odds) >= options.stature.decisive_log_odds
            and min(stature_log_odds) > 0
            and clothes_log_ratio > -options.arrivals.exchange_log
        )
        certain = by_stature and min(stature_log_odds) >= options.stature.decisive_log_odds
        both_visible = not (
            one.may_be_elsewhere(observation, now) or other.may_be_elsewhere(observation, now)
        )
        if min(cross) > -options.body.clearly_log and (
            certain or (both_visible and (by_clothes or by_stature))
        ):
            yield one, other, certain


def _may_have_taken(person: Person, stranger: Person) -> bool:
    """Return whether a person may have been exchanged with an unlabelled person."""
    return bool(person.identity.doubts) and stranger.since > person.identity.sure


def restore_exchanged_people(
    observation: PersonObservation, people: Sequence[Person], now: int
) -> None:
    """Restore exchanged people, and doubt pairs that are not certain yet."""
    pairs = list(find_exchanged_people(observation, people, now))
    for person in people:
        if not any(person in pair[:2] for pair in pairs):
            person.exchanged_frames = 0
    for one, other, certain in pairs:
        one.exchanged_frames, other.exchanged_frames = (
            one.exchanged_frames + 1,
            other.exchanged_frames + 1,
        )
        if one.named and other.named:
            one.doubt(other)
        if (
            certain
            or min(one.exchanged_frames, other.exchanged_frames)
            >= observation.options.arrivals.exchange_frames
        ):
            mine, others = observation.owner == one.label, observation.owner == other.label
            observation.owner[mine], observation.owner[others] = other.label, one.label
            one.exchange_identity(other)
            for stranger in (f for f in (one, other) if not f.named):
                stranger.since = now


Offer = tuple[I64, Person | None, I64 | None]
"""Cells that may be a person's, their former owner, and the owner's other cells if split by
heads."""


def return_missing_people(
    observation: PersonObservation, people: Sequence[Person], usual: float, now: int
) -> set[int]:
    """Assign bodies without a labelled owner to missing people, the most likely first.

    Returns the numbers of unlabelled people that were identified as one of them.
    """
    missing = [f for f in people if f.named and f.may_be_elsewhere(observation, now)]
    offers = _offers(observation, people, missing, usual, now) if missing else []
    ranked = _ranked(observation, missing, offers, now)
    found: set[int] = set()
    given: set[int] = set()
    identified: set[int] = set()
    recent = now - observation.options.arrivals.recent_frames
    unlabelled = [0, *(f.label for f in people if not f.named and f.since > recent)]
    for _, label, number in ranked:
        if label in found or number in given:
            continue
        found.add(label)
        given.add(number)
        cells, other, rest = offers[number]
        taken = _offered_bodies(observation, cells, other, unlabelled)
        person = next(f for f in missing if f.label == label)
        if other is not None and not other.named:
            identified.add(other.label)
            if person.at_side and person.frames_unseen:
                _adopt_newcomer(observation, person, other, cells, now)
        observation.owner[observation.owner == label] = 0
        observation.owner[taken] = label
        person.frames_unseen = max(person.frames_unseen, 1)
        if other is not None and rest is not None:
            person.doubt(other)
    return identified


def _ranked(
    observation: PersonObservation, missing: Sequence[Person], offers: Sequence[Offer], now: int
) -> list[tuple[float, int, int]]:
    """Return cost, label of a missing person and number of an offer, in ascending order of cost."""
    ranked = []
    for person in missing:
        for number, (cells, other, rest) in enumerate(offers):
            cost = None
            if _is_candidate(person, other) and _may_return(observation, person, other, cells, now):
                cost = _cost(observation, person, cells, other, now)
            if cost is not None:
                if other is not None and rest is not None:
                    cost += _rest_cost_margin(observation, other, cells, rest)
                ranked.append((cost, person.label, number))
    return sorted(ranked)


def _offered_bodies(
    observation: PersonObservation, cells: I64, other: Person | None, unlabelled: Sequence[int]
) -> Mask:
    """Return a mask (N,) of offered cells with the rest of their bodies.

    The rest are free cells and cells of ``unlabelled`` owners; it is left out if the offer is part
    of a labelled person.
    """
    taken = np.zeros(len(observation.owner), np.bool_)
    taken[cells] = True
    if other is None or not other.named:
        bodies = np.unique(observation.bodies[cells])
        taken |= np.isin(observation.bodies, bodies[bodies >= 0]) & np.isin(
            observation.owner, unlabelled
        )
    return taken


def _is_candidate(person: Person, other: Person | None) -> bool:
    """Return whether an untracked body, or one of an ``other`` person, may be a missing person.

    An unlabelled person that was there while the missing one was visible is excluded.
    """
    if other is None or other.named:
        return other is not person
    return other.since > person.last_clear


def _may_return(
    observation: PersonObservation, person: Person, other: Person | None, cells: I64, now: int
) -> bool:
    """Return whether a missing person may have a free body, or the body of an ``other`` person.

    A newcomer is identified with a person that left at a side of the picture only if stature,
    clothes and time make it likely.
    """
    if not (person.at_side and person.frames_unseen) or (other is not None and other.named):
        return True
    if other is None:
        return False
    options = observation.options.arrivals
    measured = len(other.identity.stature.tops) >= options.return_tops
    known = measured or now - other.since >= options.return_frames
    return known and _return_odds(observation, person, other, cells, now) > 0


def _return_odds(
    observation: PersonObservation, person: Person, newcomer: Person, cells: I64, now: int
) -> float:
    """Return the log odds that a ``newcomer`` is a person that left the picture.

    A person who steps out for a moment comes back where they left; later anybody may enter.
    """
    options, tops = observation.options.arrivals, newcomer.identity.stature.tops
    seconds = (newcomer.since - (now - 1 - person.frames_unseen)) / observation.fps
    entry = np.median(newcomer.xyz, axis=0) - newcomer.displacement
    distance = float(np.linalg.norm((entry - np.median(person.known, axis=0)) @ observation.flat))
    recency = np.exp(-seconds / options.return_seconds - 0.5 * (distance / options.return_m) ** 2)
    odds = options.return_soon_log * recency - options.return_log_odds
    if tops:
        odds += person.identity.stature.likelihood(float(np.median(tops)))
    return float(odds + options.return_clothes_weight * person.likeness(observation.some(cells)))


def _adopt_newcomer(
    observation: PersonObservation, person: Person, newcomer: Person, cells: I64, now: int
) -> None:
    """Take over the observations of a recognised ``newcomer``, who may be another person."""
    likely = squashed(_return_odds(observation, person, newcomer, cells, now))
    person.identity.cap = observation.options.body.doubted_confidence * likely
    person.seen = newcomer.seen


def _offers(
    observation: PersonObservation,
    people: Sequence[Person],
    missing: Sequence[Person],
    usual: float,
    now: int,
) -> list[Offer]:
    """Return cells that may be of a ``missing`` person: free bodies, and parts of other people."""
    options = observation.options.arrivals
    part = parts(observation.cells.touching, (observation.owner == 0) & observation.cells.solid)
    count = np.bincount(part[part >= 0])
    large = np.flatnonzero(
        count >= max(options.back_min_cells, options.back_min_share * usual)
    ).tolist()
    offers: list[Offer] = [(np.flatnonzero(part == n), None, None) for n in large]
    for person in people:
        cells = np.flatnonzero(observation.owner == person.label)
        if not person.named and not person.frames_unseen and len(cells):
            offers.append((cells, person, None))
    if observation.tints is not None:
        for person in (f for f in missing if f.last_clear < now - options.missing_frames):
            offers += _parts_with_clothes(observation, people, person, usual)
    for person in (f for f in people if f.named):
        least = max(options.back_min_cells, options.part_share * usual)
        two = beneath_heads(observation, observation.cells_of(person.label), least, person.area)
        offers += [(own, person, rest) for own, rest in two]
    return offers


def _rest_cost_margin(
    observation: PersonObservation, person: Person, cells: I64, rest: I64
) -> float:
    """Return the cost of the ``rest`` of a person's cells to be theirs, minus that of ``cells``."""
    middle = np.median((person.xyz + person.step) @ observation.flat, axis=0)

    def cost(own: I64) -> float:
        distance = float(np.linalg.norm(np.median(observation.ground[own], axis=0) - middle))
        return (
            distance
            - observation.options.arrivals.clothes_weight * person.likeness(observation.some(own))
            - _stature_gain(observation, person, own)
        )

    return cost(rest) - cost(cells)


def _parts_with_clothes(
    observation: PersonObservation, people: Sequence[Person], missing: Person, usual: float
) -> list[Offer]:
    """Return parts of other people with the clothes of a missing person instead of their own."""
    options = observation.options.arrivals
    if missing.identity.appearance is None:
        return []
    found: list[Offer] = []
    own = observation.unlike(missing.identity.appearance)
    for other in people:
        if other is missing or not other.named or other.identity.appearance is None:
            continue
        mask = (observation.owner == other.label) & observation.cells.solid
        mask &= (
            observation.smooth(observation.unlike(other.identity.appearance) - own)
            > observation.options.body.clearly_log
        )
        part = parts(observation.cells.touching, mask)
        count = np.bincount(part[part >= 0])
        large = np.flatnonzero(
            count >= max(options.back_min_cells, options.part_share * usual)
        ).tolist()
        found += [(np.flatnonzero(part == n), other, None) for n in large]
    return found


def _cost(
    observation: PersonObservation, person: Person, cells: I64, other: Person | None, now: int
) -> float | None:
    """Return the cost of a body for a missing person, by distance, clothes and stature.

    None: it cannot be theirs.
    """
    options = observation.options
    distance = relative_distance(observation, person, cells, now)
    like = person.likeness(observation.some(cells))
    if distance > 1.0 or like < -options.body.unlike_log:
        return None
    nameless = (
        options.arrivals.unlabelled_cost if observation.tints is None and other is not None else 0.0
    )
    return (
        distance
        - options.arrivals.clothes_weight * like
        - _stature_gain(observation, person, cells)
        + nameless
    )


def _stature_gain(observation: PersonObservation, person: Person, cells: I64) -> float:
    """Return the reduction of the cost of some cells by a person's stature."""
    top = top_of(observation, cells, person.area) if person.identity.stature.known else None
    if top is None:
        return 0.0
    return observation.options.arrivals.stature_weight * person.identity.stature.likelihood(top)


def relative_distance(
    observation: PersonObservation, person: Person, cells: I64, now: int
) -> float:
    """Return the distance of a body over the maximum distance a missing person may have moved."""
    options = observation.options.arrivals
    there = np.vstack([person.xyz + person.step, person.known])
    reach = options.back_m + options.back_m_per_frame * min(
        max(now - 1 - person.last_clear, 0), options.back_max_frames
    )
    return _minimum_distance(there, observation.cells.middle[cells]) / reach


def confusable_people(
    observation: PersonObservation, people: Sequence[Person], person: Person, now: int
) -> list[Person]:
    """Return missing people near a person's cells that may have these cells instead."""
    cells = observation.cells_of(person.label)
    if not len(cells):
        return []
    missing = [
        f for f in people if f.named and f is not person and f.may_be_elsewhere(observation, now)
    ]
    some = observation.some(cells) if missing else None
    top = person.top(observation) if missing else None
    missing = [f for f in missing if not rules_out(some, top, person, f)]
    return [f for f in missing if relative_distance(observation, f, cells, now) < 1.0]


def rules_out(some: F32 | None, top: float | None, person: Person, other: Person) -> bool:
    """Return whether a person's cells are certainly not another's.

    Colours ``some`` (S, 3) or ``top`` is decisive, and the other one does not contradict it.
    """
    options = person.options
    like = 0.0 if some is None else person.likeness(some) - other.likeness(some)
    stature_log_odds = ratio(top, person.identity.stature, other.identity.stature)
    return (
        like >= options.arrivals.decisive_log_clothes
        and stature_log_odds > -options.stature.decisive_log_odds
    ) or (
        stature_log_odds >= options.stature.decisive_log_odds
        and like > -options.arrivals.decisive_log_clothes
    )


def newcomers(
    observation: PersonObservation, people: Sequence[Person], usual: float, now: int
) -> list[Person]:
    """Return new people for bodies without an owner; bodies around a visible person are theirs."""
    options = observation.options
    free = (observation.owner == 0) & observation.cells.solid
    bodies = observation.bodies
    added: list[Person] = []
    lowest = min([0, *(f.label for f in people)])
    middles = _middles(observation, people) if now else []
    total = np.bincount(bodies[bodies >= 0])
    least = np.maximum(options.body.seen_min_cells, options.arrivals.unclaimed_share * total)
    count = np.bincount(bodies[free], minlength=len(total))
    for number in np.flatnonzero((count > 0) & (count >= least)).tolist():
        cells = np.flatnonzero((bodies == number) & free)
        owner = _surrounding_person(observation, middles, cells)
        if owner is None and len(cells) >= max(
            options.arrivals.min_cells, options.arrivals.min_share * usual
        ):
            owner = _adjacent_newcomer(observation, [*people, *added], cells)
            if owner is None:
                owner = lowest - 1 - len(added)
                some = observation.some(cells)
                appearance = (
                    None
                    if some is None
                    else ColourHistogram.of(some, observation.options.appearance)
                )
                middle, colour = observation.cells.middle[cells], observation.cells.colour[cells]
                added.append(Person.first_seen(options, owner, middle, colour, now, appearance))
        observation.owner[cells] = owner or 0
    return added


def _middles(observation: PersonObservation, people: Sequence[Person]) -> list[tuple[Person, F64]]:
    """Return the middle (2,) on the ground of each visible labelled person."""
    found = []
    for person in people:
        own = observation.owner == person.label
        if person.named and own.any():
            known = np.vstack(
                [observation.ground[own], (person.xyz + person.step) @ observation.flat]
            )
            found.append((person, np.median(known, axis=0)))
    return found


def _surrounding_person(
    observation: PersonObservation, middles: Sequence[tuple[Person, F64]], cells: I64
) -> int | None:
    """Return the label of the visible person around a body, unless the clothes differ."""
    options = observation.options
    middle = np.median(observation.ground[cells], axis=0)
    near = [(float(np.linalg.norm(at - middle)), k) for k, (_, at) in enumerate(middles)]
    distance, best = min(near, default=(options.arrivals.around_m, 0))
    if (
        distance >= options.arrivals.around_m
        or middles[best][0].likeness(observation.some(cells)) < -options.body.unlike_log
    ):
        return None
    return middles[best][0].label


def _adjacent_newcomer(
    observation: PersonObservation, people: Sequence[Person], cells: I64
) -> int | None:
    """Return the number of an unlabelled person adjacent to a body."""
    for person in people:
        own = observation.owner == person.label
        if (
            not person.named
            and own.any()
            and _gap(observation, own.nonzero()[0], cells) < observation.options.arrivals.joined_m
        ):
            return person.label
    return None


def merge_newcomers(observation: PersonObservation, people: Sequence[Person], now: int) -> set[int]:
    """Return the numbers of new unlabelled people that are parts of a just returned person."""
    options = observation.options.arrivals
    merged: set[int] = set()
    returned = [
        f for f in people if f.named and f.age and now - f.reappearance <= options.recent_frames
    ]
    for person in people:
        cells = np.flatnonzero(observation.owner == person.label)
        if (
            person.named
            or now - person.since > options.recent_frames
            or person.frames_unseen
            or not len(cells)
        ):
            continue
        for other in returned:
            own = np.flatnonzero(observation.owner == other.label)
            if len(own) and _gap(observation, own, cells) < options.touches_m:
                observation.owner[cells] = other.label
                merged.add(person.label)
                break
    return merged


def _gap(observation: PersonObservation, one: I64, other: I64) -> float:
    """Return the distance (m) between two bodies."""
    return _minimum_distance(observation.cells.middle[one], observation.cells.middle[other])


def _minimum_distance(one: F64, other: F64) -> float:
    gap, _ = cKDTree(one).query(other)
    return float(np.min(gap))
