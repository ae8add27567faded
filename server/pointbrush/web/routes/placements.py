"""Placements of the frames round one that are laid over it."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from fastapi import Query
from numpy.typing import NDArray
from pydantic import BaseModel

from pointbrush.selection import MAX_FRAMES
from pointbrush.streaming.messages import Matrix4
from pointbrush.web.auth import resource
from pointbrush.web.context import FramePath, SequenceId, Ws
from pointbrush.web.problems import responses
from pointbrush.workspace import Placement

router = resource("frames")
Many = Annotated[int, Query(ge=0, le=MAX_FRAMES // 2)]


class MovingOut(BaseModel):
    """Placement of the points of a tracked label, source coordinates."""

    label: int
    T_shown_frame: Matrix4


class PlacementOut(BaseModel):
    """Placement of a frame over the shown one, source coordinates, row-major 4x4.

    ``moving``: labels whose points lie elsewhere, by their tracks.
    """

    frame: int
    T_shown_frame: Matrix4
    moving: list[MovingOut]

    @classmethod
    def of(cls, placement: Placement, shift: NDArray[np.float64]) -> PlacementOut:
        """From local coordinates (source minus ``shift``)."""

        def source(T: NDArray[np.float64]) -> list[float]:
            moved = T.copy()
            moved[:3, 3] += shift - T[:3, :3] @ shift
            return [float(value) for value in moved.ravel()]

        moving = [
            MovingOut(label=label, T_shown_frame=source(T))
            for label, T in sorted(placement.moving.items())
        ]
        return cls(
            frame=placement.frame, T_shown_frame=source(placement.T_shown_frame), moving=moving
        )


@router.get("/sequences/{seq}/frames/{i}/placements", responses=responses(404))
def list_placements(
    seq: SequenceId, i: FramePath, workspace: Ws, before: Many = 0, after: Many = 0
) -> list[PlacementOut]:
    """Frame ``i`` and those round it: where a stroke with ``frames`` takes their points to lie.

    By the recording's poses, and points of a label that is tracked in both frames by its track.
    """
    found, shift = workspace.placements(seq, i, before, after)
    return [PlacementOut.of(placement, shift) for placement in found]
