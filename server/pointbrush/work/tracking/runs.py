"""Tracking runs as jobs: what they find is shown as it comes, and becomes one edit at the end."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from pointbrush.errors import BadInputError
from pointbrush.jobs import MESSAGE, Job, JobRunner
from pointbrush.labels import LabelStore
from pointbrush.labels.guards import TRACKING
from pointbrush.sequences import Sequence as Recording
from pointbrush.tracking import FrameResult, TrackOptions
from pointbrush.work.events import Event, Provisional, Retracted
from pointbrush.work.tracking import job as tracking
from pointbrush.work.tracking import told


@dataclass(frozen=True)
class TrackRequest:
    """Carry ``labels``, all in frame ``start`` when None, to frame ``stop``; either way.

    ``stop_unsure``: to the first frame that a person should look at.
    """

    start: int
    stop: int
    labels: Sequence[int] | None
    method: str
    options: TrackOptions
    stop_unsure: bool


class Runs:
    """Starts tracking runs and takes in what they find."""

    def __init__(
        self,
        store: LabelStore,
        runner: JobRunner,
        publish: Callable[[Event], None],
        database_url: str,
    ) -> None:
        self._store, self._runner, self._publish = store, runner, publish
        self._database_url = database_url
        self._kept: set[str] = set()

    def keep(self, job_id: str) -> None:
        """The findings of a run are to be committed also when it is cancelled."""
        self._kept.add(job_id)

    def start(self, recording: Recording, request: TrackRequest, author: str, edit: str) -> Job:
        """See ``Workspace.track``; ``edit`` is the id of the run's edit."""
        self._store.require_writable()
        sequence, overwrite = recording.manifest.id, request.options.overwrite
        tracking.require_method(request.method)
        if overwrite not in tracking.OVERWRITE:
            expected = ", ".join(tracking.OVERWRITE)
            raise BadInputError(f"overwrite: expected one of {expected}, got {overwrite!r}")
        start, stop = request.start, request.stop
        chosen = None if request.labels is None else list(request.labels)
        seeds = tracking.prepare(self._store, recording, chosen, start, stop)
        locked = frozenset(label.id for label in self._store.palette(sequence) if label.locked)
        work = tracking.TrackingWork(
            recording.path,
            self._database_url,
            start,
            stop,
            seeds,
            request.method,
            replace(request.options, locked=locked),
            request.stop_unsure,
        )
        ids = tuple(seed.label for seed in seeds)
        names = {label.id: label.name for label in self._store.palette(sequence)}
        pending = tracking.PendingEdit(
            self._store, sequence, recording.identity, start, ids, overwrite
        )
        guard = self._store.guards.begin(sequence, TRACKING)

        def on_item(job: Job, found: FrameResult) -> None:
            pending.results.append(found)
            numbers, values = tracking.flat(found)
            self._publish(Provisional(sequence, found.frame, job.id, numbers, values, found))

        def finish(job: Job, cancelled: bool) -> dict[str, Any]:
            if cancelled and job.id not in self._kept:
                return tracking.NOTHING | {MESSAGE: "no label was changed"}
            labelled = "1 label" if len(ids) == 1 else f"{len(ids)} labels"
            summary = f"tracked {labelled}, frames {start} to {stop}, {request.method}"
            outcome = told.counted(pending.results, start, names)
            return _told(pending.commit(edit, author, summary), names, outcome)

        def done(job: Job) -> None:
            self._kept.discard(job.id)
            self._store.guards.end(guard)
            frames = tuple(found.frame for found in pending.results)
            self._publish(Retracted(sequence, job.id, frames))

        def restart(job: Job) -> None:
            frames = tuple(found.frame for found in pending.results)
            pending.results.clear()
            self._publish(Retracted(sequence, job.id, frames))

        try:
            return self._runner.submit(
                "tracking", sequence, work, finish, on_item, done, restart, owner=author, edit=edit
            )
        except BaseException:
            self._store.guards.end(guard)
            raise


def _told(result: dict[str, Any], names: Mapping[int, str], outcome: str) -> dict[str, Any]:
    """A run's result with ``outcome``, in which labels that it left out have names and reasons."""
    left_out: Mapping[int, str] = result["left_out"]
    if not left_out:
        return result | {"left_out": [], MESSAGE: outcome}
    said = [f"'{names.get(number, number)}' was {why}" for number, why in left_out.items()]
    found = [
        {"label": number, "name": names.get(number, ""), "why": why}
        for number, why in left_out.items()
    ]
    message = f"left out, changed while it was tracked: {', '.join(said)}"
    return result | {"left_out": found, MESSAGE: message}
