"""Options of the tracker: values are checked, and say what was expected."""

from __future__ import annotations

import pytest

from pointbrush.errors import BadInputError
from pointbrush.tracking.options import CompanionOptions, JumpOptions, TrackerOptions


def test_the_tree_is_made_of_its_defaults() -> None:
    assert TrackerOptions() == TrackerOptions(CompanionOptions(), JumpOptions())


def test_a_value_out_of_its_bounds_is_named() -> None:
    with pytest.raises(BadInputError, match=r"JumpOptions\.stays_share: expected 0 to 1, got 1\.5"):
        JumpOptions(stays_share=1.5)
    with pytest.raises(BadInputError, match=r"CompanionOptions\.most: expected 0 to inf, got -1"):
        CompanionOptions(most=-1)
    with pytest.raises(BadInputError, match=r"side_pixels: expected 16 to 512, got '64'"):
        JumpOptions(side_pixels="64")  # type: ignore[arg-type]
