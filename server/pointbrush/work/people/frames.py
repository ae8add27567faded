"""People in a stored frame, as numbers of its points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.masks.people.memory import Memory
from pointbrush.masks.people.model import PersonModel
from pointbrush.masks.people.options import PeopleOptions
from pointbrush.masks.people.persons import find_persons
from pointbrush.masks.people.picture import depth_picture, points_of
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences import StoredFrame
from pointbrush.values.masks import LATTICE
from pointbrush.work.masks.views import camera_names, lattice_pixels


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """A person in a frame.

    ``numbers`` (n,) of its points, stored order, ascending; ``score`` 0 to 1; ``place`` (3,) room
    coordinates, metres; ``depth`` metres from the sensor.
    """

    frame: int
    numbers: NDArray[np.int64]
    score: float
    place: NDArray[np.float64]
    depth: float


def has_pictures(recording: Recording, frame: int) -> bool:
    """Return whether people can be searched in a frame."""
    stored = recording[frame]
    return stored.rgb is not None and LATTICE in camera_names(recording, frame)


def people_in(
    recording: Recording, frame: int, model: PersonModel, options: PeopleOptions, memory: Memory
) -> list[Seen]:
    """Return the people in a frame, the nearest first; none in a frame without a picture.

    ``memory``: of the frames that were searched before.
    """
    stored = recording[frame]
    found = None if stored.rgb is None else lattice_pixels(stored)
    if found is None or stored.rgb is None:
        return []
    (width, height), pixel = found
    number = np.full((height, width), -1, np.int32)
    number.ravel()[pixel] = np.arange(stored.count)
    eye = np.zeros(3) if stored.viewpoint is None else stored.viewpoint
    T = recording.manifest.T_room_local
    picture = depth_picture(number, stored.xyz, stored.rgb, eye, T, _pitch(stored), options.columns)
    people = []
    for person in find_persons(picture, model.probability, options, memory):
        numbers = points_of(person.mask, picture, number, stored.xyz)
        place = np.median(picture.room[person.mask], axis=0).astype(np.float64)
        depth = float(np.median(picture.depth[person.mask]))
        people.append(Seen(frame, numbers, person.score, place, depth))
    return people


def _pitch(stored: StoredFrame) -> float:
    """Return the width of a pixel of the depth camera at a depth of 1 m, metres."""
    if stored.camera is not None:
        return 1 / stored.camera.fx
    return 0.0 if stored.lattice is None else abs(stored.lattice.pitch[0])
