"""Import in a worker process, and the labels of the sample recording."""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Sequence as ListOf
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pointbrush import formats
from pointbrush.errors import BadInputError, TooLargeError
from pointbrush.formats.options import Limits, ReadOptions
from pointbrush.formats.readers.las import read_chunks
from pointbrush.formats.readers.las_header import read_header
from pointbrush.formats.tables.palette import own_labels
from pointbrush.formats.times.matching import Origin, listed
from pointbrush.formats.times.timing import ASSUMED
from pointbrush.frame import PointFrame, Sensor, has_camera_axes
from pointbrush.jobs.worker import Channel
from pointbrush.labels import LabelStore
from pointbrush.sequences import (
    LARGE_POINTS,
    Manifest,
    RecordingInfo,
    Sequence,
    import_frames,
    import_large,
)
from pointbrush.sequences.room import nearest_axis
from pointbrush.sequences.storage.manifest import note_import, update_manifest
from pointbrush.values.imports import ImportedRecording, ImportedSensor
from pointbrush.work.folder_store import FolderTarget
from pointbrush.work.imports.requests import ImportRequest, SampleRequest

if TYPE_CHECKING:
    from pointbrush.work.bucket_store import BucketTarget

PART_POINTS = 1_000_000
"""Number of points of a large scan that are in memory per step."""
SINGLE_FPS = 1.0
"""Frame rate of a single scan."""
GUESSED = "guessed"
"""Source of the up axis if neither the request nor the kind of points determines it."""


@dataclass(frozen=True)
class ImportWork:
    """Picklable import of files as the new recording ``target``."""

    request: ImportRequest
    target: FolderTarget | BucketTarget
    sequence_id: str
    max_points: int = 500_000_000

    def __call__(self, channel: Channel) -> None:
        """Read, reorder and store every frame; send the readers' warnings as an item.

        An error leaves no files.
        """
        with formats.reported() as warnings, self.target.building(channel.progress) as folder:
            for warning in self._import(channel, folder):
                warnings.setdefault(warning)
        channel.item(list(warnings))

    def _note(self, folder: Path, dataset: str) -> None:
        """Store the project, and the meaning of label numbers and coordinates in the files."""
        own = [asdict(label) for label in own_labels(self.request.paths)]
        note_import(
            folder,
            dataset="" if own else dataset,
            palette=own,
            scale=self.request.chosen.scale,
            project=self.request.project,
        )

    def _info(self, name: str, fps: float, **of_files: Any) -> RecordingInfo:
        """Return the data of the recording; ``name``: of the files."""
        request = self.request
        return RecordingInfo(
            self.sequence_id, request.name or name, fps, request.source, request.chosen.up,
            **of_files,
        )  # fmt: skip

    def _import(self, channel: Channel, folder: Path) -> list[str]:
        request = self.request
        limits = Limits(self.max_points, roots=request.roots)
        scan = large_scan(request.paths, limits)
        if scan is not None:
            options = ReadOptions(limits=limits, chosen=request.chosen)
            import_large(
                map(request.chosen.applied, read_chunks(scan, PART_POINTS, options)),
                folder,
                self._info(scan.stem, request.fps or SINGLE_FPS, origins=[Origin(scan.name)]),
                total_points=read_header(scan, limits).count,
                progress=channel.progress,
            )
            self._note(folder, "")
            return []
        with formats.open_source(request.paths, limits=limits, chosen=request.chosen) as source:
            fps, rate_source = source.rate(request.fps)
            manifest = import_frames(
                _limited(source.frames, self.max_points, source.origins),
                folder,
                self._info(source.name, fps, classes=source.classes, origins=source.origins),
                total=source.count,
                progress=channel.progress,
                pictures=source.pictures,
            )
            self._note(folder, source.listings[0].dataset)
        if rate_source != ASSUMED:
            return []
        if manifest.frames == 1:
            update_manifest(folder, fps=SINGLE_FPS)
            return []
        return [f"the rate of {fps:g} frames a second is assumed: the files do not state one"]


@dataclass(frozen=True)
class SampleWork:
    """Picklable generation and import of the sample recording."""

    target: FolderTarget | BucketTarget
    sequence_id: str
    request: SampleRequest

    def __call__(self, channel: Channel) -> None:
        """Generate and store frame by frame."""
        from pointbrush.samples.generating import sample

        request = self.request
        recording = sample(request.kind, request.seed, request.frames)
        with self.target.building(channel.progress) as folder:
            source = f"{request.source}, {request.kind}, seed {request.seed}"
            import_frames(
                recording.frames,
                folder,
                RecordingInfo(self.sequence_id, recording.name, recording.fps, source),
                total=len(recording.frames),
                progress=channel.progress,
            )


def large_scan(paths: tuple[Path, ...], limits: Limits) -> Path | None:
    """Return the single LAS file that is too large to read whole, or None."""
    if len(paths) != 1 or paths[0].suffix.lower() not in (".las", ".laz"):
        return None
    return paths[0] if read_header(paths[0], limits).count > LARGE_POINTS else None


def create_sample_labels(store: LabelStore, recording: Sequence, kind: str) -> None:
    """Create a palette for the objects of the sample, without painting them."""
    from pointbrush.samples.generating import sample

    sequence = recording.manifest.id
    admits = store.choosing(sequence).admits
    for label_id, name, category, color in sample(kind, 0, 1).labels:
        store.create_label(
            sequence, "import", id=label_id, name=name, color=color,
            category=category if admits(category) else "",
        )  # fmt: skip


def _limited(
    frames: Iterator[PointFrame], max_points: int, origins: ListOf[Origin]
) -> Iterator[PointFrame]:
    total = dropped = 0
    for number, frame in enumerate(frames):
        total, dropped = total + len(frame), dropped + frame.dropped
        if len(frame) > max_points:
            raise TooLargeError(
                f"frame {number}: expected at most {max_points:,} points, got {len(frame):,}"
            )
        yield frame
    # Single frames without returns are valid; if all are empty, the file is wrong.
    if total == 0:
        raise no_points(origins, dropped)


def no_points(origins: ListOf[Origin], dropped: int) -> BadInputError:
    """Return the error of frames without points; ``dropped`` points had no valid position."""
    files = listed(list(dict.fromkeys(origin.file for origin in origins)))
    why = f"{dropped:,} are NaN, infinite or at 0 0 0" if dropped else "the file says 0 points"
    return BadInputError(f"{files}: expected points, got none in {len(origins)} frame(s): {why}")


def up_source(given: str | None, *, camera: bool, far: bool) -> str:
    """Return the source of the up axis: ``given``, the kind of the points, or a guess."""
    return "given" if given else "depth camera" if camera else "map" if far else GUESSED


def result(recording: Sequence, warnings: list[str], up: str | None = None) -> dict[str, Any]:
    """Return the report of a finished import job; ``up``: the given axis."""
    manifest = recording.manifest
    camera, far = _in_camera_axes(manifest), any(manifest.shift)
    made = ImportedRecording(
        up=nearest_axis(manifest.T_found_room_local[1, :3]),
        up_from=up_source(up, camera=camera, far=far),
        sequence=manifest.id,
        frames=manifest.frames,
        fps=manifest.fps,
        points=int(sum(manifest.points)),
        dropped=int(sum(manifest.dropped)),
        warnings=tuple(warnings),
        sensors=tuple(
            ImportedSensor(each.name, each.type, int(np.count_nonzero(each.points)))
            for each in manifest.sensors
        ),
    )
    return asdict(made) | {"warnings": warnings}


def _in_camera_axes(manifest: Manifest) -> bool:
    """Return whether frames have the axes of a depth camera, see ``frame.has_camera_axes``."""
    if not manifest.sensors:
        return "pixel" in manifest.fields
    first = manifest.sensors[0]
    return has_camera_axes(Sensor(first.name, first.type), first.imported_mount(0))
