"""Compiling the loops of this machine in a separate process of a server."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from concurrent.futures import wait

from pointbrush.jobs.worker import end_processes, local_processes
from pointbrush.work.events import Compiling
from pointbrush.work.loops.compiling import (
    DONE,
    LOOK_SECONDS,
    STEPS,
    Progress,
    StepName,
    are_compiled,
    progress_of,
)
from pointbrush.work.prepare import ensure_compiled

logger = logging.getLogger(__name__)


class Loops:
    """Compiles the loops and publishes the progress of each step; thread-safe."""

    def __init__(self, publish: Callable[[Compiling], None]) -> None:
        self._publish = publish
        self._lock = threading.Lock()
        self._missing: dict[StepName, Progress] = {}
        self._ready: set[StepName] = set()
        self._thread: threading.Thread | None = None
        self._closed = threading.Event()

    def begin(self) -> None:
        """Start to compile, unless it was started or is done."""
        with self._lock:
            if self._thread is not None or are_compiled():
                return
            self._missing = {step: Progress(0.0) for step in STEPS if not are_compiled([step])}
            self._thread = threading.Thread(target=self._run, name="pointbrush-loops", daemon=True)
            self._thread.start()

    def missing(self) -> dict[StepName, Progress]:
        """Return the steps that are not compiled yet, with their progress."""
        with self._lock:
            return dict(self._missing)

    def ensure(self, step: StepName) -> None:
        """Wait until the loops of a step are compiled; compile them if no other process does."""
        if step in self._ready:  # called for each click, and reading the disk is slow
            return
        while step in self.missing():
            time.sleep(LOOK_SECONDS)
        ensure_compiled([step])
        self._ready.add(step)

    def close(self) -> None:
        """End the process and the thread; compiled loops are kept."""
        self._closed.set()
        if self._thread is not None:
            self._thread.join()

    def _run(self) -> None:
        try:
            self._compile_all()
        except Exception as error:
            logger.warning("loops are compiled when they are first run: %s", error)
        finally:
            for step in self.missing():
                self._set_progress(step, DONE)

    def _compile_all(self) -> None:
        pool = local_processes(1)
        try:
            work = pool.submit(ensure_compiled, STEPS)
            while not wait([work], LOOK_SECONDS).done:
                if self._closed.is_set():
                    end_processes(pool)
                    return
                self._publish_progress()
            work.result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)

    def _publish_progress(self) -> None:
        """Publish steps that advanced by a hundredth or are done."""
        for step, before in self.missing().items():
            now = progress_of(step)
            if now.share >= 1 or int(100 * now.share) != int(100 * before.share):
                self._set_progress(step, now)

    def _set_progress(self, step: StepName, progress: Progress) -> None:
        with self._lock:
            self._missing[step] = progress
            if progress.share >= 1:
                del self._missing[step]
        self._publish(Compiling(step, progress))
