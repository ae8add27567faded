"""One suite for every tracking method."""

from __future__ import annotations

import pickle
from dataclasses import dataclass

import numpy as np
import pytest
import scenes
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pointbrush.errors import BadInputError
from pointbrush.tracking import METHODS, FrameKnowledge, Seed, TrackOptions

NAMES = ["icp", "color-icp", "auto"]


def nothing(_frame: int) -> None:
    return None


def seeds_of(frame: scenes.Frame) -> list[Seed]:
    assert frame.truth is not None
    labels = [n for n in np.unique(frame.truth).tolist() if n]
    return [Seed(n, np.flatnonzero(frame.truth == n)) for n in labels]


def iou(found: np.ndarray, truth: np.ndarray) -> float:
    mask = np.zeros(len(truth), bool)
    mask[found] = True
    return float((mask & truth).sum() / max(1, (mask | truth).sum()))


@dataclass
class Painted:
    """Knowledge with label 1 painted in one frame."""

    frames: list[scenes.Frame]
    at: int

    def __call__(self, number: int) -> FrameKnowledge:
        truth = self.frames[number].truth
        label = np.where((truth == 1) & (number == self.at), 1, 0).astype(np.uint16)
        return FrameKnowledge(label, (label > 0).astype(np.uint8), np.zeros(len(label), bool))


@pytest.mark.parametrize("name", NAMES)
def test_objects_on_a_table_are_followed_either_way(
    name: str, tabletop: list[scenes.Frame]
) -> None:
    for order in (list(range(8)), list(range(7, -1, -1))):
        seeds = seeds_of(tabletop[order[0]])
        results = list(
            METHODS[name]().track(tabletop.__getitem__, order, seeds, nothing, TrackOptions())
        )
        assert [r.frame for r in results] == order
        assert {t.state for t in results[0].tracks.values()} == {"painted"}
        assert not results[0].assignments
        last = results[-1]
        truth = tabletop[order[-1]].truth
        scores = [iou(last.assignments[s.label], truth == s.label) for s in seeds]
        assert np.mean(scores) > (0.8 if name == "auto" else 0.15)


@pytest.mark.parametrize("name", NAMES)
def test_results_pickle_and_labels_share_no_point(name: str, tabletop: list[scenes.Frame]) -> None:
    run = METHODS[name]().track(
        tabletop.__getitem__, range(4), seeds_of(tabletop[0]), nothing, TrackOptions()
    )
    for result in run:
        again = pickle.loads(pickle.dumps(result))
        assert again.frame == result.frame
        taken = np.concatenate([np.empty(0, np.int64), *result.assignments.values()])
        assert len(np.unique(taken)) == len(taken)
        for label, points in result.assignments.items():
            assert (np.diff(points) > 0).all()
            assert result.tracks[label].points == len(points)
            assert 0 <= result.tracks[label].confidence <= 1


@pytest.mark.parametrize("name", NAMES)
def test_runs_are_deterministic(name: str, tabletop: list[scenes.Frame]) -> None:
    def run() -> list[bytes]:
        method = METHODS[name]()
        order, seeds = range(4), seeds_of(tabletop[0])
        return [
            pickle.dumps((dict(r.assignments), {k: t.confidence for k, t in r.tracks.items()}))
            for r in method.track(tabletop.__getitem__, order, seeds, nothing, TrackOptions())
        ]

    assert run() == run()


@pytest.mark.parametrize("name", NAMES)
def test_what_people_decided_stays(name: str, tabletop: list[scenes.Frame]) -> None:
    """Painted, deleted and locked points are in no assignment, except a label's own anchors."""
    rng = np.random.default_rng(5)

    def known(number: int) -> FrameKnowledge:
        n = len(tabletop[number].xyz)
        label = rng.integers(0, 9, n).astype(np.uint16)
        provenance = np.where(label > 0, rng.integers(1, 4, n), 0).astype(np.uint8)
        know[number] = FrameKnowledge(label, provenance, rng.random(n) < 0.2)
        return know[number]

    know: dict[int, FrameKnowledge] = {}
    cached = lambda n: know[n] if n in know else known(n)  # noqa: E731
    seeds = seeds_of(tabletop[0])
    options = TrackOptions(locked=frozenset({8}))
    for result in METHODS[name]().track(tabletop.__getitem__, range(3), seeds, cached, options):
        k = know.get(result.frame)
        for label, points in result.assignments.items():
            assert k is not None
            assert not k.deleted[points].any()
            assert not (k.label[points] == 8).any()
            painted = k.provenance[points] == 1
            assert (k.label[points][painted] == label).all()


def test_a_painted_frame_further_on_is_met_from_both_sides(tabletop: list[scenes.Frame]) -> None:
    known = Painted(tabletop, at=10)
    order = range(14)
    seeds = seeds_of(tabletop[0])
    results = list(
        METHODS["icp"]().track(tabletop.__getitem__, order, seeds, known, TrackOptions())
    )
    assert [r.frame for r in results] == list(order)
    assert results[10].tracks[1].state == "painted"
    assert iou(results[10].assignments[1], tabletop[10].truth == 1) == 1.0
    assert iou(results[9].assignments[1], tabletop[9].truth == 1) > 0.6
    until = TrackOptions(until_painted=True)
    short = list(METHODS["icp"]().track(tabletop.__getitem__, order, seeds[:1], known, until))
    assert [r.frame for r in short] == list(range(11))


@pytest.mark.parametrize("name", NAMES)
def test_bad_seeds_are_refused(name: str, tabletop: list[scenes.Frame]) -> None:
    method = METHODS[name]()
    for order, seeds in (
        ([0, 1], [Seed(1, np.empty(0, np.int64))]),
        ([0, 1], [Seed(1, np.array([10**9]))]),
        ([0, 1], []),
        ([], seeds_of(tabletop[0])),
        ([0, 2, 1], seeds_of(tabletop[0])),
    ):
        with pytest.raises(BadInputError):
            list(method.track(tabletop.__getitem__, order, seeds, nothing, TrackOptions()))


def hard_frame(kind: str, n: int, rng: np.random.Generator, colour: bool) -> scenes.Frame:
    xyz = rng.normal(size=(n, 3)).astype(np.float32)
    if kind == "same":
        xyz[:] = 1.0
    if kind == "empty":
        xyz = xyz[:0]
    rgb = rng.integers(0, 255, (len(xyz), 3)).astype(np.uint8) if colour else None
    return scenes.Frame(xyz, rgb, viewpoint=None)


@settings(max_examples=15, suppress_health_check=[HealthCheck.too_slow])
@given(
    kinds=st.lists(st.sampled_from(["random", "same", "empty"]), min_size=2, max_size=5),
    n=st.sampled_from([1, 2, 3, 50]),
    colour=st.booleans(),
    name=st.sampled_from(NAMES),
    seen=st.booleans(),
    seed=st.integers(0, 9),
)
def test_hard_frames_are_flagged_and_never_raise(
    kinds: list[str], n: int, colour: bool, name: str, seen: bool, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    frames = [hard_frame("random", n, rng, colour)]
    frames += [hard_frame(kind, n, rng, colour) for kind in kinds]
    if seen:
        for frame in frames:
            frame.viewpoint = np.zeros(3)
    seeds = [Seed(1, np.arange(max(1, n // 2)))]
    options = TrackOptions(continue_lost=True)
    results = list(
        METHODS[name]().track(frames.__getitem__, range(len(frames)), seeds, nothing, options)
    )
    assert len(results) == len(frames)
    for frame, result in zip(frames, results, strict=True):
        track = result.tracks[1]
        assert np.isfinite(track.pose).all()
        assert np.isfinite([track.rmse, track.confidence, track.inliers]).all()
        if len(frame.xyz) == 0:
            assert track.state in ("lost", "occluded")
