"""Juggling: pins fly freely, tumble evenly, and meet the hands that catch them."""

from __future__ import annotations

import numpy as np
import pytest

from pointbrush.errors import BadInputError
from pointbrush.samples import generate
from pointbrush.samples.jugglers import JugglingOptions, JugglingScene
from pointbrush.samples.juggling import rhythm, schedule

FINE = 1 / 240


def scene(**options: object) -> JugglingScene:
    return JugglingScene(3, 4.0, JugglingOptions(**options))  # type: ignore[arg-type]


@pytest.mark.parametrize("options", [{}, {"pins": 3}, {"pins": 3, "passing": False, "people": 1}])
def test_flying_pins_fall_freely(options: dict[str, object]) -> None:
    juggle = scene(**options).juggle
    times = np.arange(0, 4, FINE)
    checked = 0
    for k in range(juggle.pins):
        y = np.array([juggle.pin(k, t)[:3, 3] for t in times])
        free = np.array([juggle.flying(k, t) for t in times])
        throughout = free[:-2] & free[1:-1] & free[2:]
        acceleration = np.diff(y, 2, axis=0) / FINE**2
        np.testing.assert_allclose(
            acceleration[throughout], np.tile([0, -9.81, 0], (throughout.sum(), 1)), atol=2e-6
        )
        checked += int(throughout.sum())
    assert checked > 200


def test_true_poses_in_camera_coordinates_fall_along_gravity() -> None:
    recording = generate(seed=3, frames=60)
    juggle, start = scene().juggle, scene().start
    down = np.linalg.inv(recording.scene.camera_pose)[:3, :3] @ [0, -9.81, 0]
    for k in range(juggle.pins):
        p = np.array([T[:3, 3] for T in recording.poses[k + 1]])
        free = np.array([juggle.flying(k, start + i / 30) for i in range(60)])
        inside = np.flatnonzero(free[:-2] & free[1:-1] & free[2:])
        bend = p[inside] - 2 * p[inside + 1] + p[inside + 2]
        np.testing.assert_allclose(bend, np.tile(down / 900, (inside.size, 1)), atol=1e-6)


def test_pins_tumble_twenty_to_forty_degrees_and_fly_some_fifteen_centimetres_a_frame() -> None:
    juggle = scene().juggle
    turns, steps = [], []
    for k in range(juggle.pins):
        for i in range(100):
            a, b = juggle.pin(k, i / 30), juggle.pin(k, (i + 1) / 30)
            if juggle.flying(k, i / 30) and juggle.flying(k, (i + 1) / 30):
                turns.append(np.degrees(np.arccos(np.clip(a[:3, 1] @ b[:3, 1], -1, 1))))
                steps.append(np.linalg.norm(b[:3, 3] - a[:3, 3]))
    assert 20 < np.median(turns) < 40
    assert np.median(steps) > 0.08
    assert 0.13 < np.quantile(steps, 0.95) < 0.2


def test_pins_never_jump() -> None:
    """Neither position nor direction breaks at a throw or a catch."""
    juggle = scene().juggle
    for k in range(juggle.pins):
        poses = np.array([juggle.pin(k, t) for t in np.arange(0, 4, FINE)])
        assert np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1).max() < 8 * FINE
        cosines = np.einsum("ni,ni->n", poses[:-1, :3, 1], poses[1:, :3, 1])
        assert np.degrees(np.arccos(np.clip(cosines, -1, 1))).max() < 8


def test_hands_hold_at_most_one_pin_and_all_pins_are_kept_up() -> None:
    throws = schedule(rhythm("774", 4, 0.16, 0.32), 0.0, 6.0)
    assert {t.pin for t in throws} == set(range(6))
    for hand in range(4):
        landings = sorted(t.arrive for t in throws if t.to_hand == hand)
        leavings = sorted(t.leave for t in throws if t.hand == hand and t.leave > landings[0])
        for arrive, leave, following in zip(landings, leavings, landings[1:], strict=False):
            assert arrive < leave < following


def test_pins_pass_between_the_people() -> None:
    juggle = scene().juggle
    for k in range(juggle.pins):
        x = [juggle.pin(k, t)[0, 3] for t in np.arange(0, 4, 0.05)]
        assert min(x) < -0.4
        assert max(x) > 0.4


@pytest.mark.parametrize("siteswap", ["", "x!", "54", "2"])
def test_impossible_patterns_are_refused(siteswap: str) -> None:
    with pytest.raises(BadInputError, match="pattern"):
        rhythm(siteswap, 4, 0.16, 0.32)


def test_labels_are_pins_then_people() -> None:
    names = [label.name for label in generate(frames=1).labels]
    assert names == [*(f"pin {k}" for k in range(1, 7)), "person 1", "person 2"]
    without = generate(frames=1, label_people=False)
    assert {label.category for label in without.labels} == {"pin"}
    assert without.truth[0].max() <= 6


def test_pins_can_be_painted_like_the_clothes() -> None:
    usual, alike = generate(frames=1, seed=2), generate(frames=1, seed=2, like_clothes=True)
    a, b = (r.frame(0).rgb[r.truth[0] == 1].mean(axis=0) for r in (usual, alike))
    assert np.abs(a - b).max() > 20


def test_a_watcher_holds_pins() -> None:
    recording = generate(frames=1, pins=3, passing=False, held=2)
    assert [label.name for label in recording.labels[:5]] == [f"pin {k}" for k in range(1, 6)]
    assert set(recording.poses) == {1, 2, 3, 4, 5}
    assert all((recording.truth[0] == pin).sum() > 40 for pin in (4, 5))
