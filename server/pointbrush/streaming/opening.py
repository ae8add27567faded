"""Opening of a sequence: its description, and a past that is its own."""

from __future__ import annotations

from pointbrush.errors import BadInputError
from pointbrush.sequences import Lattice
from pointbrush.streaming import messages
from pointbrush.streaming.hub import Hub
from pointbrush.streaming.room import Room


async def of_this_import(hub: Hub, message: messages.Open) -> messages.Open:
    """``message``, without what the viewer has of another import under the same id.

    Raises BadInputError for a revision from another life of the database, before anything is
    opened, or for held frames without one; NotFoundError for an unknown sequence.
    """
    recording = await hub.read(hub.workspace.recording, message.sequence)
    if message.identity not in (None, recording.identity):
        return message.model_copy(update={"revision": None, "held": None})
    if message.revision is None:
        if message.held is not None:
            raise BadInputError("held: expected together with the revision it was held at")
        return message
    newest = await hub.read(hub.workspace.store.revision, message.sequence)
    if message.revision > newest:
        raise BadInputError(f"revision: expected at most {newest}, got {message.revision}")
    return message


def sequence_info(room: Room, frame: int) -> messages.SequenceInfo:
    """The answer to ``open``: the manifest, and the frame that is shown."""
    manifest = room.recording.manifest
    return messages.SequenceInfo(
        id=manifest.id,
        identity=room.recording.identity,
        name=manifest.name,
        frames=manifest.frames,
        fps=manifest.fps,
        points=list(manifest.points),
        fields=list(manifest.fields),
        shift=list(manifest.shift),
        lo=list(manifest.lo),
        hi=list(manifest.hi),
        room=list(manifest.room),
        large=manifest.large,
        position_error=manifest.position_error,
        color_error=manifest.color_error,
        lattice=None if manifest.lattice is None else _lattice(manifest.lattice),
        revision=room.revision,
        frame=frame,
    )


def _lattice(lattice: Lattice) -> messages.Lattice:
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
