"""What is compiled, and when."""

from __future__ import annotations

from numba.core import event

from pointbrush.compiled import compiled
from pointbrush.samples import generate
from pointbrush.work.prepare import STEPS, select_object, track


def test_after_preparing_no_run_waits_for_a_loop_to_be_compiled() -> None:
    for _, step in STEPS:
        step()
    with event.install_recorder("numba:compile") as compiled_now:
        track(generate("tabletop", 2, 3), "auto")
        select_object()
        for moved in (0.0, 0.02):
            track(generate("walking", 2, 3), "auto", moved, leaves=2)
    assert compiled_now.buffer == []


def test_where_nothing_can_be_kept_loops_are_compiled_all_the_same() -> None:
    space: dict[str, object] = {"compiled": compiled, "__name__": "nowhere"}
    exec("@compiled\ndef twice(x):\n    return 2 * x\n", space)
    assert space["twice"](21) == 42  # type: ignore[operator]
