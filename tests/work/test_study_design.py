"""The orders of conditions, scores, effects and power of studies."""

from __future__ import annotations

import sys
from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
from scipy import stats

from pointbrush.values.study import Condition, Study, StudyTask
from pointbrush.work.studies.design import conditions_of, latin_row
from pointbrush.work.studies.results import shares
from pointbrush.work.studies.statistics import effects
from tests.test_docs import ROOT

sys.path.insert(0, str(ROOT / "docs"))

from study_power import power, table


def study(count: int, **fields: object) -> Study:
    names = tuple(Condition(name=f"c{n}") for n in range(count))
    tasks = (StudyTask(name="t", recording="r", labels=("l",)),)
    return Study(title="S", conditions=names, tasks=tasks, **fields)  # type: ignore[arg-type]


@pytest.mark.parametrize("count", [2, 3, 4, 5, 6])
def test_each_condition_has_each_place_and_follows_each_other_equally_often(count: int) -> None:
    rows = [latin_row(count, n) for n in range(count * (1 + count % 2))]
    places = Counter((place, name) for row in rows for place, name in enumerate(row))
    following = Counter(pair for row in rows for pair in pairwise(row))
    assert len(places) == count**2
    assert len(set(places.values())) == 1
    assert len(following) == count * (count - 1)
    assert len(set(following.values())) == 1


def test_between_participants_groups_are_of_equal_size_and_a_seed_repeats_an_order() -> None:
    for order in ("latin", "random"):
        design = study(3, design="between", order=order, seed=7)
        found = Counter(conditions_of(design, number) for number in range(1, 13))
        assert found == {("c0",): 4, ("c1",): 4, ("c2",): 4}
    design = study(4, order="random", seed=7)
    orders = [conditions_of(design, number) for number in range(1, 20)]
    assert orders == [conditions_of(design, number) for number in range(1, 20)]
    assert len(set(orders)) > 5
    assert all(sorted(each) == ["c0", "c1", "c2", "c3"] for each in orders)


def test_effects_are_the_published_ones_and_their_intervals_hold_them() -> None:
    random = np.random.default_rng(3)
    first, second = random.normal(10, 2, 12), random.normal(12, 2, 12)
    rows = [
        {"participant": n, "condition": name, "m": float(values[n])}
        for name, values in (("a", first), ("b", second))
        for n in range(12)
    ]
    (paired,) = effects(rows, "m", ("a", "b"), paired=True, seed=1)
    change = second - first
    assert (paired.count, paired.difference) == (12, pytest.approx(change.mean()))
    assert paired.d == pytest.approx(stats.ttest_rel(second, first).statistic / np.sqrt(12))
    (groups,) = effects(rows, "m", ("a", "b"), paired=False, seed=1)
    t = stats.ttest_ind(second, first).statistic
    assert (groups.count, groups.d) == (24, pytest.approx(t * np.sqrt(2 / 12)))
    expected = stats.bootstrap((change,), np.mean, method="percentile", rng=5).confidence_interval
    assert paired.interval == pytest.approx([expected.low, expected.high], abs=0.15)
    assert paired.interval[0] < paired.difference < paired.interval[1]
    (turned,) = effects(rows, "m", ("b", "a"), paired=True, seed=1)
    assert (turned.first, turned.difference) == ("b", pytest.approx(-change.mean()))
    assert (
        effects(rows[:13], "m", ("a", "b"), paired=True, seed=1) == []
    )  # one participant has both


def test_the_power_table_agrees_with_the_noncentral_t_distribution() -> None:
    for count, d in ((12, 0.8), (20, 0.5)):
        limit = stats.t.ppf(0.975, count - 1)
        exact = stats.nct.sf(limit, count - 1, d * np.sqrt(count))
        assert power(count, d, paired=True) == pytest.approx(exact, abs=0.025)
    assert table() in (ROOT / "docs" / "study-measures.md").read_text()


def test_shares_of_phases_fill_a_task() -> None:
    records = [
        {"kind": "phase", "t": 1000, "phase": "painting"},
        {"kind": "phase", "t": 3000, "phase": "navigation"},
        {"kind": "phase", "t": 20_000, "phase": "painting"},
    ]
    assert shares(records, 10) == {"navigation": 0.7, "painting": 0.2, "waiting": 0.1}
    assert shares([], 10) == {"navigation": None, "painting": None, "waiting": None}
