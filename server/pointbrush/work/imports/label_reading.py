"""Reading labels of frames, by numbers of class and instance, from files."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from dataclasses import field as of_field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats import Limits, ReadOptions
from pointbrush.formats.annotation import LabelFiles, find_label_files
from pointbrush.formats.archive import unpacked
from pointbrush.formats.boxes.figures import (
    Figure,
    FrameBox,
    FrameBoxes,
    PointFigure,
    in_metres,
    instance_numbers,
    with_one_name,
)
from pointbrush.formats.boxes.registry import BOX_READERS, read_boxes
from pointbrush.formats.boxes.scene import label_of, tracked
from pointbrush.formats.inside import require_inside
from pointbrush.formats.masks.registry import MASK_FORMATS
from pointbrush.formats.own_export import OwnExport
from pointbrush.formats.point_labels import PointLabels
from pointbrush.formats.readers.nuscenes import label_times
from pointbrush.formats.readers.s3dis import Objects, numbers_at
from pointbrush.formats.source import reported
from pointbrush.formats.tables.class_maps import ClassNumbers
from pointbrush.formats.tables.corrections import Corrections
from pointbrush.formats.tables.datasets import ClassName
from pointbrush.formats.tables.palette import SourceLabel
from pointbrush.formats.times.matching import FrameName, frames_of_numbers, match, matched
from pointbrush.jobs.worker import Channel
from pointbrush.labels.boxes.journal import MOST_BOXES
from pointbrush.sequences import Manifest, open_sequence
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences.storage.stored_files import RecordingFiles
from pointbrush.values.imports import LabelOptions
from pointbrush.work.imports.choosing import require_few
from pointbrush.work.imports.figures import figures_of
from pointbrush.work.imports.frame_labels import (
    FoundBoxes,
    FrameLabels,
    Unmatched,
    frame_names,
)
from pointbrush.work.imports.mask_reading import read_mask_labels
from pointbrush.work.imports.naming import Key, Naming, keys_of
from pointbrush.work.imports.requests import LABELS
from pointbrush.work.job_request import JobRequest

if TYPE_CHECKING:
    from typing import Self

log = logging.getLogger(__name__)
MICRO = 1e6
"""Resolution of times in pointbrush exports, parts of a second."""


@dataclass(frozen=True, kw_only=True)
class LabelRequest(LabelOptions, JobRequest):
    """Request of an import of labels: the file, folder or archive, and options."""

    call = LABELS
    place: Path
    names: Mapping[int, ClassName] = of_field(default_factory=dict)
    """Classes by number."""
    dry_run: bool = False
    """Write nothing."""
    roots: tuple[Path, ...] = ()
    upload: Path | None = None
    """Folder of its uploaded files, which is removed after the import."""

    @classmethod
    def of_json(cls, kept: Mapping[str, Any]) -> Self:
        """Return the request of a record, also of one with names as pairs of name and color."""
        names = {
            number: ClassName(*name) if isinstance(name, list) else name
            for number, name in kept["names"].items()
        }
        return super().of_json({**kept, "names": names})


@dataclass(frozen=True)
class ReadLabelsWork:
    """Picklable reading of label files; sends each frame's labels as an item."""

    request: LabelRequest
    recording: RecordingFiles
    limits: Limits

    def __call__(self, channel: Channel) -> None:
        """Read every file; nothing is written.

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
        if files.format in MASK_FORMATS:
            # The folder of the request may have the name of a camera, unlike that of an upload.
            root = place if place == request.upload else place.parent
            read_mask_labels(channel, files, root, recording, by_order=request.by_order)
            return
        channel.item(Naming(dict(files.names), dict(files.own), files.dataset))
        columns = (f"{request.field}=label",) if request.field else ()
        classes, chosen = ClassNumbers(), Corrections(columns=columns)
        options = ReadOptions(limits=self.limits, chosen=chosen, class_number=classes.number)
        frames = self._frames(files, recording)
        keys: set[Key] = set()
        for done, (path, frame) in enumerate(zip(files.paths, frames, strict=True)):
            if frame >= len(recording):
                channel.item(Unmatched(path.name))
            else:
                labels = _of_places(files.read(path, options), recording, frame)
                labels = _of_points(labels, recording, frame)
                labels = _of_export(labels, files.export, recording, frame)
                made = _of_frame(labels, frame, recording.manifest, files)
                keys.update(made.keys)
                require_few(keys)
                channel.item(made)
            channel.progress((done + 1) / len(files.paths), f"read {done + 1} label files")
        if classes.names:
            names = dict(enumerate(map(ClassName, classes.names), start=1))
            channel.item(Naming(names))

    def _frames(self, files: LabelFiles, recording: Recording) -> list[int]:
        """Return the frame of each file.  Raises the errors of ``matching.match``."""
        if files.export is not None:
            return [files.export.frames.get(path, 0) for path in files.paths]
        stamps = label_times(files.paths)
        times = [stamps[path] for path in files.paths] if stamps else None
        known = frame_names(recording.manifest)
        return match(files.file_names, known, by_order=self.request.by_order, times=times)

    def _box_frames(
        self, files: LabelFiles, found: Sequence[Sequence[FrameBoxes]], recording: Recording
    ) -> dict[FrameBoxes, int | None]:
        """Return the frames of boxes by index, name, time, or the time of the file.

        Raises the errors of ``matching.match``.
        """
        parts = [
            (path, part) for path, each in zip(files.paths, found, strict=True) for part in each
        ]
        frames: dict[FrameBoxes, int | None] = {
            part: part.frame for _, part in parts if isinstance(part.frame, int)
        }
        known = frame_names(recording.manifest)
        if files.export is None and not self.request.by_order:
            counted = {part: number for part, number in frames.items() if part.numbered}
            placed = frames_of_numbers({number or 0 for number in counted.values()}, known)
            frames |= {part: placed[number or 0] for part, number in counted.items()}
        named = {part: part.frame for _, part in parts if isinstance(part.frame, str)}
        if named:
            frames |= zip(
                named,
                match(list(named.values()), known, by_order=self.request.by_order),
                strict=True,
            )
        # A table has the times of a whole drive; the recording may be a part of it.
        timed = {part: part.time for _, part in parts if part.time is not None}
        if files.export is not None and files.export.times:
            mine = {round(t * MICRO): frame for frame, t in files.export.times.items()}
            frames |= {part: mine.get(round(time * MICRO)) for part, time in timed.items()}
            timed = {}
        moments = [FrameName("", time) for time in timed.values()]
        frames |= zip(timed, matched(moments, known), strict=True)
        unmatched_paths = {part: path for path, part in parts if part not in frames}
        unmatched = replace(files, paths=tuple(unmatched_paths.values()))
        return frames | dict(zip(unmatched_paths, self._frames(unmatched, recording), strict=True))

    def _boxes(self, channel: Channel, files: LabelFiles, recording: Recording) -> None:
        """Send the points inside boxes as items; classes are numbered in the order of names."""
        found = [read_boxes(path, files.format) for path in files.paths]
        if (export := files.export) is not None:
            found = [[part.moved_back(export.T_export_source) for part in f] for f in found]
            found = [[part.changed(partial(_ours, files.own)) for part in f] for f in found]
        elif (manifest := recording.manifest).scale != 1:
            bounds = (np.add(end, manifest.shift) for end in (manifest.lo, manifest.hi))
            found = in_metres(found, manifest.scale, *bounds)
        found = with_one_name(found)
        figures = [figure for file in found for part in file for figure in part.boxes]
        names = dict(enumerate(map(ClassName, sorted({each.name for each in figures})), start=1))
        number_of = {name.name: number for number, name in names.items()}
        instance_of = instance_numbers(figures)

        def key_of(figure: Figure) -> Key:
            if figure.label:
                return figure.label, 0
            return number_of[figure.name], instance_of[figure.key]

        require_few({key_of(figure) for figure in figures})
        # Without ids of labels (OpenPCDet's text) the palette file does not apply to the numbers.
        own = files.own if any(figure.label for figure in figures) else {}
        channel.item(Naming(names, dict(own)))
        up = recording.manifest.T_room_local[1, :3]
        frames = self._box_frames(files, found, recording)
        kept: dict[int, list[FrameBox]] = {}
        for done, (path, file) in enumerate(zip(files.paths, found, strict=True)):
            missed = 0
            for part in file:
                frame = frames[part]
                if frame is None or not 0 <= frame < len(recording):
                    missed += 1
                    continue
                which = self._which(path.name, part, recording, frame, up)
                keys = tuple(map(key_of, part.boxes))
                solid = (each for each in part.boxes if isinstance(each, FrameBox))
                kept.setdefault(frame, []).extend(solid)
                rows = np.flatnonzero(which >= 0)
                channel.item(_of_boxes(frame, path.name, rows, which[rows], keys))
            if missed:
                some = f" ({missed} of {len(file)} frames)" if missed < len(file) else ""
                channel.item(Unmatched(path.name + some))
            channel.progress((done + 1) / len(files.paths), f"read {done + 1} label files")
        if self.request.boxes != "points":
            channel.item(_objects(kept, key_of))

    def _which(
        self, file: str, part: FrameBoxes, recording: Recording, frame: int, up: NDArray[np.float64]
    ) -> NDArray[np.int64]:
        """Return the figure (N,) of each point of a frame, -1 for none; boxes only if requested."""
        if self.request.boxes == "keep":
            marked = (each for each in part.boxes if isinstance(each, PointFigure))
            if not any(True for _ in marked):
                return np.full(recording.manifest.points[frame], -1, np.int64)
        return figures_of(file, part, recording, frame, up, self.request.no_ground)


def _objects(boxes: Mapping[int, list[FrameBox]], key_of: Callable[[FrameBox], Key]) -> FoundBoxes:
    """Join the boxes of each object; none if they exceed the limit of a recording."""
    whole = {f: [box for box in each if (box.size > 0).all()] for f, each in boxes.items()}
    empty = sum(map(len, boxes.values())) - sum(map(len, whole.values()))
    tracks = tracked(sorted(whole.items()))
    if len(tracks) > MOST_BOXES:
        log.warning(
            "%d boxes are not kept, a recording has %d at most: their format does not identify "
            "objects across frames",
            len(tracks), MOST_BOXES,
        )  # fmt: skip
        return FoundBoxes(())
    return FoundBoxes(tuple((key_of(track.first), track) for track in tracks), empty)


def _ours(own: Mapping[int, SourceLabel], box: FrameBox) -> FrameBox:
    """Return a box of a pointbrush export with its label, if its key has one."""
    label = box.label or label_of(box.key)
    return replace(box, label=label if label in own else 0)


def _of_points(labels: PointLabels, recording: Recording, frame: int) -> PointLabels:
    """Select labels of a frame's points if a file has labels for invalid rows too."""
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


def _of_places(labels: PointLabels, recording: Recording, frame: int) -> PointLabels:
    """Return labels of all points of a frame for a file with labels by coordinates."""
    if labels.xyz is None or labels.instance is None:
        return labels
    xyz, scale = recording[frame].source_xyz(), recording.manifest.scale
    objects = Objects(labels.xyz * scale, labels.category, labels.instance)
    category, instance = numbers_at(labels.file, xyz, objects)
    return replace(labels, category=category, instance=instance, xyz=None)


def _of_export(
    labels: PointLabels, export: OwnExport | None, recording: Recording, frame: int
) -> PointLabels:
    """Return labels of all points of a frame for a pointbrush export with a part of them."""
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
    """Return labels of rows (n,) by the box (n,) that contains them; boxes are joined by key."""
    once = tuple(sorted(set(keys)))
    place = np.array([once.index(key) for key in keys], np.int64)
    return FrameLabels(frame, file, rows, place[box] if len(keys) else box, once)


def _of_frame(
    labels: PointLabels, frame: int, manifest: Manifest, files: LabelFiles
) -> FrameLabels:
    """Return labels of all points of a frame, or of the first of several sensors: their rows are
    the first ones.  Raises BadInputError for another number of labels."""
    count, points = len(labels.category), manifest.points[frame]
    if count not in (points, *(sensor.points[frame] for sensor in manifest.sensors[:1])):
        raise BadInputError(
            f"{labels.file}: expected {points:,} labels, one for each point of frame {frame}, "
            f"got {count:,}"
        )
    # A label of an export is an instance already.
    instance = None if files.own else labels.instance
    instance = np.zeros(count, np.int64) if instance is None else instance
    rows = np.flatnonzero(labels.category > 0)
    if 0 in files.names and not files.own:
        rows = np.arange(count)
    keys, which = keys_of(labels.category[rows], instance[rows])
    return FrameLabels(frame, labels.file, rows, which, keys)
