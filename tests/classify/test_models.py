"""Models of one's own: plug-ins and a service, one suite for both; nothing they say is trusted."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from importlib.metadata import EntryPoint
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pointbrush.classify.features import Described, ExampleFrame, describe
from pointbrush.classify.models import Model, Models, Question, chances_of
from pointbrush.classify.options import FeatureOptions
from pointbrush.errors import BadInputError, UnavailableError
from pointbrush.exchange import model_names
from tests.services import example_service

EXAMPLE = "model_server.py"
CLASSES = ("low", "high")


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """Where the documented example listens."""
    with example_service(EXAMPLE) as url:
        yield url


class Heights:
    """A plug-in that scores points by their height, and learns nothing."""

    takes = "points"
    classes = CLASSES
    learns = False

    def learn(self, *_: Any) -> bytes:
        raise AssertionError("learns nothing")

    def scores(self, question: Question) -> NDArray[np.float32]:
        high = (question.points.xyz[:, 2] > 1).astype(np.float32)
        return np.stack([1 - high, 3 * high], axis=1)


@pytest.fixture
def plug_in(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(model_names, "entry_points", _entries)


def _entries(group: str, name: str | None = None) -> Sequence[EntryPoint]:
    assert group == "pointbrush.classifiers"
    every = [EntryPoint("heights", f"{__name__}:Heights", group)]
    return [each for each in every if name in (None, each.name)]


@pytest.fixture(scope="module")
def made() -> tuple[ExampleFrame, Described]:
    """Two sheets, one 2 m above the other."""
    rng = np.random.default_rng(0)
    xyz = np.column_stack([rng.uniform(0, 2, (2000, 2)), np.repeat([0.0, 2.0], 1000)])
    frame = ExampleFrame(xyz)
    return frame, describe(frame, 0.1, FeatureOptions())


def test_a_plug_in_scores_points(plug_in: None, made: tuple[ExampleFrame, Described]) -> None:
    frame, place = made
    model = Models().make("heights")
    chance = chances_of(model, CLASSES, b"", place, frame, "own")
    assert chance.shape == (len(place.center), 2)
    assert ((chance[:, 1] == 1) == (place.center[:, 2] > 1)).all()


def test_a_service_learns_features_and_scores_them(
    address: str, made: tuple[ExampleFrame, Described]
) -> None:
    frame, place = made
    model = Models.parse(f"nearest={address}").make("nearest")
    assert (model.takes, model.learns, model.classes) == ("features", True, ())
    high = (place.center[:, 2] > 1).astype(np.int64)
    state = model.learn(place.features[::7], high[::7], CLASSES)
    chance = chances_of(model, CLASSES, state, place, frame, "own")
    assert ((chance.argmax(axis=1) == high).mean()) > 0.95
    assert np.allclose(chance.sum(axis=1), 1)


@pytest.mark.parametrize(
    ("scores", "told"),
    [
        (np.zeros((2000, 3)), "expected scores"),
        (np.full((2000, 2), np.nan), "finite"),
        (np.full((2000, 2), -1.0), "from 0"),
    ],
)
def test_scores_that_are_none_are_refused(
    scores: NDArray[np.float64], told: str, made: tuple[ExampleFrame, Described],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    frame, place = made
    model: Model = Heights()
    monkeypatch.setattr(model, "scores", lambda _: scores)
    with pytest.raises(UnavailableError, match=told):
        chances_of(model, CLASSES, b"", place, frame, "own")


def test_only_models_that_the_operator_allows_are_made(plug_in: None) -> None:
    with pytest.raises(BadInputError, match="expected one of heights; got 'http://else"):
        Models().make("http://elsewhere")
    for wrong in ("http://gpu:9000", "a=ftp://gpu", "a=http://x,a=http://y"):
        with pytest.raises(BadInputError, match="models"):
            Models.parse(wrong)
    with pytest.raises(UnavailableError, match="about"):
        Models.parse("gone=http://127.0.0.1:9").make("gone")
