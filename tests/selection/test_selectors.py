"""Selectors: the built-in one, a service over HTTP, plug-ins; one suite for each of them."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pointbrush.errors import BadInputError, UnavailableError
from pointbrush.selection import selectors
from pointbrush.selection.objects import ObjectFrame
from pointbrush.selection.selectors import (
    Selector,
    StateLostError,
    StoredSelector,
    make_selector,
)
from pointbrush.work.objects.choosing import Selectors
from tests.services import example_service

EXAMPLE = "selector_server.py"
NONE = np.empty((0, 3))


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """Where the documented example listens."""
    with example_service(EXAMPLE) as url:
        yield url


@pytest.fixture(params=["tree", "http"])
def selector(request: pytest.FixtureRequest) -> Selector:
    name = "tree" if request.param == "tree" else request.getfixturevalue("address")
    return make_selector(name)


@pytest.fixture
def frame() -> ObjectFrame:
    """A ball of 20 cm in the air, and a wall behind it."""
    rng = np.random.default_rng(0)
    ball = rng.normal(size=(800, 3))
    ball = 0.1 * ball / np.linalg.norm(ball, axis=1, keepdims=True) + [0, 1, 1]
    wall = np.column_stack([rng.uniform(-1, 1, (3000, 2)) + [0, 1], np.full(3000, 2.0)])
    return ObjectFrame(np.concatenate([ball, wall]).astype(np.float32))


CLICK = np.array([[0.0, 1.0, 0.9]])


def test_candidates_hold_the_click_and_no_negative_one(
    selector: Selector, frame: ObjectFrame
) -> None:
    state = selector.prepare(frame)
    found = selector.candidates(state, CLICK, np.array([[0.5, 1.5, 2.0]]), None)
    assert 1 <= len(found) <= 6
    for numbers, score in found:
        assert (np.diff(numbers) > 0).all()
        away = np.linalg.norm(frame.xyz[numbers] - CLICK, axis=1)
        assert away.min() < 0.03
        assert np.linalg.norm(frame.xyz[numbers] - [0.5, 1.5, 2.0], axis=1).min() > 0.02
        assert np.isfinite(score)


def test_a_stored_state_answers_as_the_one_it_was_made_of(
    selector: Selector, frame: ObjectFrame, tmp_path: Path
) -> None:
    assert isinstance(selector, StoredSelector)
    state = selector.prepare(frame)
    selector.save(state, tmp_path / "state.npz")
    again = selector.load(tmp_path / "state.npz")
    before, after = (selector.candidates(s, CLICK, NONE, None) for s in (state, again))
    assert all(np.array_equal(a, b) for (a, _), (b, _) in zip(before, after, strict=True))


def test_a_damaged_state_is_refused(selector: Selector, tmp_path: Path) -> None:
    assert isinstance(selector, StoredSelector)
    (tmp_path / "state.npz").write_bytes(b"PK not a state")
    with pytest.raises(BadInputError, match=r"state\.npz: expected"):
        selector.load(tmp_path / "state.npz")


def test_a_state_that_the_service_forgot_is_told(
    address: str, frame: ObjectFrame, tmp_path: Path
) -> None:
    selector = make_selector(address)
    assert isinstance(selector, StoredSelector)
    np.savez(tmp_path / "old.npz", state=np.frombuffer(b"frame-0", np.uint8), count=np.array(3800))
    with pytest.raises(StateLostError):
        selector.candidates(selector.load(tmp_path / "old.npz"), CLICK, NONE, None)


def test_a_service_that_is_not_there(frame: ObjectFrame) -> None:
    with pytest.raises(UnavailableError, match="expected an answer to prepare"):
        make_selector("http://127.0.0.1:9").prepare(frame)


class Nothing:
    """A plug-in that takes nothing and keeps no states on disk."""

    def prepare(self, frame: ObjectFrame) -> int:
        return len(frame.xyz)

    def candidates(self, *_: Any) -> list[Any]:
        return []


def test_plug_ins_are_found_by_their_entry_point(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = EntryPoint("nothing", f"{__name__}:Nothing", "pointbrush.selectors")
    monkeypatch.setattr(selectors, "entry_points", lambda **_: [entry])
    assert make_selector("nothing").candidates(1, CLICK, NONE, None) == []
    with pytest.raises(BadInputError, match="expected one of tree, nothing, http"):
        make_selector("other")


def test_a_recording_may_have_a_selector_of_its_own() -> None:
    chosen = Selectors.parse("street-1=http://127.0.0.1:9000/a?b=1, tree")
    assert chosen.of("street-1").name == "http://127.0.0.1:9000/a?b=1"
    assert chosen.of("juggling").name == "tree"
    assert Selectors.parse("http://127.0.0.1:9/x=1").common.name == "http://127.0.0.1:9/x=1"
    with pytest.raises(BadInputError, match="expected one for recording 'a', got two"):
        Selectors.parse("a=tree,a=tree")
    with pytest.raises(BadInputError, match="selector: expected one of tree"):
        Selectors.parse("a=nothing-like-it")
