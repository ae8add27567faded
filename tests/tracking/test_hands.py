"""Two processes on one run: the labels of one, also when the second ends half-way."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import scenes

from pointbrush.frame import PointFrame
from pointbrush.sequences import Sequence, import_frames, open_sequence
from pointbrush.tracking import METHODS, FrameResult, Seed, TrackOptions
from pointbrush.tracking.parallel import second_process
from pointbrush.tracking.parallel.second_process import SecondProcess

FIRST, LAST = 5, 8


@pytest.fixture(scope="module")
def stored(tabletop: list[scenes.Frame], tmp_path_factory: pytest.TempPathFactory) -> Sequence:
    frames = [PointFrame(f.xyz, rgb=f.rgb, label=f.truth) for f in tabletop[FIRST : LAST + 1]]
    target = tmp_path_factory.mktemp("hands") / "tabletop"
    import_frames(frames, target, sequence_id="tabletop", name="tabletop", fps=30.0)
    return open_sequence(target)


def run(stored: Sequence, processes: int) -> list[FrameResult]:
    truth = stored[0].label
    assert truth is not None
    seeds = [Seed(n, np.flatnonzero(truth == n)) for n in np.unique(truth).tolist() if n]
    options = TrackOptions(processes=processes)
    order = range(len(stored))
    return list(METHODS["auto"]().track(stored.__getitem__, order, seeds, lambda _: None, options))


@pytest.fixture(scope="module")
def alone(stored: Sequence) -> list[FrameResult]:
    return run(stored, 1)


def assert_same(found: list[FrameResult], expected: list[FrameResult]) -> None:
    assert [r.frame for r in found] == [r.frame for r in expected]
    for one, other in zip(found, expected, strict=True):
        assert set(one.tracks) == set(other.tracks)
        for label, track in one.tracks.items():
            again = other.tracks[label]
            assert (track.state, track.points) == (again.state, again.points)
            assert track.confidence == again.confidence
            assert np.array_equal(track.pose, again.pose)
        for label, points in one.assignments.items():
            assert np.array_equal(points, other.assignments[label])


@pytest.fixture(scope="module", autouse=True)
def no_process_is_left() -> Iterator[None]:
    yield
    second_process.end_waiting()


def test_two_processes_find_what_one_finds(
    stored: Sequence, alone: list[FrameResult], monkeypatch: pytest.MonkeyPatch
) -> None:
    answers = []
    answer = SecondProcess.answer

    def counted(second: SecondProcess) -> Any:
        answers.append(answer(second))
        return answers[-1]

    monkeypatch.setattr(SecondProcess, "answer", counted)
    assert_same(run(stored, 2), alone)
    assert len(answers) >= len(stored) - 1


@pytest.mark.parametrize("when", ["know", "show", "ask", "answer", "learn"])
def test_a_run_goes_on_when_the_second_process_ends(
    stored: Sequence, alone: list[FrameResult], monkeypatch: pytest.MonkeyPatch, when: str
) -> None:
    do = getattr(SecondProcess, when)

    def ended(second: SecondProcess, *given: Any, **how: Any) -> Any:
        second._process.kill()
        second._process.wait()
        return do(second, *given, **how)

    monkeypatch.setattr(SecondProcess, when, ended)
    assert_same(run(stored, 2), alone)


def test_the_second_process_waits_for_the_next_run(
    stored: Sequence, alone: list[FrameResult]
) -> None:
    run(stored, 2)
    (waiting,) = second_process._spare
    assert_same(run(stored, 2), alone)
    assert second_process._spare == [waiting]
    assert waiting.poll() is None


def test_one_that_ended_while_it_waited_is_replaced(
    stored: Sequence, alone: list[FrameResult]
) -> None:
    second_process.make_ready()
    (waiting,) = second_process._spare
    waiting.kill()
    waiting.wait()
    assert_same(run(stored, 2), alone)
    assert waiting not in second_process._spare
    assert len(second_process._spare) == 1


def test_a_busy_second_process_is_ended(stored: Sequence) -> None:
    second_process.end_waiting()
    second = SecondProcess(stored.__getitem__)
    second._asked.append(1)
    second.close()
    assert not second_process._spare
    assert second._process.poll() is not None
