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
from pointbrush.sequences.depth.projection import find


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
    return stored.rgb is not None and stored.lattice is not None


def people_in(
    recording: Recording, frame: int, model: PersonModel, options: PeopleOptions, memory: Memory
) -> list[Seen]:
    """Return the people in a frame, the nearest first; none in a frame without a picture.

    ``memory``: of the frames that were searched before.
    """
    stored = recording[frame]
    if stored.rgb is None or stored.lattice is None:
        return []
    found = find(stored.lattice, stored.xyz)
    if found is None:
        return []
    T = recording.manifest.T_room_local
    eye, pitch = np.asarray(stored.lattice.eye), abs(stored.lattice.pitch[0])
    picture = depth_picture(found.number, stored.xyz, stored.rgb, eye, T, pitch, options.columns)
    people = []
    for person in find_persons(picture, model.probability, options, memory):
        numbers = points_of(person.mask, picture, found.number, stored.xyz)
        place = np.median(picture.room[person.mask], axis=0).astype(np.float64)
        depth = float(np.median(picture.depth[person.mask]))
        people.append(Seen(frame, numbers, person.score, place, depth))
    return people
