"""What is compiled, and when."""

from __future__ import annotations

import subprocess
import sys

from pointbrush.compiled import compiled
from pointbrush.work.loops.compiling import STEPS
from pointbrush.work.loops.steps import RUNS

AFTER_PREPARING = """
import gc
from numba.core.dispatcher import Dispatcher
from pointbrush.samples.generating import generate, small_camera
from pointbrush.work.loops import steps
from pointbrush.work.loops.steps import RUNS, select_object, track

def small(*arguments, **options):
    made = generate(*arguments, **options)
    made.camera = small_camera(made.camera, 2)
    return made

def compiled_for():
    loops = [one for one in gc.get_objects() if isinstance(one, Dispatcher)]
    return {(one.py_func.__qualname__, args) for one in loops for args in one.overloads}

steps.generate = small  # the loops of a quarter of the points are the same
for step in RUNS.values():
    step.run()
before = compiled_for()
track(small("tabletop", 2, 3), "auto")
select_object()
for moved in (0.0, 0.02):
    track(small("walking", 2, 3), "auto", moved, leaves=2)
for loop, args in sorted(compiled_for() - before, key=str):
    print(loop, args)
"""


def test_after_preparing_no_run_waits_for_a_loop_to_be_compiled() -> None:
    # By what each loop was compiled or loaded for, since other tests compile and keep theirs.
    told = subprocess.run(
        [sys.executable, "-c", AFTER_PREPARING], capture_output=True, text=True, check=True
    )
    assert told.stdout == ""


def test_each_step_has_its_work() -> None:
    assert tuple(RUNS) == STEPS


def test_where_nothing_can_be_kept_loops_are_compiled_all_the_same() -> None:
    space: dict[str, object] = {"compiled": compiled, "__name__": "nowhere"}
    exec("@compiled\ndef twice(x):\n    return 2 * x\n", space)
    assert space["twice"](21) == 42  # type: ignore[operator]
