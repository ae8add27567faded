"""Import of labels from files as one edit of a recording, with a report."""

from __future__ import annotations

import uuid
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.formats import Limits
from pointbrush.geometry.oriented_box import OrientedBox
from pointbrush.jobs.job import Job
from pointbrush.jobs.runner import JobRunner
from pointbrush.labels import Commit, Label, LabelStore, Write
from pointbrush.labels.classes.palette import Palette
from pointbrush.labels.types import IMPORTED
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.annotate.layers import KeptAnnotation
from pointbrush.work.imports.choosing import Chosen
from pointbrush.work.imports.label_reading import (
    FoundBoxes,
    FrameLabels,
    LabelRequest,
    ReadLabelsWork,
    Unmatched,
)
from pointbrush.work.imports.naming import Naming, learn_numbers
from pointbrush.work.imports.new_boxes import box_report, new_boxes
from pointbrush.work.imports.requests import drop_upload

TOLD = 100
"""Limit of entries in a report's lists."""


class LabelImports:
    """Starts imports of labels, and commits their results."""

    def __init__(self, store: LabelStore, runner: JobRunner, max_points: int) -> None:
        self._store, self._runner, self._max_points = store, runner, max_points

    def start(self, recording: Recording, request: LabelRequest, author: str, job_id: str) -> Job:
        """Start a job; its result is the report."""
        kept, edit = request.as_json(), str(uuid.uuid4())
        job = Job("import", recording.manifest.id, job_id, owner=author, edit=edit, request=kept)
        return self._begin(recording, request, job)

    def again(self, recording: Recording, job: Job) -> dict[str, Any] | None:
        """Restart an import of an ended server; return its result if it was already committed.

        Raises the errors of ``start``.
        """
        made = self._store.find(recording.manifest.id, job.edit or job.id)
        if made is not None:
            return {"edit": made.edit_id, "changed": made.changed}
        self._begin(recording, LabelRequest.of_json(job.request or {}), job)
        return None

    def _begin(self, recording: Recording, request: LabelRequest, job: Job) -> Job:
        if not request.dry_run:
            self._store.require_writable()
        found: list[FrameLabels] = []
        unmatched: list[str] = []
        warnings: list[str] = []
        called: list[Naming] = []
        objects = [FoundBoxes(())]

        def on_item(
            _: Job, item: Naming | FrameLabels | FoundBoxes | Unmatched | list[str]
        ) -> None:
            match item:
                case list():
                    warnings[:] = item
                case Naming():
                    called[:] = [item]
                case FoundBoxes():
                    objects[:] = [item]
                case Unmatched():
                    unmatched.append(item.file)
                case _:
                    found.append(item)

        def restart(_: Job) -> None:
            found.clear()
            unmatched.clear()
            objects[:] = [FoundBoxes(())]

        limits = Limits(self._max_points, roots=request.roots)
        work = ReadLabelsWork(request, recording.files, limits)

        def finish(_: Job, cancelled: bool) -> dict[str, Any]:
            if cancelled:
                return {}
            locked = _locked(self._store, recording, found)
            chosen, made, commit = self._write(
                recording, request, job, found, objects[0], called[0]
            )
            report = _report(recording, found, unmatched, chosen)
            report |= box_report(objects[0], made, chosen)
            told = [*warnings, *chosen.warnings()]
            refused = "" if request.allow_empty else _emptiness(found, objects[0], chosen)
            told += [refused] if refused else []
            report |= {"warnings": told, "locked": locked, "edit": None, "changed": 0}
            report |= {"refused": refused}
            return report | ({"edit": commit.edit_id, "changed": commit.changed} if commit else {})

        done = partial(drop_upload, request.upload)
        return self._runner.submit(job, work, finish, on_item, done, restart)

    def _write(
        self,
        recording: Recording,
        request: LabelRequest,
        job: Job,
        found: list[FrameLabels],
        boxes: FoundBoxes,
        naming: Naming,
    ) -> tuple[Chosen, Sequence[OrientedBox], Commit | None]:
        """Commit the found labels and boxes as one edit, except in a trial or if there are none.

        Returns also the labels and boxes of the edit, or of the edit that a trial would make.
        Raises BadInputError if none were found, unless the request allows it.
        """
        sequence, keys = recording.manifest.id, {key for frame in found for key in frame.keys}
        naming = naming.in_workspace(self._store)
        chosen = Chosen.of(self._store.choosing(sequence), keys, naming)
        known = self._store.boxes.listing(sequence).boxes
        made = new_boxes(boxes, chosen, known)
        nothing = _emptiness(found, boxes, chosen)
        if request.dry_run or (nothing and request.allow_empty):
            return chosen, made, None
        if nothing:
            raise BadInputError(nothing)
        learn_numbers(self._store, naming, chosen.classes)
        locked: set[int] = set()

        def choose(palette: Palette) -> tuple[Sequence[Label], Iterator[tuple[int, Write]]]:
            nonlocal chosen, locked  # others may have added labels
            chosen = Chosen.of(palette, keys, naming)
            locked = {label.id for label in palette.labels if label.locked}
            return chosen.fresh, _writes(recording, found, chosen)

        def kept() -> list[OrientedBox]:
            nonlocal made
            made = [box for box in new_boxes(boxes, chosen, known) if box.label not in locked]
            return made

        commit = self._store.apply(
            sequence,
            edit_id=job.edit or job.id,
            author=job.owner or "",
            kind="import",
            writes=choose,
            summary=f"labels of {request.place.name}, {len(found)} frames",
            identity=recording.identity,
            boxes=kept,
        )
        return chosen, made, commit


def _emptiness(found: Sequence[FrameLabels], boxes: FoundBoxes, chosen: Chosen) -> str:
    """Return the error of an import without labelled points and boxes, otherwise ""."""
    used = {
        frame.keys[i] for frame in found for i in np.bincount(frame.which).nonzero()[0].tolist()
    }
    used.update(key for key, _ in boxes.tracks)
    if any(chosen.ids[key] for key in used):
        return ""
    return (
        f"labels: expected some labelled points or boxes, got none in the {len(found)} frames that "
        "the files are of; --allow-empty (allow_empty) accepts that"
    )


def _writes(
    recording: Recording, found: list[FrameLabels], chosen: Chosen
) -> Iterator[tuple[int, Write]]:
    for frame in found:
        ids = np.array([chosen.ids[key] for key in frame.keys], np.uint16)
        of_row = np.zeros(recording.manifest.points[frame.frame], np.uint16)
        of_row[frame.rows] = ids[frame.which] if len(ids) else 0
        label = of_row[recording[frame.frame].source_index]
        numbers = np.flatnonzero(label)
        if len(numbers):
            yield frame.frame, Write(numbers, label=label[numbers], provenance=IMPORTED)


def _locked(store: LabelStore, recording: Recording, found: list[FrameLabels]) -> list[str]:
    """Return the names of locked labels with points that ``found`` would label differently."""
    sequence = recording.manifest.id
    locked = {label.id: label.name for label in store.palette(sequence) if label.locked}
    ids: set[int] = set()
    for frame in found if locked else ():
        stored = recording[frame.frame]
        kept = KeptAnnotation(store, sequence, frame.frame, ("label",)).read(0, stored.count)
        label = np.empty(stored.count, np.uint16)
        label[stored.source_index] = kept["label"]
        ids |= locked.keys() & np.unique(label[frame.rows]).tolist()
    return [locked[each] for each in sorted(ids)]


def _report(
    recording: Recording, found: list[FrameLabels], unmatched: list[str], chosen: Chosen
) -> dict[str, Any]:
    matched = {frame.frame for frame in found}
    without = [index for index in range(len(recording)) if index not in matched]
    counts: dict[int, int] = {}
    for frame in found:
        for key, count in zip(
            frame.keys, np.bincount(frame.which, minlength=len(frame.keys)), strict=True
        ):
            counts[chosen.ids[key]] = counts.get(chosen.ids[key], 0) + int(count)
    return {
        "labelled": sum(len(frame.rows) for frame in found),
        "frames": [
            {"frame": frame.frame, "file": frame.file, "points": len(frame.rows)}
            for frame in found[:TOLD]
        ],
        "files": [{"file": frame.file, "frame": frame.frame} for frame in found],
        "matched": len(found),
        "unknown": len(chosen.unnamed),
        "unknown_classes": chosen.unnamed[:TOLD],
        "unmatched": len(without) + len(unmatched),
        "unmatched_frames": without[:TOLD],
        "unmatched_files": unmatched[:TOLD],
        "labels": {str(label): points for label, points in sorted(counts.items()) if label},
        "new_labels": [label.name for label in chosen.fresh[:TOLD]],
    }
