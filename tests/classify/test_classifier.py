"""A classifier learns from examples, keeps in a file, and trusts no file."""

from __future__ import annotations

import io
import json
from dataclasses import replace

import numpy as np
import pytest

from pointbrush.classify.classifier import (
    Classifier,
    Examples,
    balanced,
    from_file,
    to_file,
)
from pointbrush.classify.features import feature_names
from pointbrush.classify.forest import GROUPS, groups_of, learn, probabilities
from pointbrush.classify.options import FeatureOptions, ForestOptions
from pointbrush.errors import BadInputError

RNG = np.random.default_rng(1)
WIDTH = len(feature_names(FeatureOptions()))
COUNT = 300


def examples() -> Examples:
    """Three classes that lie apart along the first feature."""
    classes = np.arange(COUNT) % 3
    features = RNG.normal(0, 1, (COUNT, WIDTH)).astype(np.float32)
    features[:, :8] += 4 * classes[:, None]
    return Examples(
        features, classes.astype(np.uint8), np.arange(COUNT) // 15, np.ones(WIDTH), "abc", 7
    )


FEW = ForestOptions(trees=12)


def scored(taught: Classifier) -> Classifier:
    """Learn, and expect the accuracy in a frame with as many cells of each class."""
    found, seen = taught.learnt(FEW), examples().features
    assert found.trees is not None
    return found.scored(FEW, seen, probabilities(found.trees, seen))


TAUGHT = scored(Classifier("trees", ("a", "b", "c"), 0.5, ("here",), {("here", 0): examples()}))


def test_what_was_taught_is_known() -> None:
    assert TAUGHT.trees is not None
    some = examples()
    right = probabilities(TAUGHT.trees, some.features).argmax(axis=1) == some.classes
    assert right.mean() > 0.95
    assert TAUGHT.score is not None
    assert TAUGHT.score > 0.9


def test_the_same_examples_give_the_same_trees() -> None:
    again = replace(TAUGHT, trees=None).learnt(ForestOptions(trees=12))
    assert again.trees is not None
    assert TAUGHT.trees is not None
    assert all(np.array_equal(a, b) for a, b in zip(again.trees, TAUGHT.trees, strict=True))


def test_a_rare_class_weighs_as_much() -> None:
    some = examples()
    kept = np.concatenate(
        [np.flatnonzero(some.classes != 2), np.flatnonzero(some.classes == 2)[:6]]
    )
    few = Examples(some.features[kept], some.classes[kept], some.place[kept], some.spread)
    taught = replace(TAUGHT, examples={("here", 0): few}).learnt(ForestOptions(trees=24))
    assert taught.trees is not None
    rare = some.features[some.classes == 2]
    assert (probabilities(taught.trees, rare).argmax(axis=1) == 2).mean() > 0.9


def test_classes_are_sampled_alike() -> None:
    classes = np.repeat([0, 1, 2], [1000, 50, 5])
    assert np.bincount(classes[balanced(classes, 90)]).tolist() == [43, 42, 5] or np.bincount(
        classes[balanced(classes, 90)]
    ).tolist() == [42, 42, 5]
    assert len(balanced(classes, 5000)) == len(classes)


def test_accuracy_is_of_places_that_did_not_teach() -> None:
    some = examples()
    mixed = RNG.permutation(some.classes)
    guessed = replace(some, classes=np.repeat(mixed[::15], 15)[:COUNT])
    found = scored(replace(TAUGHT, examples={("here", 0): guessed}))
    assert found.score is not None
    assert found.score < 0.7  # each place is learnt by heart
    assert all(each.accuracy is not None for each in TAUGHT.held_out)


def test_each_group_of_trees_leaves_a_fold_out() -> None:
    some = examples()
    classes = some.classes.astype(np.int64)
    fold = np.where(classes == 2, 5, -1)
    trees = learn(some.features, classes, 3, some.spread, ForestOptions(), None, fold)
    knows = [(probabilities(each, some.features).argmax(1) == 2).any() for each in groups_of(trees)]
    assert knows == [group != 5 for group in range(GROUPS)]


def test_a_class_in_few_places_is_not_measured() -> None:
    some = examples()
    twice = replace(some, place=np.where(some.classes == 2, some.place % 2, some.place + 2))
    found = scored(replace(TAUGHT, examples={("here", 0): twice})).held_out
    assert found[2].accuracy is None
    assert found[2].places == 2
    assert found[0].accuracy is not None


def test_painted_places_outweigh_earlier_work() -> None:
    wrong = examples()
    wrong = replace(wrong, classes=((wrong.classes + 1) % 3).astype(np.uint8))
    both = {("here", 0): examples(), ("there", 0): wrong}
    only = replace(
        TAUGHT, examples={("there", 0): wrong}, start_from=("there",), recordings=("here",)
    )
    some = examples()

    def right(taught: Classifier) -> float:
        learnt = taught.learnt(FEW)
        assert learnt.trees is not None
        best = probabilities(learnt.trees, some.features).argmax(axis=1)
        return float((best == some.classes).mean())

    assert right(only) < 0.1
    assert right(replace(only, examples=both)) > 0.8
    assert "there" not in replace(only, examples=both).taught_by


def test_a_file_gives_the_classifier_back() -> None:
    again = from_file(to_file(TAUGHT))
    assert (again.name, again.classes, again.size, again.score) == (
        TAUGHT.name, TAUGHT.classes, TAUGHT.size, TAUGHT.score,
    )  # fmt: skip
    assert (again.held_out, again.above) == (TAUGHT.held_out, TAUGHT.above)
    assert again.taught_by == {"here": COUNT}
    assert again.examples["here", 0].revision == 7
    assert again.trees is not None
    assert TAUGHT.trees is not None
    assert all(np.array_equal(a, b) for a, b in zip(again.trees, TAUGHT.trees, strict=True))
    assert from_file(to_file(Classifier("new", ("a",)))).trees is None


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("left", np.int32(-5)),
        ("left", np.int32(10**6)),
        ("left", np.int32(2**31 - 1)),
        ("feature", np.int16(30_000)),
        ("roots", np.int32(10**6)),
        ("chance", np.float32(np.nan)),
        ("chance", np.float32(1e30)),
        ("threshold", np.float32(np.inf)),
        ("example_spreads", np.float64(np.nan)),
        ("example_classes", np.uint8(3)),
    ],
)
def test_links_that_lead_nowhere_are_refused(name: str, value: np.generic) -> None:
    with np.load(io.BytesIO(to_file(TAUGHT))) as stored:
        arrays = {key: stored[key].copy() for key in stored}
    arrays[name].flat[0] = value
    out = io.BytesIO()
    np.savez(out, **arrays)
    with pytest.raises(BadInputError, match="classifier"):
        from_file(out.getvalue())


def test_a_stored_classifier_of_an_older_version_learns_again() -> None:
    with np.load(io.BytesIO(to_file(TAUGHT))) as stored:
        arrays = {key: stored[key].copy() for key in stored}
    about = json.loads(arrays["about"].tobytes()) | {"version": 1, "features": ["others"]}
    for key in ("held_out", "above", "start_from"):
        del about[key]
    arrays["about"] = np.frombuffer(json.dumps(about).encode(), np.uint8)
    out = io.BytesIO()
    np.savez(out, **arrays)
    again = from_file(out.getvalue(), stored=True)
    assert (again.name, again.classes, again.recordings) == (
        TAUGHT.name, TAUGHT.classes, TAUGHT.recordings,
    )  # fmt: skip
    assert not again.ready
    assert not again.examples
    with pytest.raises(BadInputError, match="expected version 2, got 1"):
        from_file(out.getvalue())


def test_no_pickle_and_no_rubbish_is_read() -> None:
    out = io.BytesIO()
    np.savez(out, about=np.array([{"version": 1}], object))
    for data in (b"", b"PK\x03\x04rubbish", out.getvalue(), to_file(TAUGHT)[:-40]):
        with pytest.raises(BadInputError, match="classifier"):
            from_file(data)


def test_trees_that_would_take_minutes_are_refused() -> None:
    with np.load(io.BytesIO(to_file(TAUGHT))) as stored:
        arrays = {key: stored[key].copy() for key in stored}
    length = 1000
    arrays["feature"] = np.append(np.zeros(length, np.int16), np.int16([-1, -1]))
    arrays["left"] = np.append(np.arange(1, length + 1), [0, 0]).astype(np.int32)
    arrays["threshold"] = np.zeros(length + 2, np.float32)
    arrays["roots"] = np.zeros(1, np.int32)
    out = io.BytesIO()
    np.savez(out, **arrays)
    with pytest.raises(BadInputError, match="at most 64 nodes"):
        from_file(out.getvalue())
