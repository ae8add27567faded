"""The benchmark takes ideas out of `auto` by name: each has to be there."""

from __future__ import annotations

import pytest

from benchmarks.tracking_ablation import IDEAS, without


@pytest.mark.parametrize("idea", IDEAS)
def test_every_idea_that_the_benchmark_leaves_out_is_there(idea: str) -> None:
    with without(idea):
        pass
