"""The sensor: noise that grows with distance, flying and missing pixels, honest truth."""

from __future__ import annotations

import numpy as np
import pytest

from pointbrush.samples import generate
from pointbrush.samples.sensor import FLYING_TOLERANCE, Sensor, deviation, measure

SHAPE = (212, 256)


def wall(distance: float, sensor: Sensor, infrared: float = 0.6) -> np.ndarray:
    rng = np.random.default_rng(1)
    depth = np.full(SHAPE, distance, np.float32)
    amplitude = np.full(SHAPE, infrared, np.float32)
    return measure(sensor, depth, np.zeros(SHAPE, np.uint16), amplitude, rng).depth


@pytest.mark.parametrize("distance", [1.0, 2.0, 3.0, 4.0])
def test_noise_is_as_stated_and_grows_with_distance(distance: float) -> None:
    near = wall(distance, Sensor())[80:130, 100:156]
    spread = float(near[near > 0].std())
    assert 0.6 < spread / float(deviation(np.float32(distance))) < 2.0
    farther = wall(distance + 0.8, Sensor())[80:130, 100:156]
    assert float(farther[farther > 0].std()) > spread


def test_noise_at_one_metre_is_one_to_two_millimetres() -> None:
    near = wall(1.0, Sensor())[80:130, 100:156]
    assert 0.0007 < float(near[near > 0].std()) < 0.002


def test_no_noise_is_exact_to_the_millimetre() -> None:
    assert (wall(1.2346, Sensor(noise=0)) == np.float32(1.235)).all()


@pytest.mark.parametrize(("distance", "infrared"), [(0.4, 0.6), (6.5, 0.6), (2.0, 0.0)])
def test_out_of_range_and_black_to_infrared_is_missing(distance: float, infrared: float) -> None:
    assert (wall(distance, Sensor(), infrared) == 0).mean() > 0.99


def test_dark_surfaces_lose_more_pixels() -> None:
    assert (wall(4.0, Sensor(), 0.04) == 0).mean() > 5 * (wall(4.0, Sensor(), 0.6) == 0).mean()


def test_flying_pixels_hang_between_the_surfaces_and_are_nobodys() -> None:
    depth = np.full(SHAPE, 3.0, np.float32)
    depth[:, 100:150] = 2.0
    label = np.where(depth == 2.0, 7, 9).astype(np.uint16)
    amplitude = np.full(SHAPE, 0.6, np.float32)
    scan = measure(Sensor(), depth, label, amplitude, np.random.default_rng(3))
    between = (scan.depth > 2.1) & (scan.depth < 2.9)
    assert 20 < between.sum() < 2 * 4 * SHAPE[0]
    assert (scan.label[between] == 0).all()
    columns = np.nonzero(between)[1]
    assert (np.minimum(np.abs(columns - 99.5), np.abs(columns - 149.5)) < 3).all()
    reach = FLYING_TOLERANCE + 6 * 0.004
    assert (np.abs(scan.depth[scan.label == 7] - 2.0) < reach)[
        scan.depth[scan.label == 7] > 0
    ].all()


def test_noise_of_the_picture_is_set_with_the_depths() -> None:
    clean = generate("tabletop", frames=1, noise=0).frame(0)
    noisy = generate("tabletop", frames=1).frame(0)
    assert len(clean) > len(noisy)
