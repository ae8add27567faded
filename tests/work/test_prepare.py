"""What is compiled, and when."""

from __future__ import annotations

import subprocess
import sys

from pointbrush.compiled import compiled

AFTER_PREPARING = """
from numba.core import event
from pointbrush.samples import generate
from pointbrush.work.prepare import STEPS, select_object, track

for _, step in STEPS:
    step()
with event.install_recorder("numba:compile") as compiled_now:
    track(generate("tabletop", 2, 3), "auto")
    select_object()
    for moved in (0.0, 0.02):
        track(generate("walking", 2, 3), "auto", moved, leaves=2)
for _, one in compiled_now.buffer:
    print(one.data["dispatcher"].py_func.__qualname__, one.data["args"])
"""


def test_after_preparing_no_run_waits_for_a_loop_to_be_compiled() -> None:
    # In a process of its own: others have compiled, and go on to, what other tests needed.
    told = subprocess.run(
        [sys.executable, "-c", AFTER_PREPARING], capture_output=True, text=True, check=True
    )
    assert told.stdout == ""


def test_where_nothing_can_be_kept_loops_are_compiled_all_the_same() -> None:
    space: dict[str, object] = {"compiled": compiled, "__name__": "nowhere"}
    exec("@compiled\ndef twice(x):\n    return 2 * x\n", space)
    assert space["twice"](21) == 42  # type: ignore[operator]
