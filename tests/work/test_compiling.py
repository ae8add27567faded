"""Compiling loops once on a machine, step by step, by one process while others wait."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from pointbrush.compiled import compiled
from pointbrush.errors import CancelledError
from pointbrush.work.loops import steps as loop_steps
from pointbrush.work.loops.compiling import (
    STEPS,
    Progress,
    StepName,
    are_compiled,
    hold,
)
from pointbrush.work.loops.steps import Step, estimate
from pointbrush.work.prepare import ensure_compiled
from tests.waiting import eventually


@pytest.fixture(autouse=True)
def nothing_compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))


def run_by(monkeypatch: pytest.MonkeyPatch, runs: dict[StepName, Callable[[], None]]) -> None:
    """Have steps do something short."""
    steps = {name: Step(run, ("loops_of_a_test",), 10) for name, run in runs.items()}
    monkeypatch.setattr(loop_steps, "RUNS", steps)


def test_steps_are_done_once_in_the_order_of_their_first_use(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    done: list[tuple[StepName, list[StepName]]] = []

    def run(name: StepName) -> Callable[[], None]:
        return lambda: done.append((name, [each for each in STEPS if are_compiled([each])]))

    run_by(monkeypatch, {name: run(name) for name in STEPS})
    assert not are_compiled()
    for _ in range(2):
        ensure_compiled(STEPS)
    assert [name for name, _ in done][:3] == ["objects", "things", "people"]
    # Each can be used as soon as it is done itself.
    assert [list(ready) for _, ready in done] == [list(STEPS[:n]) for n in range(len(STEPS))]
    assert are_compiled()
    monkeypatch.setattr("pointbrush.__version__", "another")
    assert not are_compiled(["objects"])


def test_what_was_interrupted_is_begun_again(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted() -> None:
        raise KeyboardInterrupt

    run_by(monkeypatch, {"objects": interrupted})
    with pytest.raises(KeyboardInterrupt):
        ensure_compiled(["objects"])
    assert not are_compiled(["objects"])
    run_by(monkeypatch, {"objects": lambda: None})
    ensure_compiled(["objects"])
    assert are_compiled(["objects"])


def test_a_step_goes_on_with_each_loop_and_can_be_cancelled_at_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    space: dict[str, Callable[[int], int]] = {"compiled": compiled, "__name__": "loops_of_a_test"}  # type: ignore[dict-item]
    exec(
        "@compiled\ndef one(x):\n    return x + 1\n@compiled\ndef two(x):\n    return x - 1\n",
        space,
    )

    def run() -> None:
        space["one"](1)
        space["two"](1)

    run_by(monkeypatch, {"things": run})
    seen: list[Progress] = []

    def report(progress: Progress) -> None:
        seen.append(progress)
        if len(seen) == 2:
            raise CancelledError("cancelled")

    with pytest.raises(CancelledError):
        ensure_compiled(["things"], report)
    assert [each.share for each in seen] == [0, 0.5]
    assert all(each.seconds is not None for each in seen)
    assert not are_compiled(["things"])
    ensure_compiled(["things"])
    assert are_compiled(["things"])


def test_a_step_that_is_being_compiled_is_waited_for_and_holds_up_no_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    ran: list[StepName] = []
    run_by(monkeypatch, {name: lambda name=name: ran.append(name) for name in STEPS})  # type: ignore[misc]
    with hold("people") as note:
        assert note is not None
        note(Progress(0.25, 30.0))
        ensure_compiled(["objects"])
        assert ran == ["objects"]
        seen: list[Progress] = []
        waiting = threading.Thread(target=lambda: ensure_compiled(["people"], seen.append))
        waiting.start()
        eventually(lambda: seen)
    waiting.join()
    assert seen[0] == Progress(0.25, 30.0)
    assert ran == ["objects", "people"]  # the process that held it has died


def test_the_estimate_begins_with_what_is_expected_and_follows_what_it_takes() -> None:
    assert estimate(0.0, 0.0, 20.0) == Progress(0.0, 20.0)
    assert estimate(1.0, 30.0, 20.0) == Progress(1.0, 0.0)
    slow, quick = estimate(0.5, 40.0, 20.0).seconds, estimate(0.5, 10.0, 20.0).seconds
    assert slow is not None
    assert quick is not None
    assert slow > 2 * quick
