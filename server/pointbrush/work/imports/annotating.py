"""Labels made elsewhere → one edit of a recording, with a report of what was found."""

from __future__ import annotations

import uuid
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from dataclasses import field as of_field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats import Limits, ReadOptions
from pointbrush.formats.annotation import (
    LabelFiles,
    find_label_files,
)
from pointbrush.formats.archive import unpacked
from pointbrush.formats.boxes.figures import FrameBoxes, instance_numbers
from pointbrush.formats.boxes.registry import BOX_READERS, read_boxes
from pointbrush.formats.class_maps import ClassNumbers
from pointbrush.formats.corrections import Corrections
from pointbrush.formats.datasets import ClassName
from pointbrush.formats.inside import require_inside
from pointbrush.formats.interpolation import NEAR
from pointbrush.formats.matching import FrameName, match
from pointbrush.formats.nuscenes import label_times
from pointbrush.formats.own_export import OwnExport
from pointbrush.formats.point_labels import PointLabels
from pointbrush.formats.source import reported
from pointbrush.formats.timing import nearest
from pointbrush.jobs import Job, JobRunner
from pointbrush.labels import Commit, Label, LabelStore, Write
from pointbrush.labels.palette import Palette
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences import open_sequence
from pointbrush.sequences.manifest import Manifest
from pointbrush.sequences.recording_files import RecordingFiles
from pointbrush.work.annotate.layers import KeptAnnotation
from pointbrush.work.imports.choosing import Chosen, Key
from pointbrush.work.imports.figures import figures_of
from pointbrush.work.imports.importing import IMPORTED, learn_own
from pointbrush.work.imports.submitting import LABELS, UPLOAD, drop_upload
from pointbrush.worker import Channel

TOLD = 100
"""Entries of a report's lists."""


@dataclass(frozen=True)
class LabelRequest:
    """Request of an import of labels: see ``Workspace.import_labels``."""

    place: Path
    format: str | None = None
    names: Mapping[int, ClassName] = of_field(default_factory=dict)
    dry_run: bool = False
    no_ground: bool = False
    by_order: bool = False
    """Take files for frames in their order, whatever their names are."""
    field: str | None = None
    """Name of the field of points that is labels, where the files do not say so."""
    roots: tuple[Path, ...] = ()
    upload: Path | None = None
    """Folder of files that were uploaded for it, which goes when the import has ended."""

    def as_json(self) -> dict[str, Any]:
        """Return what a job keeps, to be begun again by ``LabelImports.again``."""
        names = {str(number): (name.name, name.color) for number, name in self.names.items()}
        places = {"place": str(self.place), "roots": [str(root) for root in self.roots]}
        return (
            {"call": LABELS}
            | {f.name: getattr(self, f.name) for f in fields(self)}
            | places
            | {"names": names, UPLOAD: str(self.upload) if self.upload else None}
        )

    @classmethod
    def of_json(cls, kept: Mapping[str, Any]) -> LabelRequest:
        """Return the request that ``as_json`` made ``kept`` of."""
        values = {name: value for name, value in kept.items() if name != "call"}
        return cls(
            **values
            | {
                "place": Path(kept["place"]),
                "roots": tuple(map(Path, kept["roots"])),
                "upload": Path(kept[UPLOAD]) if kept.get(UPLOAD) else None,
                "names": {int(number): ClassName(*name) for number, name in kept["names"].items()},
            }
        )


@dataclass(frozen=True, eq=False)
class FrameLabels:
    """Labels of a frame: ``rows`` (n,) of the source that have one, ``which`` (n,) their keys."""

    frame: int
    file: str
    rows: NDArray[np.int64]
    which: NDArray[np.int64]
    keys: tuple[Key, ...]


@dataclass(frozen=True, eq=False)
class Unmatched:
    """A file that is of no frame."""

    file: str


@dataclass(frozen=True)
class ReadLabelsWork:
    """Picklable reading of label files; hands each frame's labels to the runner."""

    request: LabelRequest
    recording: RecordingFiles
    limits: Limits

    def __call__(self, channel: Channel) -> None:
        """Read every file, before anything is written.

        Raises BadInputError naming file and frame.
        """
        if self.request.roots:
            require_inside([self.request.place], self.request.roots)
        with reported() as warnings, unpacked(self.request.place, self.limits) as place:
            self._read(channel, place)
        channel.item(list(warnings))

    def _read(self, channel: Channel, place: Path) -> None:
        request = self.request
        wanted = request.format or ("points" if request.field else None)
        files = find_label_files(place, wanted, request.names, self.limits)
        recording = open_sequence(self.recording)
        if files.format in BOX_READERS:
            self._boxes(channel, files, recording)
            return
        channel.item(
            LabelFiles(files.format, (), dict(files.names), dict(files.own), files.dataset)
        )
        columns = (f"{request.field}=label",) if request.field else ()
        classes, chosen = ClassNumbers(), Corrections(columns=columns)
        options = ReadOptions(limits=self.limits, chosen=chosen, class_number=classes.number)
        frames = self._frames(files, recording)
        for done, (path, frame) in enumerate(zip(files.paths, frames, strict=True)):
            if frame >= len(recording):
                channel.item(Unmatched(path.name))
            else:
                labels = _of_points(files.read(path, options), recording, frame)
                labels = _of_export(labels, files.export, recording, frame)
                channel.item(_of_frame(labels, frame, recording.manifest.points[frame], files))
            channel.progress((done + 1) / len(files.paths), f"read {done + 1} label files")
        if classes.names:
            names = dict(enumerate(map(ClassName, classes.names), start=1))
            channel.item(LabelFiles(files.format, (), names, {}))

    def _frames(self, files: LabelFiles, recording: Recording) -> list[int]:
        """Find the frame of each file.  Raises BadInputError as ``matching.match``."""
        if files.export is not None:
            return [files.export.frames.get(path, 0) for path in files.paths]
        stamps = label_times(files.paths)
        names = [f"{path.parent.name}/{path.name}" for path in files.paths]
        times = [stamps[path] for path in files.paths] if stamps else None
        known = frame_names(recording.manifest)
        return match(names, known, by_order=self.request.by_order, times=times)

    def _box_frames(
        self, files: LabelFiles, found: Sequence[Sequence[FrameBoxes]], recording: Recording
    ) -> dict[FrameBoxes, int | None]:
        """Find the frames of boxes: their index, or by their name, their time or that of the file.

        Raises BadInputError as ``matching.match``.
        """
        parts = [
            (path, part) for path, each in zip(files.paths, found, strict=True) for part in each
        ]
        frames: dict[FrameBoxes, int | None] = {
            part: part.frame for _, part in parts if isinstance(part.frame, int)
        }
        known = frame_names(recording.manifest)
        named = {part: part.frame for _, part in parts if isinstance(part.frame, str)}
        if named:
            frames |= zip(named, match(list(named.values()), known), strict=True)
        # A table has the times of a whole drive, of which the recording may be a part.
        timed = {part: part.time for _, part in parts if part.time is not None}
        at = {index: name.time for index, name in enumerate(known) if name.time is not None}
        near = nearest(list(timed.values()), list(at.values()), NEAR)
        frames |= zip(timed, (None if k is None else list(at)[k] for k in near), strict=True)
        silent = {part: path for path, part in parts if part not in frames}
        asked = replace(files, paths=tuple(silent.values()))
        return frames | dict(zip(silent, self._frames(asked, recording), strict=True))

    def _boxes(self, channel: Channel, files: LabelFiles, recording: Recording) -> None:
        """Hand on the points inside boxes; a class has the number of its name's place."""
        found = [read_boxes(path, files.format) for path in files.paths]
        if (export := files.export) is not None:
            found = [[part.moved_back(export.T_export_source) for part in f] for f in found]
        figures = [figure for file in found for part in file for figure in part.boxes]
        names = dict(enumerate(map(ClassName, sorted({each.name for each in figures})), start=1))
        number_of = {name.name: number for number, name in names.items()}
        instance_of = instance_numbers(figures)
        channel.item(LabelFiles(files.format, (), names, dict(files.own)))
        up = recording.manifest.T_room_local[1, :3]
        frames = self._box_frames(files, found, recording)
        for done, (path, file) in enumerate(zip(files.paths, found, strict=True)):
            for part in file:
                frame = frames[part]
                if frame is None or not 0 <= frame < len(recording):
                    channel.item(Unmatched(path.name))
                    continue
                which = figures_of(path.name, part, recording, frame, up, self.request.no_ground)
                keys = tuple(
                    (each.label, 0) if each.label else (number_of[each.name], instance_of[each.key])
                    for each in part.boxes
                )
                rows = np.flatnonzero(which >= 0)
                channel.item(_of_boxes(frame, path.name, rows, which[rows], keys))
            channel.progress((done + 1) / len(files.paths), f"read {done + 1} label files")


def frame_names(manifest: Manifest) -> list[FrameName]:
    """List the files and times of a recording's frames, by which they are told apart."""
    files = manifest.files or [""] * manifest.frames
    return [FrameName(*told) for told in zip(files, manifest.timestamps, strict=True)]


def _of_points(labels: PointLabels, recording: Recording, frame: int) -> PointLabels:
    """Labels of a frame's points, where they are of all rows of its source, invalid ones too."""
    manifest = recording.manifest
    dropped = manifest.dropped[frame]
    if not dropped or len(labels.category) != manifest.points[frame] + dropped:
        return labels
    rows = recording.source_rows(frame)
    if rows is None:
        return labels
    instance = labels.instance
    return replace(
        labels,
        category=labels.category[rows],
        instance=None if instance is None else instance[rows],
    )


def _of_export(
    labels: PointLabels, export: OwnExport | None, recording: Recording, frame: int
) -> PointLabels:
    """Labels of all points of a frame, where an export of ours has those of some."""
    if labels.rows is not None:
        whole = np.zeros(recording.manifest.points[frame], np.int64)
        if len(labels.rows) and int(labels.rows.max()) >= len(whole):
            raise BadInputError(
                f"{labels.file}: expected rows below {len(whole):,}, the points of frame {frame}, "
                f"got {int(labels.rows.max()):,}"
            )
        whole[labels.rows] = labels.category
        return replace(labels, category=whole, rows=None)
    if export is None:
        return labels
    instance = labels.instance
    return replace(
        labels,
        category=export.spread(frame, labels.category),
        instance=None if instance is None else export.spread(frame, instance),
    )


def _of_boxes(
    frame: int, file: str, rows: NDArray[np.int64], box: NDArray[np.int64], keys: tuple[Key, ...]
) -> FrameLabels:
    """Labels of rows (n,) by the box (n,) they are in; boxes of one key are one."""
    once = tuple(sorted(set(keys)))
    place = np.array([once.index(key) for key in keys], np.int64)
    return FrameLabels(frame, file, rows, place[box] if len(keys) else box, once)


def _of_frame(labels: PointLabels, frame: int, points: int, files: LabelFiles) -> FrameLabels:
    count = len(labels.category)
    if count != points:
        raise BadInputError(
            f"{labels.file}: expected {points:,} labels, one for each point of frame {frame}, "
            f"got {count:,}"
        )
    instance = np.zeros(count, np.int64) if labels.instance is None else labels.instance
    rows = np.flatnonzero(labels.category > 0)
    if 0 in files.names and not files.own:
        rows = np.arange(count)
    packed = labels.category[rows] << 32 | instance[rows]
    keys, which = np.unique(packed, return_inverse=True)
    pairs = tuple((int(key) >> 32, int(key) & 0xFFFFFFFF) for key in keys)
    return FrameLabels(frame, labels.file, rows, which.astype(np.int64), pairs)


class LabelImports:
    """Starts imports of labels, and writes what they find."""

    def __init__(self, store: LabelStore, runner: JobRunner, max_points: int) -> None:
        self._store, self._runner, self._max_points = store, runner, max_points

    def start(self, recording: Recording, request: LabelRequest, author: str, job_id: str) -> Job:
        """Start a job; its result is the report."""
        kept, edit = request.as_json(), str(uuid.uuid4())
        job = Job("import", recording.manifest.id, job_id, owner=author, edit=edit, request=kept)
        return self._begin(recording, request, job)

    def again(self, recording: Recording, job: Job) -> dict[str, Any] | None:
        """Begin an import again that another server has left; return its result if it was done.

        Raises what ``start`` raises.
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
        called: list[LabelFiles] = []

        def on_item(_: Job, item: LabelFiles | FrameLabels | Unmatched | list[str]) -> None:
            match item:
                case list():
                    warnings[:] = item
                case LabelFiles():
                    called[:] = [item]
                case Unmatched():
                    unmatched.append(item.file)
                case _:
                    found.append(item)

        def restart(_: Job) -> None:
            found.clear()
            unmatched.clear()

        limits = Limits(self._max_points, roots=request.roots)
        work = ReadLabelsWork(request, recording.files, limits)

        def finish(_: Job, cancelled: bool) -> dict[str, Any]:
            if cancelled:
                return {}
            locked = _locked(self._store, recording, found)
            chosen, commit = self._write(recording, request, job, found, called[0])
            report = _report(recording, found, unmatched, chosen)
            report |= {"warnings": warnings, "locked": locked, "edit": None, "changed": 0}
            return report | ({"edit": commit.edit_id, "changed": commit.changed} if commit else {})

        def done(ended: Job) -> None:
            drop_upload(request.upload, ended)

        return self._runner.submit(job, work, finish, on_item, done, restart)

    def _write(
        self,
        recording: Recording,
        request: LabelRequest,
        job: Job,
        found: list[FrameLabels],
        files: LabelFiles,
    ) -> tuple[Chosen, Commit | None]:
        """Make what was found an edit, unless it is a trial or nothing; return its labels too."""
        sequence, keys = recording.manifest.id, {key for frame in found for key in frame.keys}
        chosen = Chosen.of(self._store.choosing(sequence), keys, files)
        if request.dry_run or not any(len(frame.rows) for frame in found):
            return chosen, None
        if files.dataset:
            self._store.taxonomy.learn(files.dataset, chosen.classes, strict=False)
        learn_own(self._store, files.own.values())

        def choose(palette: Palette) -> tuple[Sequence[Label], Iterator[tuple[int, Write]]]:
            nonlocal chosen  # others may have added labels meanwhile
            chosen = Chosen.of(palette, keys, files)
            return chosen.fresh, _writes(recording, found, chosen)

        commit = self._store.apply(
            sequence,
            edit_id=job.edit or job.id,
            author=job.owner or "",
            kind="import",
            writes=choose,
            summary=f"labels of {request.place.name}, {len(found)} frames",
            identity=recording.identity,
        )
        return chosen, commit


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
    """Names of locked labels that have points which ``found`` labels otherwise, and keep them."""
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
        "labels": {str(label): points for label, points in sorted(counts.items())},
        "new_labels": [label.name for label in chosen.fresh[:TOLD]],
    }
