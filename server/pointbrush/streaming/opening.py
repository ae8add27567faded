"""What opening a sequence needs: its description, and a revision that is one of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pointbrush.errors import BadInputError
from pointbrush.streaming import messages
from pointbrush.streaming.room import Room

if TYPE_CHECKING:
    from pointbrush.streaming.hub import Hub


async def require_known(hub: Hub, sequence: str, revision: int) -> None:
    """Refuse a revision from another life of the database, before anything is opened.

    Raises BadInputError, or NotFoundError for an unknown sequence.
    """
    newest = await hub.read(hub.workspace.store.revision, sequence)
    if revision > newest:
        raise BadInputError(f"revision: expected at most {newest}, got {revision}")


def sequence_info(room: Room, frame: int) -> messages.SequenceInfo:
    """The answer to ``open``: the manifest, and the frame that is shown."""
    manifest = room.recording.manifest
    return messages.SequenceInfo(
        id=manifest.id,
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
        revision=room.revision,
        frame=frame,
    )
