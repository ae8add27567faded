"""Models of one's own that find masks: a plug-in and a service; nothing they answer is trusted."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from importlib.metadata import EntryPoint

import numpy as np
import pytest
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, UnavailableError
from pointbrush.exchange import model_names
from pointbrush.masks.models import FoundMasks, MaskModels, Prompt
from tests.services import example_service

SHAPE = (40, 60)
RED = (slice(10, 20), slice(5, 30))
NONE = np.empty((0, 2))


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """Where the documented example listens."""
    with example_service("mask_server.py") as url:
        yield url


def picture() -> NDArray[np.uint8]:
    found = np.full((*SHAPE, 3), 128, np.uint8)
    found[RED] = (250, 10, 0)
    return found


class Answer:
    """A plug-in with a fixed answer, which counts its instances."""

    made = 0
    answer = FoundMasks(np.ones(SHAPE, np.uint16), ("thing",))

    def __init__(self) -> None:
        Answer.made += 1

    def masks(self, _: Prompt) -> FoundMasks:
        return self.answer


@pytest.fixture
def plug_in(monkeypatch: pytest.MonkeyPatch) -> None:
    def entries(group: str, name: str | None = None) -> Sequence[EntryPoint]:
        assert group == "pointbrush.masks"
        every = [EntryPoint("fixed", f"{__name__}:Answer", group)]
        return [each for each in every if name in (None, each.name)]

    monkeypatch.setattr(model_names, "entry_points", entries)


def test_service_finds_masks_of_clicks_and_of_text(address: str) -> None:
    models = MaskModels.parse(f"toy={address}")
    inside = np.zeros(SHAPE, np.bool_)
    inside[RED] = True
    on, off = np.array([[10.0, 15.0]]), np.array([[50.0, 30.0]])
    for prompt, name, expected in (
        (Prompt(picture(), on, NONE), "object", inside),
        (Prompt(picture(), off, NONE, "wall"), "wall", ~inside),
        (Prompt(picture(), np.concatenate([on, off]), off), "object", inside),
        (Prompt(picture(), NONE, NONE, "red things"), "red", inside),
    ):
        found = models.masks("toy", prompt)
        assert found.names == (name,)
        assert np.array_equal(found.mask == 1, expected)


def test_plug_in_is_made_once_and_finds_masks(plug_in: None) -> None:
    for _ in range(2):
        found = MaskModels().masks("fixed", Prompt(picture(), NONE, NONE))
        assert (found.names, found.mask.min()) == (("thing",), 1)
    assert Answer.made == 1


@pytest.mark.parametrize(
    ("mask", "names", "words"),
    [
        (np.ones((60, 40), np.uint16), ("a",), r"uint16 \(40, 60\), got uint16 \(60, 40\)"),
        (np.ones(SHAPE), ("a",), "got float64"),
        (np.full(SHAPE, 2, np.uint16), ("a",), "got 2 with 1 names"),
        (np.ones(SHAPE, np.uint16), (" ",), "expected names"),
    ],
)
def test_answers_that_do_not_fit_the_picture_are_refused(
    mask: NDArray[np.uint16], names: tuple[str, ...], words: str,
    plug_in: None, monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setattr(Answer, "answer", FoundMasks(mask, names))
    with pytest.raises(UnavailableError, match=words):
        MaskModels().masks("fixed", Prompt(picture(), NONE, NONE))


def test_only_models_that_the_operator_allows_are_asked(plug_in: None) -> None:
    prompt = Prompt(picture(), NONE, NONE)
    with pytest.raises(BadInputError, match="expected one of fixed; got 'http://else"):
        MaskModels().masks("http://elsewhere", prompt)
    with pytest.raises(BadInputError, match="mask_models: expected NAME=http"):
        MaskModels.parse("a=ftp://gpu")
    with pytest.raises(UnavailableError, match="masks"):
        MaskModels.parse("gone=http://127.0.0.1:9").masks("gone", prompt)
