"""The benchmark takes ideas out of `auto` by options: each is a value that `auto` accepts."""

from __future__ import annotations

import pytest

from benchmarks.tracking_ablation import IDEAS, without
from pointbrush.tracking.options import TrackerOptions


@pytest.mark.parametrize("idea", IDEAS)
def test_every_idea_that_the_benchmark_leaves_out_changes_the_options(idea: str) -> None:
    assert without(idea) != TrackerOptions()
