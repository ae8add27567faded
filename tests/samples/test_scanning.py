"""Rooms and homes from many views: what their scans hold, and what fusing does to them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pointbrush.errors import BadInputError
from pointbrush_samples.interior import HOME, Interior
from pointbrush_samples.scanning import FUSED, Labelled, home_scan

SMALL = replace(FUSED, points=30_000, views=6)


@pytest.fixture(scope="module")
def home() -> Labelled:
    return home_scan(3, SMALL)


def test_a_home_holds_many_things_and_each_has_its_instance(home: Labelled) -> None:
    assert len(home.frame.xyz) == len(home.instance) <= SMALL.points
    numbers = np.unique(home.instance[home.instance > 0])
    assert len(numbers) > 15
    assert set(numbers) <= {s.label for s in Interior(3, HOME).solids}


def test_the_same_seed_gives_the_same_home(home: Labelled) -> None:
    again = home_scan(3, SMALL)
    assert (again.frame.xyz == home.frame.xyz).all()
    assert (again.instance == home.instance).all()


def roughness(made: Labelled) -> float:
    """Median height over or under the plane of a floor's points, metres, away from the walls."""
    room = Interior(3, HOME)
    x, y, z = np.asarray(made.frame.xyz, float).T
    inside = (np.abs(x) < room.width / 2 - 0.3) & (np.abs(z) < room.depth / 2 - 0.3)
    floor = np.abs(y[(made.instance == 0) & inside & (np.abs(y) < 0.05)])
    assert len(floor) > 2000
    return float(np.median(floor))


def test_a_fused_surface_is_smoother_than_its_points() -> None:
    """The floor of views placed without an error: 0.4 of the roughness, 0.32 to 0.41 of seeds."""
    exact = replace(SMALL, drift=0.0, turn=0.0, bumps=0.0)
    assert roughness(home_scan(3, exact)) < 0.6 * roughness(home_scan(3, replace(exact, fused=0)))


@pytest.mark.parametrize("wrong", [{"views": 0}, {"drift": -1.0}, {"bump_width": 0.0}])
def test_bad_options_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(BadInputError, match="expected"):
        home_scan(3, replace(SMALL, **wrong))  # type: ignore[arg-type]
