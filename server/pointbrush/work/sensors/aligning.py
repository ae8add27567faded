"""Jobs that correct the mounts of a recording's sensors, and undo the last correction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pointbrush.database.job import Job
from pointbrush.errors import ConflictError
from pointbrush.jobs.job import MESSAGE
from pointbrush.jobs.runner import Receiver
from pointbrush.jobs.worker import Channel
from pointbrush.ranges import evenly_spaced
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences import open_sequence
from pointbrush.sequences.storage.stored_files import RecordingFiles
from pointbrush.values.sensors import AlignedSensor
from pointbrush.work.events import SequencesChanged
from pointbrush.work.job_request import JobRequest
from pointbrush.work.job_service import JobContext, JobService, Submission
from pointbrush.work.sensors import ALIGN

if TYPE_CHECKING:
    from pointbrush.tracking.sensors.alignment import Correction, SensorPoints

FRAMES = 12
"""Number of frames, spread over the recording, unless others are given."""
READING = 0.4
"""Approximate share of a job's time for reading frames."""


@dataclass(frozen=True)
class AligningWork:
    """Picklable work that sends the ``Correction`` of each sensor as an item."""

    files: RecordingFiles
    frames: tuple[int, ...]

    def __call__(self, channel: Channel) -> None:
        """Read the frames and register the sensors' surfaces."""
        from pointbrush.tracking.sensors.alignment import align_mounts  # imports SciPy

        recording, points = open_sequence(self.files), []
        for number, frame in enumerate(self.frames, 1):
            points.append(_points_of(recording, frame))
            channel.progress(READING * number / len(self.frames), f"frame {frame}")
        for correction in align_mounts(points, [s.name for s in recording.manifest.sensors]):
            channel.item(correction)


@dataclass(frozen=True)
class UndoingWork:
    """Picklable work without computation."""

    def __call__(self, _channel: Channel) -> None:
        """Do nothing."""


def _points_of(recording: Recording, number: int) -> list[SensorPoints]:
    """Return the points of each sensor in a frame, in its coordinates."""
    from pointbrush.tracking.sensors.alignment import SensorPoints

    frame = recording[number]
    xyz, sensor = frame.sensor_xyz(), frame.to_source(np.asarray(frame.sensor))
    return [
        SensorPoints(part.sensor, part.T_frame_sensor, xyz[sensor == part.sensor].astype(float))
        for part in frame.parts
    ]


@dataclass(frozen=True)
class AlignRequest(JobRequest):
    """Request to align sensors by ``frames``, or to ``undo`` the last alignment.

    ``placement``: that of the recording at the start; a job that has changed it is not repeated.
    """

    call = ALIGN
    frames: tuple[int, ...]
    placement: str
    undo: bool = False


class Aligning(JobService[AlignRequest]):
    """Aligns sensors; thread-safe."""

    kind = "alignment"
    request = AlignRequest

    def start(
        self,
        sequence: str,
        frames: Sequence[int] | None = None,
        *,
        author: str,
        undo: bool = False,
        job: str | None = None,
    ) -> Job:
        """Correct the mounts in a job.

        ``frames``: that show the sensors' common surfaces; None: some of the whole recording.
        ``undo``: restore the mounts of before the last alignment instead; a second undo takes the
        alignment again.  ``job``: its id; a repeated call does not start another job.  Raises
        ConflictError for a recording of one sensor, or with nothing to undo.
        """
        recording = self._recording(sequence)
        manifest = recording.manifest
        if len(manifest.sensors) < 2:
            raise ConflictError("sensors: expected a recording of several, got one sensor")
        if undo and all(sensor.previous is None for sensor in manifest.sensors):
            raise ConflictError("undo: expected sensors that were aligned, got none")
        spread = evenly_spaced(len(recording), FRAMES)
        wanted = tuple(sorted(set(spread if frames is None else frames)))
        for frame in wanted:
            _ = recording[frame]
        return self.begin(sequence, AlignRequest(wanted, manifest.placement, undo), author, job)

    def _prepare(self, request: AlignRequest, job: Job) -> Submission:
        recording = self._recording(job.sequence or "")
        work = UndoingWork() if request.undo else AligningWork(recording.files, request.frames)
        return job, work, _Corrections(self._context, recording, request)

    def _result(self, request: AlignRequest, job: Job) -> dict[str, Any] | None:
        manifest = self._recording(job.sequence or "").manifest
        if manifest.placement == request.placement:
            return None
        return {"sensors": [], MESSAGE: "the mounts were changed"}


class _Corrections(Receiver):
    """Writes the corrections into the manifest, unless it was changed since the start."""

    def __init__(self, context: JobContext, recording: Recording, request: AlignRequest) -> None:
        super().__init__()
        self._context, self._request = context, request
        self._sequence = recording.manifest.id

    def finish(self, _job: Job, cancelled: bool) -> dict[str, Any]:
        if cancelled:
            return {"sensors": [], MESSAGE: "no mount was changed"}
        library = self._context.library
        manifest = library.recording(self._sequence).manifest
        if manifest.placement != self._request.placement:
            raise ConflictError("sensors: the mounts were changed during the alignment")
        sensors = manifest.sensors
        if self._request.undo:
            changed = [sensor.previous or sensor.correction for sensor in sensors]
        else:
            changed = [
                (np.reshape(sensor.correction, (4, 4)) @ found.T).ravel().tolist()
                for sensor, found in zip(sensors, self.items, strict=True)
            ]
        corrections = [np.reshape(each, (4, 4)) for each in changed]
        library.update(self._sequence, corrections=corrections)
        self._context.publish(SequencesChanged(self._sequence))
        if self._request.undo:
            return {"sensors": [], MESSAGE: "restored the mounts of before the last alignment"}
        found = [_summary(s.name, each) for s, each in zip(sensors, self.items, strict=True)]
        worst = max(found, key=lambda each: each.before)
        return {
            "sensors": [asdict(each) for each in found],
            MESSAGE: f"aligned {len(found)} sensors: their surfaces were up to "
            f"{1000 * worst.before:.1f} mm apart, now {1000 * worst.after:.1f} mm",
        }


def _summary(name: str, found: Correction) -> AlignedSensor:
    return AlignedSensor(name, found.before, found.after, found.shift, found.turn, found.pairs)
