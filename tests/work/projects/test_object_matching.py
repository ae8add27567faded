"""Objects of two people matched: by hand, and on random ones against trying everything."""

from __future__ import annotations

from collections import Counter
from itertools import permutations

import numpy as np
import pytest

from pointbrush.teamwork.matching import (
    UNDECIDED,
    disagreements,
    groups,
    majority,
    matches,
    pairs_of_people,
)

CLASSES = dict.fromkeys(range(1, 10), "car") | {9: "tree"}


def pairs(first: list[int], second: list[int]) -> Counter[tuple[int, int]]:
    return Counter(zip(first, second, strict=True))


@pytest.mark.parametrize(
    ("first", "second", "wanted"),
    [
        ([1] * 10 + [2] * 10, [5] * 10 + [4] * 10, []),
        ([1] * 10 + [2] * 10, [1] * 10 + [0] * 10, [("missed", (2,), (), 10)]),
        ([1] * 10 + [0] * 10, [1] * 10 + [3] * 10, [("added", (), (3,), 10)]),
        ([1] * 20, [1] * 12 + [2] * 8, [("split", (1,), (1, 2), 8)]),
        ([1] * 12 + [2] * 8, [3] * 20, [("merged", (1, 2), (3,), 8)]),
        ([1] * 10, [9] * 10, [("renamed", (1,), (9,), 10)]),
        ([1] * 10 + [0] * 5, [0] * 4 + [1] * 11, [("outline", (1,), (1,), 9)]),
        ([1] * 18 + [0] * 2, [1] * 20, []),
    ],
)
def test_differences_are_called_by_their_names(
    first: list[int],
    second: list[int],
    wanted: list[tuple[str, tuple[int, ...], tuple[int, ...], int]],
) -> None:
    found = disagreements(pairs(first, second), CLASSES, CLASSES)
    assert [(each.kind, each.first, each.second, each.points) for each in found] == wanted


def best_sum(counted: Counter[tuple[int, int]], least: float) -> float:
    """Greatest sum of IoU over all ways to match, by trying them."""
    rows = sorted({a for a, _ in counted} - {0})
    columns = sorted({b for _, b in counted} - {0})
    sizes = [
        {n: sum(c for ends, c in counted.items() if ends[side] == n) for n in (rows, columns)[side]}
        for side in (0, 1)
    ]
    padded = [*columns, *[0] * len(rows)]

    def iou(a: int, b: int) -> float:
        shared = counted[a, b] if b else 0
        found = shared / (sizes[0][a] + sizes[1].get(b, 0) - shared)
        return found if found >= least else 0.0

    return max(
        sum(iou(a, b) for a, b in zip(rows, chosen, strict=True))
        for chosen in permutations(padded, len(rows))
    )


def test_random_ones_match_as_well_as_the_best_of_all_ways() -> None:
    random = np.random.default_rng(0)
    for _ in range(200):
        first, second = (random.integers(0, 4, 30) for _ in range(2))
        counted = pairs(first.tolist(), second.tolist())
        found = matches(counted)
        assert len({each.first for each in found}) == len({each.second for each in found})
        assert sum(each.iou for each in found) == pytest.approx(best_sum(counted, 0.1))


@pytest.mark.parametrize("seed", range(5))
def test_the_majority_of_three_gives_back_the_truth_where_two_agree(seed: int) -> None:
    random = np.random.default_rng(seed)
    truth = np.repeat([0, 1, 2, 3, 0, 4], 50).astype(np.uint16)
    people = []
    for who in range(3):
        renumbered = np.append(0, random.permutation(4) + 1 + 10 * who).astype(np.uint16)
        people.append(renumbered[truth])
    # Each errs elsewhere: two joined, one missed, one split, and a few points at random.
    people[0][truth == 2] = people[0][truth == 1][0]
    people[1][truth == 3] = 0
    people[2][250:275] = 99
    where = random.permutation(50)[:30]
    for who in range(3):
        people[who][where[who * 10 : who * 10 + 10]] = 77
    numbers = groups(pairs_of_people(people))
    found = majority(people, numbers)
    assert UNDECIDED not in found
    sames = {(int(a), int(b)) for a, b in zip(truth, found, strict=True)}
    assert len(sames) == 5, "one object of the truth is one of the majority's"
    assert (found[truth == 0] == 0).all()


def test_a_point_that_all_call_otherwise_is_undecided() -> None:
    people = [np.array([1, 1, 1, 2, 2, 2, last], np.uint16) for last in (1, 2, 0)]
    found = majority(people, groups(pairs_of_people(people))).tolist()
    assert found == [1, 1, 1, 2, 2, 2, UNDECIDED]
