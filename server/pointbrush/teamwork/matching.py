"""Agreement of people by objects: matching of objects independent of their numbers.

Two annotations of the same points are compared by the points that each pair of labels has in
common.  The functions do not use recordings; labels are numbers, 0 is none.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from pointbrush.values.team.tasks import DisagreementKind

Pairs = Mapping[tuple[int, int], int]
"""Points of each pair of labels, of the first and of the second annotation."""
Kind = DisagreementKind


@dataclass(frozen=True, slots=True)
class MatchOptions:
    """Thresholds for matching objects; all are shares, 0 to 1."""

    least: float = 0.1
    """IoU below which two objects do not match."""
    same: float = 0.75
    """IoU from which the outlines of two objects agree."""
    inside: float = 0.5
    """Share of an object's points inside another object from which it is a part of it."""


@dataclass(frozen=True, slots=True)
class Match:
    """An object of the first annotation, one of the second, and their IoU."""

    first: int
    second: int
    iou: float


@dataclass(frozen=True, slots=True)
class Disagreement:
    """A difference of the second annotation from the first.

    ``missed``, ``added``  an object of the first, or second, alone.
    ``split``, ``merged``  an object of the first is several of the second, or the reverse.
    ``renamed``            the same object with another class.
    ``outline``            the same object with other points.
    ``points``             number of differing points, for the order.
    """

    kind: Kind
    first: tuple[int, ...]
    second: tuple[int, ...]
    points: int


def matches(pairs: Pairs, options: MatchOptions | None = None) -> list[Match]:
    """Return the one-to-one matches of objects with the greatest sum of IoU."""
    options = options or MatchOptions()
    sizes = _sizes(pairs)
    rows, columns = (sorted(each) for each in sizes)
    iou = np.zeros((len(rows), len(columns)))
    for (mine, theirs), points in pairs.items():
        if mine and theirs:
            union = sizes[0][mine] + sizes[1][theirs] - points
            iou[rows.index(mine), columns.index(theirs)] = points / union
    iou[iou < options.least] = 0.0
    from scipy.optimize import linear_sum_assignment  # slow to import

    chosen = zip(*linear_sum_assignment(iou, maximize=True), strict=True)
    return [Match(rows[i], columns[j], float(iou[i, j])) for i, j in chosen if iou[i, j] > 0]


def disagreements(
    pairs: Pairs, first: Mapping[int, str], second: Mapping[int, str]
) -> list[Disagreement]:
    """Return the differences of the second annotation from the first, most points first.

    ``first``, ``second``: the class of each label.
    """
    options = MatchOptions()
    sizes = _sizes(pairs)
    matched = matches(pairs, options)
    to_second = {match.first: match.second for match in matched}
    to_first = {match.second: match.first for match in matched}
    found, wholes = [], (set[int](), set[int]())
    turned = {(theirs, mine): points for (mine, theirs), points in pairs.items()}
    for side, there, partner in ((0, pairs, to_second), (1, turned, to_first)):
        parts: dict[int, list[int]] = defaultdict(list)
        for own in sorted(sizes[side].keys() - partner.keys()):
            whole = _whole_of(own, there, sizes[side][own], options.inside)
            if whole and whole in (to_first, to_second)[side]:
                parts[whole].append(own)
                continue
            alone = (own,)
            found.append(
                Disagreement("added", (), alone, sizes[side][own])
                if side
                else Disagreement("missed", alone, (), sizes[side][own])
            )
        for whole, others in parts.items():
            points = sum(sizes[side][each] for each in others)
            partner_of_whole = (to_first, to_second)[side][whole]
            pieces = tuple(sorted([partner_of_whole, *others]))
            wholes[1 - side].add(whole)
            found.append(
                Disagreement("split", (whole,), pieces, points)
                if side
                else Disagreement("merged", pieces, (whole,), points)
            )
    found += _of_matches(pairs, matched, sizes, (first, second), wholes, options)
    return sorted(found, key=lambda each: (-each.points, each.kind, each.first, each.second))


def _whole_of(own: int, there: Pairs, size: int, inside: float) -> int:
    """Return the other object that contains most of an object's points; 0: none has enough."""
    shared = {theirs: points for (mine, theirs), points in there.items() if mine == own and theirs}
    whole = max(shared, key=lambda each: (shared[each], -each), default=0)
    return whole if whole and shared[whole] >= inside * size else 0


def _of_matches(
    pairs: Pairs,
    matched: Sequence[Match],
    sizes: tuple[Counter[int], Counter[int]],
    classes: tuple[Mapping[int, str], Mapping[int, str]],
    wholes: tuple[set[int], set[int]],
    options: MatchOptions,
) -> list[Disagreement]:
    found = []
    for match in matched:
        shared = pairs[match.first, match.second]
        ends = ((match.first,), (match.second,))
        if classes[0].get(match.first, "") != classes[1].get(match.second, ""):
            found.append(Disagreement("renamed", *ends, shared))
        is_split = match.first in wholes[0] or match.second in wholes[1]  # or merged
        if match.iou < options.same and not is_split:
            union = sizes[0][match.first] + sizes[1][match.second] - shared
            found.append(Disagreement("outline", *ends, union - shared))
    return found


def _sizes(pairs: Pairs) -> tuple[Counter[int], Counter[int]]:
    sizes: tuple[Counter[int], Counter[int]] = (Counter(), Counter())
    for ends, points in pairs.items():
        for side, label in enumerate(ends):
            if label and points:
                sizes[side][label] += points
    return sizes


Member = tuple[int, int]
"""A person's number, and the label of one of their objects."""


def groups(pairs: Mapping[tuple[int, int], Pairs]) -> dict[Member, int]:
    """Return a number 1, 2, … for each object of several people, equal for the same object.

    ``pairs``: of each two people, the first below the second.  Objects with the greatest IoU are
    joined first, and never two objects of one person.
    """
    options = MatchOptions()
    likes: list[tuple[float, Member, Member]] = []
    members: set[Member] = set()
    for (one, other), shared in pairs.items():
        sizes = _sizes(shared)
        members |= {(one, label) for label in sizes[0]} | {(other, label) for label in sizes[1]}
        for (mine, theirs), points in shared.items():
            if mine and theirs:
                iou = points / (sizes[0][mine] + sizes[1][theirs] - points)
                if iou >= options.least:
                    likes.append((-iou, (one, mine), (other, theirs)))
    joined = {member: {member} for member in members}
    for _, one_end, other_end in sorted(likes):
        group, other_group = joined[one_end], joined[other_end]
        if group is other_group or {who for who, _ in group} & {who for who, _ in other_group}:
            continue
        group |= other_group
        for member in other_group:
            joined[member] = group
    numbers: dict[Member, int] = {}
    for member in sorted(members):
        if member not in numbers:
            number = len(set(numbers.values())) + 1
            numbers |= dict.fromkeys(joined[member], number)
    return numbers


UNDECIDED = -1
"""A point without a majority."""


def majority(
    labels: Sequence[NDArray[np.uint16]], numbers: Mapping[Member, int]
) -> NDArray[np.int64]:
    """Return for each point the object chosen by more than half of the people.

    ``labels``: (N,) per person; ``numbers``: of ``groups``.  0: no object; or UNDECIDED.
    """
    votes = np.stack([_numbered(each, who, numbers) for who, each in enumerate(labels)])
    counts = np.stack([(votes == each).sum(axis=0) for each in votes])
    best = counts.argmax(axis=0)
    at = np.arange(votes.shape[1])
    enough = counts[best, at] * 2 > len(votes)
    return np.where(enough, votes[best, at], UNDECIDED)


def _numbered(
    labels: NDArray[np.uint16], who: int, numbers: Mapping[Member, int]
) -> NDArray[np.int64]:
    table = np.zeros(1 << 16, np.int64)
    for (person, label), number in numbers.items():
        if person == who:
            table[label] = number
    return table[labels]


def pairs_of_people(
    labels: Sequence[NDArray[np.uint16]],
) -> dict[tuple[int, int], Counter[tuple[int, int]]]:
    """Return the number of points of each pair of labels, by pairs of people; labels (N,)."""
    found = {}
    for one, other in combinations(range(len(labels)), 2):
        joined = labels[one].astype(np.uint32) << 16 | labels[other]
        values, counts = np.unique(joined, return_counts=True)
        ends = zip((values >> 16).tolist(), (values & 0xFFFF).tolist(), strict=True)
        found[one, other] = Counter(dict(zip(ends, counts.tolist(), strict=True)))
    return found
