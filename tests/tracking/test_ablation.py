"""The benchmark takes ideas out of `auto` by name: each has to be there, and to be asked alike."""

from __future__ import annotations

from inspect import Parameter, signature

import pytest

from benchmarks.tracking_ablation import IDEAS, found, without


@pytest.mark.parametrize("idea", IDEAS)
def test_every_idea_that_the_benchmark_leaves_out_is_there(idea: str) -> None:
    home, name, nothing = found(idea)
    whole = vars(home)[name]
    with without(idea):
        assert vars(home)[name] is nothing
    if callable(nothing):
        asked = signature(whole).parameters.values()
        by_name = {p.name: None for p in asked if p.kind is Parameter.KEYWORD_ONLY}
        signature(nothing).bind(*list(asked)[: len(asked) - len(by_name)], **by_name)
