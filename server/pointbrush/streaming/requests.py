"""A viewer's requests other than edits: opening a sequence, and candidates before a stroke."""

from __future__ import annotations

import asyncio

import numpy as np

from pointbrush.errors import BadInputError, PointbrushError
from pointbrush.ranges import runs_of
from pointbrush.sequences import Lattice, Manifest
from pointbrush.sequences.storage.sensors import StoredSensor
from pointbrush.streaming import messages
from pointbrush.streaming.encoding import encode
from pointbrush.streaming.hub import Hub
from pointbrush.streaming.room import Room
from pointbrush.streaming.viewer import Viewer
from pointbrush.work.loops.compiling import LOOK_SECONDS
from pointbrush.work.objects.service import Answer


async def of_this_import(hub: Hub, message: messages.Open) -> messages.Open:
    """Return ``message`` without revision and held frames of another import of the same id, or of
    other mounts of its sensors.

    Raises BadInputError for a revision that the database has not reached, and for held frames
    without a revision; NotFoundError for an unknown sequence.
    """
    recording = await hub.read(hub.workspace.recording, message.sequence)
    if message.identity not in (None, recording.placement):
        return message.model_copy(update={"revision": None, "held": None})
    if message.revision is None:
        if message.held is not None:
            raise BadInputError("held: expected together with the revision it was held at")
        return message
    newest = await hub.read(hub.workspace.labels.revision, message.sequence)
    if message.revision > newest:
        raise BadInputError(f"revision: expected at most {newest}, got {message.revision}")
    return message


def sequence_info(room: Room, frame: int) -> messages.SequenceInfo:
    """Return the answer to ``open``: the manifest, and the frame that is shown."""
    manifest = room.recording.manifest
    lo, hi = manifest.bounds
    return messages.SequenceInfo(
        id=manifest.id,
        identity=room.recording.placement,
        name=manifest.name,
        frames=manifest.frames,
        fps=manifest.fps,
        points=list(manifest.points),
        fields=list(manifest.fields),
        shift=list(manifest.shift),
        lo=lo,
        hi=hi,
        room=list(manifest.room),
        cameras=room.cameras,
        large=manifest.large,
        position_error=manifest.position_error,
        color_error=manifest.color_error,
        lattice=_lattice(manifest.depth_lattice),
        sensors=[sensor_info(sensor, manifest) for sensor in manifest.sensors],
        revision=room.revision,
        frame=frame,
    )


def sensor_info(sensor: StoredSensor, manifest: Manifest) -> messages.SensorInfo:
    """Return one of several sensors for the message ``sequence``."""
    mounts = np.reshape(sensor.mounts, (-1, 4, 4))
    mounts[:, :3, 3] -= manifest.shift
    return messages.SensorInfo(
        name=sensor.name,
        type=sensor.type,
        lattice=_lattice(sensor.lattice if manifest.sends_depth else None),
        T_frame_sensor=mounts.reshape(-1, 16).tolist(),
        correction=sensor.correction,
    )


def _lattice(lattice: Lattice | None) -> messages.Lattice | None:
    if lattice is None:
        return None
    return messages.Lattice(
        width=lattice.width,
        height=lattice.height,
        axis=lattice.axis,
        sign=1 if lattice.sign > 0 else -1,
        tangent=list(lattice.tangent),
        pitch=list(lattice.pitch),
        eye=list(lattice.eye),
        unit=lattice.unit,
    )


class PreviewRequests:
    """Answers one viewer's newest ``ask`` message; older waiting ones are dropped."""

    def __init__(self, viewer: Viewer, hub: Hub) -> None:
        self._viewer, self._hub = viewer, hub
        self._newest: messages.Ask | None = None
        self._question_waiting = asyncio.Event()

    def put(self, question: messages.Ask) -> None:
        """Replace the waiting question."""
        self._newest = question
        self._question_waiting.set()

    async def run(self) -> None:
        """Answer until cancelled."""
        while True:
            await self._question_waiting.wait()
            while self._waits_for_loops():
                await asyncio.sleep(LOOK_SECONDS)
            self._question_waiting.clear()
            question, self._newest = self._newest, None
            if question is None:
                continue
            try:
                sequence = self._viewer.require_room().id
                answer = await self._hub.read(self._answer, sequence, question)
            except PointbrushError as error:
                self._viewer.refuse(error, question.id)
            else:
                self._viewer.outbox.reply(encode(answer_message(question, answer)))

    def _waits_for_loops(self) -> bool:
        """Return whether the question is about an object and its loops are not compiled yet."""
        question = self._newest
        about_object = question is not None and question.brush.shape == "object"
        return about_object and "objects" in self._hub.workspace.loops.missing()

    def _answer(self, sequence: str, question: messages.Ask) -> Answer:
        fields = {
            **question.brush.model_dump(),
            "positives": [sample.model_dump() for sample in question.samples],
            "negatives": [sample.model_dump() for sample in question.negatives],
            "previous": question.previous,
        }
        return self._hub.workspace.strokes.preview(sequence, question.frame, fields)


def answer_message(question: messages.Ask, answer: Answer) -> messages.Candidates:
    """Return the message of candidates; points are numbered in stored order."""
    return messages.Candidates(
        id=question.id,
        frame=question.frame,
        first=answer.first,
        ready=answer.ready,
        candidates=[
            messages.Candidate(
                id=level.id,
                level=level.level,
                score=level.score,
                points=len(level.numbers),
                runs=runs_of(level.numbers).astype("<u4").tobytes(),
            )
            for level in answer.candidates
        ],
    )
