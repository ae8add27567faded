"""Suspicious things: each kind is found where it was put, and nothing in sound labels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from pointbrush.labels import Label
from pointbrush.work.reviewing.checks import counting, positions
from pointbrush.work.reviewing.checks.finding import CheckOptions, finding, grouped
from pointbrush.work.reviewing.checks.positions import Sketch, sketch_frame

OPTIONS = CheckOptions()
PIN = Label(1, "pin")
FRAMES = 12


def ball(center: tuple[float, float, float], count: int = 400, seed: int = 0) -> np.ndarray:
    """Points on a ball of 10 cm."""
    ways = np.random.default_rng(seed).normal(size=(count, 3))
    return (np.asarray(center) + 0.1 * ways / np.linalg.norm(ways, axis=1)[:, None]).astype("f4")


def sketches(centers: list[tuple[float, float, float]]) -> dict[int, Mapping[int, Sketch]]:
    return {
        frame: sketch_frame(ball(center), np.ones(400, np.uint16), None, np.zeros(3), OPTIONS)
        for frame, center in enumerate(centers)
    }


def counts(*values: int) -> dict[int, np.ndarray]:
    return {1: np.array(values, np.int64)}


def unlike(mine: dict[int, np.ndarray], excused: dict[int, set[int]] | None = None) -> list[int]:
    found = counting.unlike_neighbours([PIN], mine, len(mine[1]), excused or {}, OPTIONS)
    return [each.first for each in found if each.first is not None]


def test_labels_of_one_name() -> None:
    palette = [PIN, Label(2, "ball"), Label(3, " Pin", "juggling")]
    there = {n: np.zeros(3, np.int64) for n in (1, 2, 3)}
    there[3][2] = 40
    (found,) = counting.same_names(palette, there)
    assert (found.labels, found.first) == ((1, 3), 2)


def test_labels_in_use_without_a_category() -> None:
    palette = [PIN, Label(2, "van 1"), Label(3, "car 1", "car"), Label(4, "unused")]
    there = {n: np.full(3, n != 4) for n in (1, 2, 3, 4)}
    (found,) = counting.no_category(palette, there, ())
    assert (found.labels, found.first) == ((1, 2), None)
    assert "“pin”, “van 1” have no category" in found.text
    assert [*counting.no_category(palette[:2], there, ())] == [], "names alone"
    (boxed,) = counting.no_category([PIN, palette[3]], there, {4})
    assert boxed.labels == (1, 4)


def test_a_label_of_three_points_and_one_of_none() -> None:
    found = list(counting.few_points([PIN], counts(300, 3, 310, 6), OPTIONS))
    assert [(each.first, each.text) for each in found] == [(1, "“pin” has only 3 points")]
    (unused,) = counting.few_points([PIN], counts(0, 0), OPTIONS)
    assert (unused.first, unused.text) == (None, "“pin” has no points in any frame")


def test_labels_without_points_are_one_line() -> None:
    palette = [replace(PIN, id=number, name=f"pin {number}") for number in range(1, 8)]
    nowhere = {label.id: np.zeros(2, np.int64) for label in palette}
    (unused,) = counting.few_points(palette, nowhere, OPTIONS)
    assert unused.labels == (1, 2, 3, 4, 5, 6, 7)
    assert unused.text.endswith("“pin 3” and 4 more have no points in any frame")


def test_points_far_from_their_object_and_their_place() -> None:
    slip = ball((0.0, 0.0, 4.5), 12, seed=1)
    xyz = np.vstack([ball((0, 0, 3)), slip])
    label = np.ones(len(xyz), np.uint16)
    found = sketch_frame(xyz, label, None, np.array([100.0, 0.0, 0.0]), OPTIONS)
    (finding,) = positions.stray_points([PIN], {7: found})
    assert (finding.first, finding.labels) == (7, (1,))
    assert finding.text.startswith("12 points of “pin” 1.")
    assert finding.place == pytest.approx((100.0, 0.0, 4.5), abs=0.1)


@pytest.mark.parametrize("gap", [0.1, 0.3])
def test_an_object_that_is_seen_in_parts_is_no_stray(gap: float) -> None:
    xyz = np.vstack([ball((0, 0, 3)), ball((0.2 + gap, 0, 3), seed=1)])
    found = sketch_frame(xyz, np.ones(800, np.uint16), None, np.zeros(3), OPTIONS)
    assert found[1].stray is None


def test_sparse_points_far_away_are_one_object() -> None:
    grid = np.stack(np.meshgrid(np.arange(5) * 0.5, np.arange(4) * 0.5, [40.0]), -1)
    xyz = grid.reshape(-1, 3).astype("f4")
    found = sketch_frame(xyz, np.ones(len(xyz), np.uint16), None, np.zeros(3), OPTIONS)
    assert found[1].stray is None


def test_a_track_that_jumps_and_one_that_flies() -> None:
    flight = [(0.15 * n, 0.0, 3.0) for n in range(FRAMES)]
    assert list(positions.jumps([PIN], sketches(flight), OPTIONS)) == []
    flight[6] = (0.9, 1.0, 3.0)
    found = grouped(positions.jumps([PIN], sketches(flight), OPTIONS))
    assert [(each.first, each.last) for each in found] == [(6, 7)]
    assert found[0].place == pytest.approx((0.9, 1.0, 3.0), abs=0.05)


def test_what_stands_in_the_world_does_not_jump_when_the_sensor_does() -> None:
    def seen(frame: int, x: float) -> Mapping[int, Sketch]:
        pose = np.eye(4)
        pose[0, 3] = x
        xyz = ball((-x, 0, 3))
        return sketch_frame(xyz, np.ones(400, np.uint16), pose, np.zeros(3), OPTIONS)

    drive = {frame: seen(frame, 2.0 if frame >= 4 else 0.0) for frame in range(8)}
    assert list(positions.jumps([PIN], drive, OPTIONS)) == []


def test_a_frame_without_labels_is_said_once() -> None:
    mine = {1: np.array([90, 0, 95]), 2: np.array([50, 0, 55])}
    palette = [PIN, Label(2, "ball")]
    found = list(counting.unlike_neighbours(palette, mine, 3, {}, OPTIONS))
    assert [(each.labels, each.first) for each in found] == [((), 1)]


def test_counts_unlike_those_beside() -> None:
    assert unlike(counts(300, 310, 295, 40, 305, 300, 290)) == [3]
    assert unlike(counts(300, 310, 295, 2000, 305, 300, 290)) == [3]
    assert unlike(counts(300, 250, 200, 150, 110, 90, 70)) == []
    assert unlike(counts(9, 11, 8, 28, 10, 9, 8)) == []


def test_a_gap_is_told_unless_it_is_long_or_known() -> None:
    other = {2: np.full(12, 80)}
    palette = [PIN, Label(2, "ball")]

    def gaps(mine: list[int], excused: dict[int, set[int]]) -> list[int | None]:
        there = {1: np.array(mine), **other}
        found = counting.unlike_neighbours(palette, there, 12, excused, OPTIONS)
        return [each.first for each in found]

    short = [90, 90, 90, 0, 0, 90, 90, 90, 90, 90, 90, 90]
    assert gaps(short, {}) == [3, 4]
    assert gaps(short, {1: {3, 4}}) == []
    assert gaps([90, 90, 0, 0, 0, 0, 0, 0, 90, 90, 90, 90], {}) == []


def test_consecutive_frames_are_one_finding() -> None:
    found = [finding("few", f"{n}", (1,), n, n) for n in (5, 3, 4, 9)]
    assert [(each.first, each.last, each.text) for each in grouped(found)] == [
        (3, 5, "3"),
        (9, 9, "9"),
    ]


def test_a_label_that_comes_back_in_doubt_is_asked_about_once() -> None:
    def asked(*frames: tuple[str, float]) -> list[tuple[int | None, int | None]]:
        tracks = [
            {"frame": n, "label": 1, "state": state, "confidence": sure}
            for n, (state, sure) in enumerate(frames)
        ]
        found = list(counting.returns([PIN], tracks, OPTIONS))
        assert all("still “pin”?" in each.text for each in found)
        return [(each.first, each.last) for each in found]

    sure, doubtful, hidden, painted = (
        ("tracked", 0.9), ("tracked", 0.4), ("occluded", 0.0), ("painted", 1.0),
    )  # fmt: skip
    assert asked(painted, sure, hidden, *[doubtful] * 6, sure, painted, doubtful) == [(3, 9)]
    assert asked(painted, hidden, doubtful, ("lost", 0.0), doubtful) == [(2, 2), (4, 4)]
    assert asked(painted, hidden, doubtful, doubtful, sure, sure) == [], "found for sure again"
    assert asked(painted, doubtful, doubtful, doubtful, doubtful) == [], "never out of sight"
