"""Compile the loops of import, tracking and object selection once per machine.

python -m pointbrush.work.prepare
"""

from __future__ import annotations

import time
from collections.abc import Iterable

from pointbrush.work.loops.compiling import (
    DONE,
    LOOK_SECONDS,
    STEPS,
    Progress,
    Report,
    StepName,
    are_compiled,
    hold,
    progress_of,
)


def ensure_compiled(steps: Iterable[StepName], report: Report = lambda _: None) -> None:
    """Wait until the loops of some steps are compiled, in order, by this process or another.

    Raises the errors of ``report``; another process can then continue.
    """
    for step in steps:
        while not are_compiled([step]):
            if not _compile(step, report):
                report(progress_of(step))
                time.sleep(LOOK_SECONDS)


def _compile(step: StepName, report: Report) -> bool:
    """Compile the loops of a step; return False if another process compiles it."""
    with hold(step) as note:
        if note is None:
            return False
        if not are_compiled([step]):
            from pointbrush.work.loops.steps import run_step  # imports all modules with loops

            def on_progress(progress: Progress) -> None:
                note(progress)
                report(progress)

            run_step(step, on_progress)
            note(DONE)
    return True


if __name__ == "__main__":
    ensure_compiled(STEPS)
