"""Tracking runs as jobs, with provisional results and a commit as one edit."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pointbrush.database.guards import TRACKING, Guard
from pointbrush.database.job import Job
from pointbrush.jobs.job import MESSAGE
from pointbrush.jobs.runner import Receiver
from pointbrush.labels import Commit
from pointbrush.tracking import FrameResult
from pointbrush.values.runs import TrackingOptions, TrackingRequest
from pointbrush.work.events import Provisional, Retracted
from pointbrush.work.job_request import JobRequest
from pointbrush.work.job_service import EditService, JobContext, Submission
from pointbrush.work.tracking import TRACK
from pointbrush.work.tracking import job as tracking
from pointbrush.work.tracking.job import doubtful

if TYPE_CHECKING:
    from typing import Self

BESIDE = ("method", "stop_unsure")
"""Options that records of earlier versions have at their top level."""
MOST_NAMED = 4
"""Limit of labels listed in a message; further labels are only counted."""


@dataclass(frozen=True)
class TrackRequest(JobRequest):
    """Request to track ``labels`` (None: all in ``start``), forward or backward to ``stop``."""

    call = TRACK
    start: int
    stop: int
    labels: tuple[int, ...] | None
    options: TrackingOptions

    @classmethod
    def of_json(cls, kept: Mapping[str, Any]) -> Self:
        """Return the request of a record, also of one with two options beside the others."""
        beside = {name: kept[name] for name in BESIDE if name in kept}
        return super().of_json({**kept, "options": kept["options"] | beside})


class Runs(EditService[TrackRequest]):
    """Starts tracking runs and commits their results; thread-safe."""

    kind = "tracking"
    request = TrackRequest

    def __init__(self, context: JobContext) -> None:
        super().__init__(context)
        self._kept: set[str] = set()

    def expect(self) -> None:
        """Prepare a worker process for a run, unless one is already running."""
        self._context.runner.make_ready(tracking.load_default_method)

    def keep(self, job_id: str) -> None:
        """Mark a run so that its results are committed even if it is cancelled."""
        self._kept.add(job_id)

    def start(self, sequence: str, body: TrackingRequest, author: str) -> Job:
        """Track labels in a job, or return the job that ``author`` started by this id."""
        request = TrackRequest(body.start, body.stop, body.labels, TrackingOptions.of(body))
        return self.begin(sequence, request, author, body.id)

    def _committed(self, made: Commit) -> dict[str, Any]:
        return super()._committed(made) | {"frames": len(made.frames)}

    def _prepare(self, request: TrackRequest, job: Job) -> Submission:
        recording = self._recording(job.sequence or "")
        self._store.require_writable()
        sequence = recording.manifest.id
        tracking.require_method(request.options.method)
        chosen = None if request.labels is None else list(request.labels)
        seeds = tracking.prepare(self._store, recording, chosen, request.start, request.stop)
        palette = self._store.palette(sequence)
        work = tracking.TrackingWork(
            recording.files,
            self._context.database,
            request.start,
            request.stop,
            seeds,
            request.options,
            frozenset(label.id for label in palette if label.locked),
        )
        pending = tracking.PendingEdit(
            self._store,
            sequence,
            recording.identity,
            request.start,
            tuple(seed.label for seed in seeds),
            request.options.overwrite,
        )
        names = {label.id: label.name for label in palette}
        guard = self._store.guards.begin(sequence, TRACKING)
        return job, work, _Run(request, pending, names, guard, self._kept, self._context)


@dataclass(frozen=True)
class _Run(Receiver):
    """Publishes the provisional labels of a run, and commits them at its end."""

    request: TrackRequest
    pending: tracking.PendingEdit
    names: Mapping[int, str]
    guard: Guard
    kept: set[str]
    context: JobContext

    def receive(self, job: Job, item: FrameResult) -> None:
        self.pending.results.append(item)
        numbers, values = tracking.flat(item)
        sequence = self.pending.sequence
        self.context.publish(Provisional(sequence, item.frame, job.id, numbers, values, item))

    def restart(self, job: Job) -> None:
        frames = tuple(found.frame for found in self.pending.results)
        self.pending.results.clear()
        self.context.publish(Retracted(self.pending.sequence, job.id, frames))

    def finish(self, job: Job, cancelled: bool) -> dict[str, Any]:
        if cancelled and job.id not in self.kept:
            return tracking.NOTHING | {MESSAGE: "no label was changed"}
        pending, request = self.pending, self.request
        count = len(pending.labels)
        labelled = "1 label" if count == 1 else f"{count} labels"
        frames = f"frames {request.start} to {request.stop}"
        summary = f"tracked {labelled}, {frames}, {request.options.method}"
        outcome = run_summary(pending.results, request.start, self.names)
        result = pending.commit(job.edit or job.id, job.owner or "", summary)
        return _report(result, self.names, outcome)

    def end(self, job: Job) -> None:
        self.kept.discard(job.id)
        self.context.store.guards.end(self.guard)
        self.restart(job)


def _report(result: dict[str, Any], names: Mapping[int, str], outcome: str) -> dict[str, Any]:
    """Return a run's result with ``outcome``, and with names and reasons of left-out labels."""
    left_out: Mapping[int, str] = result["left_out"]
    if not left_out:
        return result | {"left_out": [], MESSAGE: outcome}
    reasons = [f"'{names.get(number, number)}' was {why}" for number, why in left_out.items()]
    found = [
        {"label": number, "name": names.get(number, ""), "why": why}
        for number, why in left_out.items()
    ]
    message = f"left out, changed during tracking: {', '.join(reasons)}"
    return result | {"left_out": found, MESSAGE: message}


def run_summary(results: Iterable[FrameResult], start: int, names: Mapping[int, str]) -> str:
    """Return a summary of the numbers of found and doubtful frames by label.

    Example: "pin 1: 29 frames, 7 doubtful; pin 2: 29 frames".  The painted frame ``start`` is
    excluded.
    """
    found: dict[int, int] = {}
    doubts: dict[int, int] = {}
    for result in results:
        if result.frame == start:
            continue
        for label, track in result.tracks.items():
            found[label] = found.get(label, 0) + (track.points > 0)
            doubts[label] = doubts.get(label, 0) + doubtful(track)
    summaries = [
        _label_summary(names.get(label, str(label)), found[label], doubts[label]) for label in found
    ]
    if len(summaries) > MOST_NAMED:
        rest = list(found)[MOST_NAMED:]
        more = f"{len(rest)} more labels, {sum(doubts[label] for label in rest)} frames doubtful"
        summaries[MOST_NAMED:] = [more]
    return "; ".join(summaries)


def _label_summary(name: str, frames: int, doubtful_frames: int) -> str:
    summary = f"{name}: {frames} {'frame' if frames == 1 else 'frames'}"
    return f"{summary}, {doubtful_frames} doubtful" if doubtful_frames else summary
