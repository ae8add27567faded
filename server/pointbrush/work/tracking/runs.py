"""Tracking runs as jobs, with provisional results and a commit as one edit."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from pointbrush.database.guards import TRACKING
from pointbrush.jobs.job import MESSAGE, Job
from pointbrush.jobs.runner import JobRunner
from pointbrush.sequences import Sequence as Recording
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.tracking import FrameResult
from pointbrush.work.events import Event, Provisional, Retracted
from pointbrush.work.job_book import JobBook
from pointbrush.work.tracking import TRACK
from pointbrush.work.tracking import job as tracking
from pointbrush.work.tracking.job import doubtful
from pointbrush.work.tracking.options import RunOptions

BESIDE = ("method", "stop_unsure")
"""Options stored at the top level of a job's record."""
MOST_NAMED = 4
"""Limit of labels listed in a message; further labels are only counted."""


@dataclass(frozen=True)
class TrackRequest:
    """Request to track ``labels`` (None: all in ``start``), forward or backward to ``stop``."""

    start: int
    stop: int
    labels: Sequence[int] | None
    options: RunOptions

    def as_json(self) -> dict[str, Any]:
        """Return the record from which ``Runs.again`` can restart a job."""
        kept = asdict(self)
        beside = {name: kept["options"].pop(name) for name in BESIDE}
        return {"call": TRACK} | kept | beside

    @classmethod
    def of_json(cls, fields: Mapping[str, Any]) -> TrackRequest:
        """Return the request for ``fields`` of ``as_json``."""
        options = RunOptions(**fields["options"], **{name: fields[name] for name in BESIDE})
        return cls(fields["start"], fields["stop"], fields["labels"], options)


class Runs:
    """Starts tracking runs and commits their results; thread-safe."""

    def __init__(
        self,
        store: WorkspaceStore,
        recording: Callable[[str], Recording],
        runner: JobRunner,
        jobs: JobBook,
        publish: Callable[[Event], None],
        database_url: str,
    ) -> None:
        """``recording``: opens a recording by its id."""
        self._store, self._recording, self._runner, self._jobs = store, recording, runner, jobs
        self._publish, self._database_url = publish, database_url
        self._kept: set[str] = set()

    def expect(self) -> None:
        """Prepare a worker process for a run, unless one is already running."""
        self._runner.make_ready(tracking.load_default_method)

    def keep(self, job_id: str) -> None:
        """Mark a run so that its results are committed even if it is cancelled."""
        self._kept.add(job_id)

    def start(
        self,
        sequence: str,
        *,
        start: int,
        stop: int,
        author: str,
        labels: Sequence[int] | None = None,
        edit: str | None = None,
        **chosen: Any,
    ) -> Job:
        """Track labels from frame ``start`` to ``stop`` (included; either direction), in a job.

        ``chosen``: fields of ``RunOptions``.  ``edit``: id of the edit and the job; if ``author``
        has already started a job with this id, it is returned.
        """
        request = TrackRequest(start, stop, labels, RunOptions(**chosen))
        recording, kept = self._recording(sequence), request.as_json()

        def begin(job_id: str) -> Job:
            job = Job("tracking", sequence, job_id, owner=author, edit=job_id, request=kept)
            return self._begin(recording, request, job)

        return self._jobs.begin_once(edit, author, begin)

    def again(self, job: Job) -> dict[str, Any] | None:
        """Restart a run of an ended server; return its result if it was already committed.

        Raises the errors of ``start``.
        """
        recording = self._recording(job.sequence or "")
        made = self._store.find(recording.manifest.id, job.edit or job.id)
        if made is not None:
            return {"edit": made.edit_id, "changed": made.changed, "revision": made.revision}
        self._begin(recording, TrackRequest.of_json(job.request or {}), job)
        return None

    def _begin(self, recording: Recording, request: TrackRequest, job: Job) -> Job:
        author, edit = job.owner or "", job.edit or job.id
        self._store.require_writable()
        sequence, overwrite = recording.manifest.id, request.options.overwrite
        tracking.require_method(request.options.method)
        start, stop = request.start, request.stop
        chosen = None if request.labels is None else list(request.labels)
        seeds = tracking.prepare(self._store, recording, chosen, start, stop)
        locked = frozenset(label.id for label in self._store.palette(sequence) if label.locked)
        work = tracking.TrackingWork(
            recording.files,
            self._database_url,
            start,
            stop,
            seeds,
            request.options,
            locked,
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
            summary = f"tracked {labelled}, frames {start} to {stop}, {request.options.method}"
            outcome = counted(pending.results, start, names)
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
            return self._runner.submit(job, work, finish, on_item, done, restart)
        except BaseException:
            self._store.guards.end(guard)
            raise


def _told(result: dict[str, Any], names: Mapping[int, str], outcome: str) -> dict[str, Any]:
    """Return a run's result with ``outcome``, and with names and reasons of left-out labels."""
    left_out: Mapping[int, str] = result["left_out"]
    if not left_out:
        return result | {"left_out": [], MESSAGE: outcome}
    said = [f"'{names.get(number, number)}' was {why}" for number, why in left_out.items()]
    found = [
        {"label": number, "name": names.get(number, ""), "why": why}
        for number, why in left_out.items()
    ]
    message = f"left out, changed during tracking: {', '.join(said)}"
    return result | {"left_out": found, MESSAGE: message}


def counted(results: Iterable[FrameResult], start: int, names: Mapping[int, str]) -> str:
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
    said = [_one(names.get(label, str(label)), found[label], doubts[label]) for label in found]
    if len(said) > MOST_NAMED:
        rest = list(found)[MOST_NAMED:]
        more = f"{len(rest)} more labels, {sum(doubts[label] for label in rest)} frames doubtful"
        said[MOST_NAMED:] = [more]
    return "; ".join(said)


def _one(name: str, frames: int, doubtful_frames: int) -> str:
    told = f"{name}: {frames} {'frame' if frames == 1 else 'frames'}"
    return f"{told}, {doubtful_frames} doubtful" if doubtful_frames else told
