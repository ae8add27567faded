"""A tracking run: seeds from the label store, a method in a worker, results as one edit."""

from __future__ import annotations

import os
from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, LockedLabelError, NotFoundError
from pointbrush.jobs.worker import Channel
from pointbrush.labels import LabelStore, Write
from pointbrush.labels.types import TRACKED, Only
from pointbrush.sequences import Sequence, open_sequence
from pointbrush.sequences.storage.stored_files import RecordingFiles
from pointbrush.tracking import (
    METHODS,
    FrameKnowledge,
    FrameResult,
    Seed,
    TrackOptions,
    TrackState,
)
from pointbrush.tracking.permissions import FEWEST
from pointbrush.values.runs import TrackingOptions
from pointbrush.work.job_service import edit_result
from pointbrush.work.loops.compiling import Progress, StepName
from pointbrush.work.prepare import ensure_compiled
from pointbrush.work.tracking.sensor import sensor_of

LOOPS: tuple[StepName, ...] = ("things",)
"""Steps of compiling that a run waits for; the few other loops are compiled at first use."""
LEAD = 20
"""Limit of frames before a run's start that a method may use as examples."""
UNSURE = 0.5
"""Confidence below which a frame needs a review."""
NOTHING = {"edit": None, "changed": 0, "frames": 0}
"""Report of a run without results, or with discarded results."""
OVERWRITE: dict[str, Only] = {"never": "unlabeled", "tracked": "not_painted", "all": "any"}


@dataclass(frozen=True)
class TrackingWork:
    """Picklable run that sends each FrameResult as an item."""

    files: RecordingFiles
    database: str = field(repr=False)  # may hold a password
    start: int
    stop: int
    seeds: tuple[Seed, ...]
    chosen: TrackingOptions
    locked: frozenset[int]

    def __call__(self, channel: Channel) -> None:
        """Track frame by frame from ``start`` to ``stop``, in either direction."""
        chosen = self.chosen
        if chosen.method == "auto":  # other methods have few loops
            ensure_compiled(LOOPS, lambda now: channel.progress(0.0, preparation(now)))
        recording = open_sequence(self.files)
        store = LabelStore(self.database)
        try:
            order = frame_order(self.start, self.stop)
            counts = store.counts(recording.manifest.id)
            before = lead(counts, [s.label for s in self.seeds], order, len(recording))
            painted = frozenset(frame for (frame, _), (_, by_hand) in counts.items() if by_hand)
            ahead = (os.cpu_count() or 1) > 1
            known = {each.name for each in fields(TrackOptions)}
            options = TrackOptions(
                locked=self.locked,
                before=before,
                painted=painted,
                read_ahead=ahead,
                fps=recording.manifest.fps,
                **{name: value for name, value in asdict(chosen).items() if name in known},
            )
            if chosen.method == "auto":  # other methods do not use the sensor
                options = replace(options, sensor=sensor_of(recording))
            results = METHODS[chosen.method]().track(
                recording.__getitem__,
                order,
                self.seeds,
                Knowledge(store, recording),
                options,
            )
            for done, found in enumerate(results, start=1):
                channel.item(found)
                channel.progress(min(done / len(order), 1.0), f"frame {found.frame}")
                if chosen.stop_unsure and wants_look(found):
                    channel.progress(1.0, f"frame {found.frame}: doubtful")
                    break
        finally:
            store.close()


@dataclass(frozen=True)
class Knowledge:
    """Existing labels of a frame, in stored order."""

    store: LabelStore
    recording: Sequence

    def __call__(self, frame: int) -> FrameKnowledge:
        """Read the knowledge of a frame."""
        values = self.store.values(self.recording.manifest.id, frame)
        return FrameKnowledge(values.label, values.provenance, values.deleted)


def wants_look(found: FrameResult) -> bool:
    """Return whether a label of a frame is lost, or found with low confidence."""
    return any(map(doubtful, found.tracks.values()))


def doubtful(track: TrackState) -> bool:
    """Return whether a label is lost in a frame, or found with low confidence."""
    if track.state == "lost":
        return True
    return track.state == "tracked" and track.points > 0 and track.confidence < UNSURE


def frame_order(start: int, stop: int) -> list[int]:
    """Return frames from ``start`` to ``stop``, both included, forward or backward."""
    return list(range(start, stop + 1) if stop >= start else range(start, stop - 1, -1))


def lead(
    counts: Mapping[tuple[int, int], tuple[int, int]],
    labels: list[int],
    order: list[int],
    frames: int,
) -> tuple[int, ...]:
    """Return frames before a run's start with examples of its ``labels``, farthest first.

    They are consecutive labelled frames back to one in which all labels are painted, at most LEAD.
    ``counts``: number of points and of painted points by (frame, label).
    """
    step = -1 if order[-1] > order[0] else 1
    found: list[int] = []
    for number in range(order[0] + step, order[0] + step * (LEAD + 1), step):
        point_counts = [counts.get((number, label), (0, 0)) for label in labels]
        if not 0 <= number < frames or max(point_counts)[0] < FEWEST:
            break
        found.append(number)
        if min(painted for _, painted in point_counts) >= FEWEST:
            break
    return tuple(reversed(found))


def prepare(
    store: LabelStore, recording: Sequence, labels: list[int] | None, start: int, stop: int
) -> tuple[Seed, ...]:
    """Return the points of each label in the start frame; None: all unlocked labels there.

    Raises NotFoundError (frame, label), LockedLabelError, BadInputError (no points, no range).
    """
    for name, frame in (("start", start), ("stop", stop)):
        if not 0 <= frame < len(recording):
            raise NotFoundError(f"{name}: expected a frame 0 to {len(recording) - 1}, got {frame}")
    if start == stop:
        raise BadInputError(f"stop: expected another frame than start ({start})")
    sequence = recording.manifest.id
    values = store.values(sequence, start)
    alive = np.where(values.deleted, 0, values.label)
    palette = {label.id: label for label in store.palette(sequence)}
    present = [number for number in np.unique(alive).tolist() if number]
    chosen = labels if labels is not None else [n for n in present if not palette[n].locked]
    if not chosen:
        raise BadInputError(f"labels: expected labelled points in frame {start}, there are none")
    for number in chosen:
        if number not in palette:
            raise NotFoundError(f"labels: expected a label of the palette, got {number}")
        if palette[number].locked:
            raise LockedLabelError(f"labels: '{palette[number].name}' ({number}) is locked")
        if number not in present:
            raise BadInputError(
                f"labels: expected points of '{palette[number].name}' ({number}) in frame "
                f"{start}, there are none"
            )
    return tuple(Seed(number, np.flatnonzero(alive == number)) for number in chosen)


def require_method(method: str) -> None:
    """Raise BadInputError unless ``method`` is a known tracking method."""
    if method not in METHODS:
        raise BadInputError(f"method: expected one of {', '.join(METHODS)}, got {method!r}")


def load_default_method() -> None:
    """Import the modules of a run in advance, to speed up a worker's first run."""
    METHODS["auto"]()


def preparation(progress: Progress) -> str:
    """Return the message of a run that waits for loops."""
    left = "" if progress.seconds is None else f": {max(1, round(progress.seconds))} s remain"
    return f"preparing, once on this machine{left}"


@dataclass
class PendingEdit:
    """Results of a run in the server's process, before their commit as one edit."""

    store: LabelStore
    sequence: str
    identity: str
    """Identity of the import, so that a later recording with the same id is not changed."""
    start: int
    labels: tuple[int, ...]
    overwrite: str
    results: list[FrameResult] = field(default_factory=list)

    def commit(self, edit: str, author: str, summary: str) -> dict[str, Any]:
        """Commit the results as one edit, merged with people's edits during the run.

        Labels deleted or locked since the start of the run are left out; the result's ``left_out``
        has the reason by label, "deleted" or "locked".
        """
        left_out = self._left_out()
        while True:
            try:
                return self._commit(edit, author, summary, left_out) | {"left_out": left_out}
            except (NotFoundError, LockedLabelError):
                # The palette may have changed between the check and the commit.
                before, left_out = left_out, self._left_out()
                if left_out == before:
                    raise

    def _left_out(self) -> dict[int, str]:
        self.store.require_import(self.sequence, self.identity)
        palette = {label.id: label for label in self.store.palette(self.sequence)}
        found = {number: palette.get(number) for number in self.labels}
        return {
            number: "deleted" if label is None else "locked"
            for number, label in found.items()
            if label is None or label.locked
        }

    def _commit(
        self, edit: str, author: str, summary: str, left_out: Container[int]
    ) -> dict[str, Any]:
        results = [_without(found, left_out) for found in self.results]
        tracks = [track for found in results for track in self._tracks(found)]
        if not tracks:
            return dict(NOTHING)
        commit = self.store.apply(
            self.sequence,
            edit_id=edit,
            author=author,
            kind="tracking",
            writes=dict(self._writes(results, left_out)),
            summary=summary,
            tracks=tracks,
            identity=self.identity,
        )
        return edit_result(commit) | {"frames": len(self.results)}

    def _writes(
        self, results: Iterable[FrameResult], left_out: Container[int]
    ) -> Iterator[tuple[int, Write]]:
        tracked = [label for label in self.labels if label not in left_out]
        for found in results:
            if found.frame == self.start:
                continue
            numbers, label = flat(found)
            # Points that an earlier run labelled and this run did not find lose these labels.
            values = self.store.values(self.sequence, found.frame)
            stale = np.isin(values.label, tracked) & (values.provenance == TRACKED)
            stale[numbers] = False
            gone = np.flatnonzero(stale) if self.overwrite != "never" else np.empty(0, np.int64)
            numbers = np.concatenate([numbers, gone])
            label = np.concatenate([label, np.zeros(len(gone), np.uint16)])
            order = np.argsort(numbers, kind="stable")
            numbers, label = numbers[order], label[order]
            provenance = np.where(label > 0, TRACKED, 0).astype(np.uint8)
            yield (
                found.frame,
                Write(numbers, label=label, provenance=provenance, only=OVERWRITE[self.overwrite]),
            )

    def _tracks(self, found: FrameResult) -> list[dict[str, Any]]:
        return [
            {
                "label": label,
                "frame": found.frame,
                "start": self.start,
                "pose": np.asarray(track.pose, np.float64).ravel().tolist(),
                "rmse": float(track.rmse),
                "inliers": float(track.inliers),
                "confidence": float(track.confidence),
                "points": int(track.points),
                "state": track.state,
            }
            for label, track in found.tracks.items()
        ]


def _without(found: FrameResult, left_out: Container[int]) -> FrameResult:
    """Return a result without some labels."""
    return replace(
        found,
        assignments={n: at for n, at in found.assignments.items() if n not in left_out},
        tracks={n: track for n, track in found.tracks.items() if n not in left_out},
    )


def flat(found: FrameResult) -> tuple[NDArray[np.int64], NDArray[np.uint16]]:
    """Return sorted point numbers and their labels, for all labels of a result."""
    if not found.assignments:
        return np.empty(0, np.int64), np.empty(0, np.uint16)
    numbers = np.concatenate([np.asarray(n, np.int64) for n in found.assignments.values()])
    label = np.repeat(
        np.array(list(found.assignments), np.uint16),
        [len(n) for n in found.assignments.values()],
    )
    order = np.argsort(numbers, kind="stable")
    return numbers[order], label[order]
