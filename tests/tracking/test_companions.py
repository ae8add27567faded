"""Runs of some of the labels: the others of the first frame go along."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest
import scenes

from pointbrush.tracking import METHODS, FrameKnowledge, FrameResult, Seed, TrackOptions, TrackState
from pointbrush.tracking.bidirectional import BothSides
from pointbrush.tracking.interface import PAINTED, Frames, Known
from pointbrush.tracking.options.tracks import CompanionOptions
from pointbrush.tracking.permissions import Companions, FrameRules
from pointbrush.tracking.tracker import Run

BLUE = (40, 90, 200)
TRACKED = 2
OPTIONS = CompanionOptions()


def nothing(_: int) -> FrameKnowledge | None:
    return None


def row(frames: int = 6) -> list[scenes.Frame]:
    """Three like boxes in a row that go to the right, half as far in a frame as they are apart."""
    rng = np.random.default_rng(7)
    camera = scenes.Camera(scenes.Sensor(256, 212), scenes.room())
    size = np.array([0.06, 0.12, 0.05])

    def box(label: int, number: int) -> scenes.Part:
        at = np.array([-0.8 + 0.16 * label + 0.075 * number, 1.2, 1.8])
        return scenes.Part(label, BLUE, at, size, rot=np.eye(3))

    return [camera.shoot([box(n, k) for n in (1, 2, 3)], rng) for k in range(frames)]


def known_first(frames: list[scenes.Frame]) -> Known:
    """All of the truth of the first frame, tracked, and nothing of the others."""
    label = frames[0].truth.astype(np.uint16)
    source = np.where(label > 0, TRACKED, 0).astype(np.uint8)

    def known(number: int) -> FrameKnowledge | None:
        return None if number else FrameKnowledge(label, source, np.zeros(len(label), np.bool_))

    return known


def run(frames: list[scenes.Frame], labels: list[int], known: Known) -> list[FrameResult]:
    seeds = [Seed(n, np.flatnonzero(frames[0].truth == n)) for n in labels]
    order = range(len(frames))
    return list(METHODS["auto"]().track(frames.__getitem__, order, seeds, known, TrackOptions()))


def worst(frames: list[scenes.Frame], results: list[FrameResult], label: int) -> float:
    overlaps = []
    for found in results[1:]:
        truth = np.flatnonzero(frames[found.frame].truth == label)
        points = found.assignments.get(label, np.empty(0, np.int64))
        both = len(np.intersect1d(truth, points))
        overlaps.append(both / (len(truth) + len(points) - both))
    return min(overlaps)


@pytest.mark.parametrize("label", [1, 2])
def test_one_of_several_alike_is_found_as_in_a_run_of_all(label: int) -> None:
    frames = row()
    alone = run(frames, [label], nothing)
    beside = run(frames, [label], known_first(frames))
    together = run(frames, [1, 2, 3], nothing)
    assert worst(frames, beside, label) > 0.9 > 0.6 > worst(frames, alone, label)
    for found, of_all in zip(beside, together, strict=True):
        assert list(found.tracks) == [label]
        assert set(found.assignments) <= {label}
        assert np.array_equal(found.tracks[label].pose, of_all.tracks[label].pose)
        assert found.tracks[label].confidence == of_all.tracks[label].confidence
        if found.frame:
            assert np.array_equal(found.assignments[label], of_all.assignments[label])


def labelled(**points: int) -> FrameKnowledge:
    """A frame of so many points of each label, in turn; ``painted_3`` is label 3, painted."""
    parts = [(int(name[-1]), name.startswith("painted"), n) for name, n in points.items()]
    label = np.concatenate([np.full(n, label, np.uint16) for label, _, n in parts])
    source = np.concatenate([np.full(n, PAINTED if p else TRACKED, np.uint8) for _, p, n in parts])
    return FrameKnowledge(label, source, np.zeros(len(label), np.bool_))


def rules(knowledge: FrameKnowledge, options: TrackOptions | None = None) -> FrameRules:
    return FrameRules(len(knowledge.label), knowledge, options or TrackOptions())


def line(*counts: int, spacing: float = 0.01) -> np.ndarray:
    """(N, 3) points in a line for each of the counts, one beginning where the other ends."""
    xyz = np.zeros((sum(counts), 3), np.float32)
    xyz[:, 0] = spacing * np.arange(len(xyz))
    return xyz


def test_who_goes_along_is_labelled_in_the_first_frame_and_no_floor() -> None:
    first = labelled(tracked_1=20, tracked_2=30, tracked_3=50, tracked_4=5)
    companions = Companions([Seed(1, np.arange(22))], rules(first), line(20, 30, 50, 5), OPTIONS)
    assert [seed.label for seed in companions.beginning] == [2]
    # Two of its points were asked for as another's.
    assert np.array_equal(companions.beginning[0].indices, np.arange(22, 50))


def test_of_many_the_nearest_go_along() -> None:
    counts = [20] * (OPTIONS.most + 3)
    label = np.repeat(np.arange(1, len(counts) + 1), 20).astype(np.uint16)
    source = np.full(len(label), TRACKED, np.uint8)
    first = FrameKnowledge(label, source, np.zeros(len(label), np.bool_))
    companions = Companions([Seed(1, np.arange(20))], rules(first), line(*counts), OPTIONS)
    assert [seed.label for seed in companions.beginning] == list(range(2, OPTIONS.most + 2))
    later = replace(first, provenance=np.full(len(label), PAINTED, np.uint8))
    followed = {1, *range(2, OPTIONS.most + 1)}
    there = companions.known(rules(later), line(*counts), followed)
    assert set(there) - followed == {OPTIONS.most + 1}


@pytest.mark.parametrize(
    ("options", "known"),
    [
        (TrackOptions(), [3, 4]),
        (TrackOptions(overwrite="never"), [2, 3, 4]),
        (TrackOptions(locked=frozenset({2})), [2, 3, 4]),
        (TrackOptions(overwrite="all"), []),
    ],
)
def test_who_is_painted_or_may_not_be_taken_is_known(
    options: TrackOptions, known: list[int]
) -> None:
    first = labelled(tracked_1=20, tracked_2=20)
    companions = Companions([Seed(1, np.arange(20))], rules(first), line(20, 20), OPTIONS)
    later = labelled(painted_1=20, tracked_2=20, painted_3=20, painted_4=20, tracked_5=20)
    xyz = line(20, 20, 20, 20, 20)
    there = companions.known(rules(later, options), xyz, {1, 2, 3})
    assert list(there) == known
    assert all(np.array_equal(p, np.flatnonzero(later.label == n)) for n, p in there.items())


def test_who_is_painted_on_the_way_goes_along_from_there() -> None:
    frames = row(4)

    def known(number: int) -> FrameKnowledge:
        truth = frames[number].truth.astype(np.uint16)
        label = np.where((truth == 3) & (number == 2), 3, 0).astype(np.uint16)
        source = np.where(label > 0, PAINTED, 0).astype(np.uint8)
        return FrameKnowledge(label, source, np.zeros(len(label), np.bool_))

    seeds = [Seed(n, np.flatnonzero(frames[0].truth == n)) for n in (1, 2)]
    order = list(range(len(frames)))
    together = Run(frames.__getitem__, order, seeds, known, TrackOptions())
    with closing(together.scene):
        together.start(seeds)
        followed = [together.step(number) and set(together.tracks) for number in order[1:]]
    assert followed == [{1, 2}, {1, 2, 3}, {1, 2, 3}]
    assert all(set(found.tracks) == {1, 2} for found in run(frames, [1, 2], known))


class Listening:
    """A method that keeps every label where it was, and what is known where each run begins."""

    def __init__(self) -> None:
        self.begun: list[tuple[int, FrameKnowledge | None]] = []

    def track(
        self,
        frames: Frames,  # noqa: ARG002
        order: Sequence[int],
        seeds: Sequence[Seed],
        known: Known,
        options: TrackOptions,  # noqa: ARG002
    ) -> Iterator[FrameResult]:
        self.begun.append((order[0], known(order[0])))
        for number in order:
            points = {seed.label: seed.indices for seed in seeds}
            state = TrackState(np.eye(4), 0.0, 1.0, 0.5, 1, "tracked")
            yield FrameResult(number, points, dict.fromkeys(points, state))


def test_a_run_back_from_a_painted_frame_knows_what_was_found_there() -> None:
    frames = row(4)

    def known(number: int) -> FrameKnowledge | None:
        if number != 3:
            return None
        label = np.where(np.arange(len(frames[3].xyz)) < 20, 1, 0).astype(np.uint16)
        return FrameKnowledge(label, label.astype(np.uint8), np.zeros(len(label), np.bool_))

    method = Listening()
    seeds = [Seed(1, np.arange(20)), Seed(2, np.arange(20, 50))]
    list(BothSides(method).track(frames.__getitem__, range(4), seeds, known, TrackOptions()))
    assert [number for number, _ in method.begun] == [0, 3]
    there = method.begun[1][1]
    assert there is not None
    assert np.array_equal(np.flatnonzero(there.label == 2), np.arange(20, 50))
    assert np.array_equal(np.flatnonzero(there.provenance), np.arange(20))


def test_who_was_found_before_is_followed_only_while_near() -> None:
    rng = np.random.default_rng(3)
    camera = scenes.Camera(scenes.Sensor(256, 212), scenes.room())
    size = np.array([0.06, 0.12, 0.05])

    def box(label: int, x: float) -> scenes.Part:
        return scenes.Part(label, BLUE, np.array([x, 1.2, 1.8]), size, rot=np.eye(3))

    frames = [camera.shoot([box(1, -0.6 + 0.08 * k), box(2, 0.1)], rng) for k in range(8)]

    def known(number: int) -> FrameKnowledge:
        label = frames[number].truth.astype(np.uint16)
        source = np.where(label > 0, TRACKED, 0).astype(np.uint8)
        return FrameKnowledge(label, source, np.zeros(len(label), np.bool_))

    seeds = [Seed(1, np.flatnonzero(frames[0].truth == 1))]
    followed = []
    going = Run(frames.__getitem__, list(range(8)), seeds, known, TrackOptions())
    with closing(going.scene):
        going.start(seeds)
        for number in range(1, 8):
            going.step(number)
            followed.append(2 in going.tracks)
    assert followed == sorted(followed)
    assert not any(followed[:3])
    assert followed[-1]
    assert worst(frames, run(frames, [1], known), 1) > 0.9
