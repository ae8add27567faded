"""Explaining how a label is tracked, by a run that writes nothing."""

from __future__ import annotations

import threading
from collections import defaultdict
from dataclasses import dataclass, field, replace

from pointbrush.errors import BadInputError, PointbrushError
from pointbrush.tracking import TrackOptions
from pointbrush.tracking.compute.rigid import IcpStep
from pointbrush.tracking.explanation import Explanation
from pointbrush.tracking.registry import watched
from pointbrush.work.tracking.job import Knowledge, prepare
from pointbrush.work.tracking.sensor import sensor_of
from pointbrush.workspace import Workspace


@dataclass(frozen=True, slots=True)
class ExplainRequest:
    """Label ``label`` from frame ``start``, where it has points, to ``stop``, by ``method``."""

    label: int
    start: int
    stop: int
    method: str = "auto"


@dataclass
class Explaining:
    """A run in a thread, which fills ``frames`` and ``iterations``."""

    workspace: Workspace
    sequence: str
    request: ExplainRequest
    frames: dict[int, Explanation] = field(default_factory=dict)
    iterations: dict[int, list[IcpStep]] = field(default_factory=lambda: defaultdict(list))
    error: str = ""

    def __post_init__(self) -> None:
        """Check the request and start the run; raises NotFoundError, BadInputError."""
        request = self.request
        recording = self.workspace.recording(self.sequence)
        self._seeds = prepare(
            self.workspace.labels, recording, [request.label], request.start, request.stop
        )
        self._method = watched(request.method, self._on_frame, self._on_iteration)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="explain", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the run at its next frame."""
        self._ended.set()
        self._thread.join()

    def wait(self) -> None:
        """Wait until the run has ended."""
        self._thread.join()

    def _run(self) -> None:
        request, recording = self.request, self.workspace.recording(self.sequence)
        step = 1 if request.stop > request.start else -1
        order = range(request.start, request.stop + step, step)
        known = Knowledge(self.workspace.labels, recording)
        options = TrackOptions(continue_lost=True, fps=recording.manifest.fps)
        try:
            if request.method == "auto":  # as in an ordinary run
                options = replace(options, sensor=sensor_of(recording))
            frames = recording.__getitem__
            for _ in self._method.track(frames, order, self._seeds, known, options):
                if self._ended.is_set():
                    return
        except PointbrushError as error:
            self.error = str(error)

    def _on_frame(self, explanation: Explanation) -> None:
        if explanation.label == self.request.label:
            self.frames[explanation.frame] = explanation

    def _on_iteration(self, frame: int, label: int, step: IcpStep) -> None:
        if label == self.request.label:
            if step.iteration == 1:
                self.iterations.pop(frame, None)
            self.iterations[frame].append(step)


def first_frame(workspace: Workspace, sequence: str, label: int) -> int:
    """Return the first frame where a label was painted, else the first where it has points.

    Raises BadInputError if it has none.
    """
    counts = workspace.labels.counts(sequence)
    frames = sorted(frame for frame, number in counts if number == label)
    painted = [frame for frame in frames if counts[frame, label][1]]
    if not frames:
        raise BadInputError(f"label {label}: expected points of it in some frame, there are none")
    return (painted or frames)[0]
