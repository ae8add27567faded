"""Import of labels from files as one edit of a recording, with a report."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any, TypeVar

import numpy as np

from pointbrush.database.job import Job
from pointbrush.errors import BadInputError
from pointbrush.formats import Limits
from pointbrush.geometry.oriented_box import OrientedBox
from pointbrush.jobs.runner import Receiver
from pointbrush.labels import Commit, Label, LabelStore, Write
from pointbrush.labels.classes.palette import Palette
from pointbrush.labels.types import IMPORTED
from pointbrush.sequences import Sequence as Recording
from pointbrush.values.imports import ImportedLabels
from pointbrush.work.annotate.layers import KeptAnnotation
from pointbrush.work.imports.choosing import Chosen
from pointbrush.work.imports.frame_labels import FoundBoxes, FrameLabels, Unmatched
from pointbrush.work.imports.label_reading import LabelRequest, ReadLabelsWork
from pointbrush.work.imports.naming import Naming, learn_numbers
from pointbrush.work.imports.new_boxes import box_report, new_boxes
from pointbrush.work.imports.requests import drop_upload
from pointbrush.work.job_service import EditService, Submission

Item = TypeVar("Item")

MOST_LISTED = 100
"""Limit of entries in a report's lists."""


class LabelImports(EditService[LabelRequest]):
    """Starts imports of labels, and commits their results."""

    kind = "import"
    request = LabelRequest

    def _prepare(self, request: LabelRequest, job: Job) -> Submission:
        recording = self._recording(job.sequence or "")
        if not request.dry_run:
            self._store.require_writable()
        limits = Limits(self._context.max_points, roots=request.roots)
        work = ReadLabelsWork(request, recording.files, limits)
        return job, work, _ReadLabels(self._store, recording, request)


class _ReadLabels(Receiver):
    """Commits the labels and boxes of all files as one edit, and reports them."""

    def __init__(self, store: LabelStore, recording: Recording, request: LabelRequest) -> None:
        super().__init__()
        self._store, self._recording, self._request = store, recording, request

    def end(self, job: Job) -> None:
        drop_upload(self._request.upload, job)

    def finish(self, job: Job, cancelled: bool) -> dict[str, Any]:
        if cancelled:
            return {}
        found = self._all(FrameLabels)
        boxes = [FoundBoxes(()), *self._all(FoundBoxes)][-1]
        unmatched = [each.file for each in self._all(Unmatched)]
        warnings = [warning for each in self._all(list) for warning in each]
        locked = _locked(self._store, self._recording, found)
        chosen, made, commit = self._write(job, found, boxes, self._all(Naming)[-1])
        report = _report(self._recording, found, unmatched, chosen)
        report |= box_report(boxes, made, chosen)
        refused = "" if self._request.allow_empty else _emptiness(found, boxes, chosen)
        warnings += [*chosen.warnings(), *([refused] if refused else [])]
        report |= {"warnings": warnings, "locked": locked, "refused": refused}
        report |= {"edit": commit.edit, "changed": commit.changed} if commit else {}
        return asdict(ImportedLabels(**report))

    def _all(self, kind: type[Item]) -> list[Item]:
        return [item for item in self.items if isinstance(item, kind)]

    def _write(
        self, job: Job, found: list[FrameLabels], boxes: FoundBoxes, naming: Naming
    ) -> tuple[Chosen, Sequence[OrientedBox], Commit | None]:
        """Commit the found labels and boxes as one edit, except in a trial or if there are none.

        Returns also the labels and boxes of the edit, or of the edit that a trial would make.
        Raises BadInputError if none were found, unless the request allows it.
        """
        recording, request = self._recording, self._request
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
        frame.keys[i] for frame in found for i in np.bincount(frame.key_index).nonzero()[0].tolist()
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
        of_row[frame.rows] = ids[frame.key_index] if len(ids) else 0
        label = of_row[recording[frame.frame].source_index]
        numbers = np.flatnonzero(label)
        if len(numbers):
            write = Write(numbers, label=label[numbers], provenance=IMPORTED, only=frame.only)
            yield frame.frame, write


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
            frame.keys, np.bincount(frame.key_index, minlength=len(frame.keys)), strict=True
        ):
            counts[chosen.ids[key]] = counts.get(chosen.ids[key], 0) + int(count)
    return {
        "labelled": sum(len(frame.rows) for frame in found),
        "doubtful": sum(frame.doubtful for frame in found),
        "frames": [
            {"frame": frame.frame, "file": frame.file, "points": len(frame.rows)}
            for frame in found[:MOST_LISTED]
        ],
        "files": [
            {"file": file, "frame": frame.frame}
            for frame in found
            for file in (frame.file, *frame.more_files)
        ],
        "matched": len(found),
        "unknown": len(chosen.unnamed),
        "unknown_classes": chosen.unnamed[:MOST_LISTED],
        "unmatched": len(without) + len(unmatched),
        "unmatched_frames": without[:MOST_LISTED],
        "unmatched_files": unmatched[:MOST_LISTED],
        "labels": {str(label): points for label, points in sorted(counts.items()) if label},
        "new_labels": [label.name for label in chosen.fresh[:MOST_LISTED]],
    }
