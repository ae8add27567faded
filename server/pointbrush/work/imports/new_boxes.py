"""Boxes of an import of labels that the recording does not have yet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.boxes.scene import SAME_SIZE
from pointbrush.geometry.oriented_box import OrientedBox
from pointbrush.geometry.quaternions import rotation_of
from pointbrush.labels.boxes.maps import box_of, fields_of
from pointbrush.work.imports.choosing import Chosen
from pointbrush.work.imports.frame_labels import FoundBoxes

MOST_LISTED = 100
"""Limit of names in a report's list."""


def new_boxes(found: FoundBoxes, chosen: Chosen, known: Sequence[OrientedBox]) -> list[OrientedBox]:
    """Return the boxes of labels, without poses at which a label already has the same box.

    A box is the same if its size, its centre and the axes of its rotation differ by less than
    SAME_SIZE.
    """
    places: dict[tuple[int, int], list[NDArray[np.float64]]] = {}
    for box in known:
        for frame in box.poses:
            places.setdefault((box.label, frame), []).append(_place(box, frame))
    made: list[OrientedBox] = []
    for key, track in found.tracks:
        if label := chosen.ids[key]:
            box = box_of(0, fields_of(track.box(label)))
            poses = {
                frame: pose
                for frame, pose in box.poses.items()
                if not any(
                    np.abs(_place(box, frame) - place).max() < SAME_SIZE
                    for place in places.get((label, frame), ())
                )
            }
            made += [replace(box, poses=poses)] if poses else []
    return made


def _place(box: OrientedBox, frame: int) -> NDArray[np.float64]:
    """Return size, centre and rotation (15,) of a box in a frame."""
    pose = box.poses[frame]
    return np.concatenate([box.size, pose.centre, rotation_of(pose.quaternion).ravel()])


def box_report(found: FoundBoxes, made: Sequence[OrientedBox], chosen: Chosen) -> dict[str, Any]:
    """Return a report of new boxes, known boxes, and objects with a median size."""
    resized = [f"{track.name} {track.key}".strip() for _, track in found.tracks if track.resized]
    poses = sum(len(track.poses) for key, track in found.tracks if chosen.ids[key])
    return {
        "boxes": len(made),
        "box_poses": sum(len(box.poses) for box in made),
        "box_poses_known": poses - sum(len(box.poses) for box in made),
        "boxes_resized": resized[:MOST_LISTED],
        "boxes_empty": found.empty,
    }
