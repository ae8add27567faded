"""Jobs that fit boxes to labels: observations from a recording, results as one edit."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pointbrush.database.job import Job
from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.fitting import (
    FitOptions,
    FittedBox,
    Observation,
    SizePrior,
    fit_box,
    priors_of,
)
from pointbrush.geometry.oriented_box import BoxPose, OrientedBox
from pointbrush.jobs.job import MESSAGE
from pointbrush.jobs.runner import Receiver
from pointbrush.jobs.worker import Channel
from pointbrush.labels import Commit, Label, LabelStore
from pointbrush.labels.boxes.editing import BoxEdit
from pointbrush.sequences import open_sequence
from pointbrush.sequences.storage.stored_files import RecordingFiles
from pointbrush.values.boxes import BoxFit
from pointbrush.work.boxes import FIT
from pointbrush.work.boxes.observing import observed
from pointbrush.work.exporting import parse_frames
from pointbrush.work.job_request import JobRequest
from pointbrush.work.job_service import EditService, Submission

READING = 0.7
"""Approximate share of a job's time for reading frames."""
SPREAD = 0.1
"""Spread of a class's size, as a share of the size, if the taxonomy has none."""
DRAWN_SPREAD = 0.001
"""Spread of a size drawn by a person, metres."""


Size = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Target:
    """A label to fit a box to.

    ``drawn``: size drawn by a person, which is kept.  ``size`` and ``spread``: of its class in the
    taxonomy.
    """

    label: int
    name: str
    category: str
    drawn: Size | None = None
    size: Size | None = None
    spread: Size | None = None

    @property
    def priors(self) -> list[SizePrior]:
        """Return the priors of its size."""
        found = priors_of(self.category, names=(self.name,))
        mean = self.drawn or self.size
        if mean is None:
            return found
        length, width, height = (SPREAD * side for side in mean)
        spread = self.spread or (length, width, height)
        if self.drawn is not None:
            spread = (DRAWN_SPREAD,) * 3
        return [replace(found[0], mean=mean, spread=spread, weight=1.0)]


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """A label's fit, or the reason ``why`` there is none."""

    label: int
    box: FittedBox | None = None
    why: str = ""


@dataclass(frozen=True)
class FittingWork:
    """Picklable work that sends each label's ``Fitted`` as an item."""

    files: RecordingFiles
    database: str = field(repr=False)  # may hold a password
    targets: tuple[Target, ...]
    frames: tuple[int, ...]
    options: FitOptions

    def __call__(self, channel: Channel) -> None:
        """Read the frames, then fit label by label."""
        recording, store = open_sequence(self.files), LabelStore(self.database)
        try:
            seen: dict[int, list[Observation]] = {each.label: [] for each in self.targets}
            frames = observed(store, recording, list(seen), self.frames, self.options)
            for number, (frame, found) in enumerate(frames, 1):
                for label, each in found.items():
                    seen[label].append(each)
                channel.progress(READING * number / len(self.frames), f"frame {frame}")
        finally:
            store.close()
        for number, target in enumerate(self.targets, 1):
            channel.item(fit_one(target, seen.pop(target.label), self.options))
            share = READING + (1 - READING) * number / len(self.targets)
            channel.progress(min(share, 1.0), target.name)


def fit_one(target: Target, seen: list[Observation], options: FitOptions) -> Fitted:
    """Fit one label's box."""
    if not seen:
        return Fitted(target.label, why=f"fewer than {options.least_points} points in every frame")
    try:
        return Fitted(target.label, fit_box(seen, target.priors, options))
    except BadInputError as error:
        return Fitted(target.label, why=str(error))


@dataclass(frozen=True)
class FitRequest(JobRequest):
    """Request to fit boxes in ``frames`` to ``labels`` (None: all), optionally of one ``category``.

    ``redraw``: also fit boxes that a person drew.
    """

    call = FIT
    frames: tuple[int, ...]
    labels: tuple[int, ...] | None = None
    category: str | None = None
    redraw: bool = False

    def chosen(self, palette: Mapping[int, Label]) -> list[Label]:
        """Return the chosen labels of a palette; raises NotFoundError (label, category)."""
        for number in self.labels or ():
            if number not in palette:
                raise NotFoundError(f"labels: expected ids of the palette, got {number}")
        found = [
            label
            for label in palette.values()
            if (self.labels is None or label.id in self.labels)
            and (self.category is None or label.category.casefold() == self.category.casefold())
        ]
        if self.category is not None and not found:
            raise NotFoundError(f"category: expected one of the palette, got {self.category!r}")
        return found


class Fitting(EditService[FitRequest]):
    """Starts jobs that fit boxes to labels, and commits their results."""

    kind = "fitting"
    request = FitRequest

    def fit(self, sequence: str, body: BoxFit, author: str) -> Job:
        """Fit boxes in a job, or return the job that ``author`` started by this id.

        Raises NotFoundError (frame, label, category), BadInputError (no frame).
        """
        frames = tuple(parse_frames(body.frames, len(self._recording(sequence))))
        request = FitRequest(frames, body.labels, body.category, body.redraw)
        return self.begin(sequence, request, author, body.id)

    def _prepare(self, request: FitRequest, job: Job) -> Submission:
        recording = self._recording(job.sequence or "")
        self._store.require_writable()
        if not request.frames:
            raise BadInputError("frames: expected at least one, got none")
        sequence = recording.manifest.id
        labels = request.chosen({each.id: each for each in self._store.palette(sequence)})
        sizes = {} if request.redraw else self._drawn_sizes(sequence)
        known = {each.name: (each.size, each.spread) for each in self._store.taxonomy.entries()}
        targets = tuple(
            Target(
                label.id,
                label.name,
                label.category,
                sizes.get(label.id),
                *known.get(label.category, (None, None)),
            )
            for label in labels
            if not label.locked
        )
        work = FittingWork(
            recording.files, self._context.database, targets, request.frames, FitOptions()
        )
        locked = {str(label.id): "locked" for label in labels if label.locked}
        return job, work, _FittedBoxes(self._store, sequence, request, locked)

    def _drawn_sizes(self, sequence: str) -> dict[int, Size]:
        sizes = {}
        for box in self._store.boxes.listing(sequence).boxes:
            if box.provenance == "drawn":
                length, width, height = box.size.tolist()
                sizes[box.label] = (length, width, height)
        return sizes

    def _committed(self, made: Commit) -> dict[str, Any]:
        return {"edit": made.edit, "fitted": list(made.boxes), "skipped": {}}


class _FittedBoxes(Receiver):
    """Commits all boxes as one edit; ``locked`` are the reasons of skipped labels."""

    def __init__(
        self, store: LabelStore, sequence: str, request: FitRequest, locked: dict[str, str]
    ) -> None:
        super().__init__()
        self._store, self._sequence, self._request = store, sequence, request
        self._locked = locked

    def finish(self, job: Job, cancelled: bool) -> dict[str, Any]:
        nothing: dict[str, Any] = {
            "edit": None,
            "fitted": [],
            "skipped": {},
            MESSAGE: "no box was changed",
        }
        if cancelled:
            return nothing
        skipped = self._locked | {
            str(each.label): each.why for each in self.items if each.box is None
        }
        made = {each.label: each.box for each in self.items if each.box is not None}
        if not made:
            return nothing | {"skipped": skipped}

        def choose(now: Mapping[int, OrientedBox]) -> BoxEdit:
            first = _first_boxes(now.values())
            return BoxEdit(
                [merged(first.get(n), n, box, self._request) for n, box in sorted(made.items())]
            )

        many = "1 box" if len(made) == 1 else f"{len(made)} boxes"
        commit = self._store.boxes.apply(
            self._sequence, job.owner or "", choose, summary=f"fitted {many}",
            edit_id=job.edit or job.id, kind="box",
        )  # fmt: skip
        now = _first_boxes(self._store.boxes.listing(self._sequence).boxes)
        fitted = sorted(now[label].id for label in made if label in now)
        return {
            "edit": commit.edit, "fitted": fitted, "skipped": skipped,
            MESSAGE: f"fitted {many}",
        }  # fmt: skip


def _first_boxes(boxes: Iterable[OrientedBox]) -> dict[int, OrientedBox]:
    """Return the oldest box of each label."""
    return {box.label: box for box in sorted(boxes, key=lambda box: -box.id)}


def merged(old: OrientedBox | None, label: int, new: FittedBox, request: FitRequest) -> OrientedBox:
    """Merge a fit into the earlier box of a label.

    Poses in other frames are kept; drawn poses and a drawn size too, unless ``redraw``.  A known
    heading of the earlier box decides the front of the new one, unless the fit has determined it.
    """
    poses = {
        frame: BoxPose(each.centre, each.quaternion, "fitted", each.confidence)
        for frame, each in new.poses.items()
    }
    if old is None:
        return OrientedBox(
            0, label, np.asarray(new.size), poses,
            provenance="fitted", heading_known=new.front_known,
        )  # fmt: skip
    if old.heading_known and not new.front_known and _opposed(old.poses, poses):
        poses = {frame: _turned_round(pose) for frame, pose in poses.items()}
    fitted_anew = set(request.frames)
    for frame, pose in old.poses.items():
        stays = frame not in fitted_anew or (pose.provenance == "drawn" and not request.redraw)
        if stays:
            poses[frame] = pose
        elif frame in poses:
            poses[frame] = replace(poses[frame], attributes=pose.attributes)
    keeps = old.provenance == "drawn" and not request.redraw
    return replace(
        old,
        size=old.size if keeps else np.asarray(new.size),
        poses=poses,
        provenance=old.provenance if keeps else "fitted",
        heading_known=old.heading_known or new.front_known,
    )


def _opposed(old: Mapping[int, BoxPose], new: Mapping[int, BoxPose]) -> bool:
    """Return whether the headings of new poses oppose the old ones in the nearest frames."""
    agreement = 0.0
    for frame, pose in new.items():
        nearest = old[min(old, key=lambda other: abs(other - frame))]
        agreement += float(pose.transform[:3, 0] @ nearest.transform[:3, 0])
    return agreement < 0


def _turned_round(pose: BoxPose) -> BoxPose:
    """Turn a box by 180 degrees about its vertical axis."""
    x, y, z, w = pose.quaternion
    return replace(pose, quaternion=np.array([y, -x, w, -z]))
