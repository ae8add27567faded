"""People in a stored frame, as numbers of its points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.masks.people.memory import Memory
from pointbrush.masks.people.model import PersonModel
from pointbrush.masks.people.motion import find_motion
from pointbrush.masks.people.options import PeopleOptions
from pointbrush.masks.people.persons import find_persons
from pointbrush.masks.people.picture import DepthPicture, depth_picture, points_of
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences import StoredFrame
from pointbrush.work.masks.views import has_lattice, lattice_pixels

_Pictured = tuple[DepthPicture, NDArray[np.int32], NDArray[np.float32]] | None


@dataclass(frozen=True, slots=True, eq=False)
class PersonInFrame:
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
    return stored.rgb is not None and has_lattice(stored)


class Search:
    """Finds people in frames of a recording, in their order; not thread-safe.

    Frames seconds apart show what moves; the frames before tell what the model has looked at.
    """

    def __init__(self, recording: Recording, model: PersonModel, options: PeopleOptions) -> None:
        self._recording, self._model, self._options = recording, model, options
        self._memory = Memory(options)
        self._compared: dict[int, _Pictured] = {}

    def people_in(self, frame: int) -> list[PersonInFrame]:
        """Return the people in a frame, the nearest first; none in a frame without a picture."""
        pictured = self._compared.get(frame) or _pictured(self._recording, frame, self._options)
        if pictured is None:
            return []
        picture, number, xyz = pictured
        motion = find_motion(picture, self._others(frame), self._options)
        people = []
        look, options = self._model.probability, self._options
        for person in find_persons(picture, look, options, self._memory, motion):
            numbers = points_of(person.mask, picture, number, xyz)
            place = np.median(picture.room[person.mask], axis=0).astype(np.float64)
            depth = float(np.median(picture.depth[person.mask]))
            people.append(PersonInFrame(frame, numbers, person.score, place, depth))
        return people

    def _others(self, frame: int) -> Iterator[DepthPicture]:
        """Yield pictures of the recording's first, middle and last frame, if they are far apart."""
        last, fps = len(self._recording) - 1, self._recording.manifest.fps
        for other in sorted({0, last // 2, last}):
            if abs(other - frame) < self._options.compared_apart * fps:
                continue
            if other not in self._compared:
                self._compared[other] = _pictured(self._recording, other, self._options)
            if (pictured := self._compared[other]) is not None:
                yield pictured[0]


def _pictured(recording: Recording, frame: int, options: PeopleOptions) -> _Pictured:
    """Return a frame's picture, the number of its point by pixel, and its points."""
    stored = recording[frame]
    found = None if stored.rgb is None else lattice_pixels(stored)
    if found is None or stored.rgb is None:
        return None
    (width, height), pixel = found
    number = np.full((height, width), -1, np.int32)
    number.ravel()[pixel] = np.arange(stored.count)
    eye = np.zeros(3) if stored.viewpoint is None else stored.viewpoint
    T, pitch = recording.manifest.T_room_local, _pitch(stored)
    picture = depth_picture(number, stored.xyz, stored.rgb, eye, T, pitch, options.columns)
    return picture, number, stored.xyz


def _pitch(stored: StoredFrame) -> float:
    """Return the width of a pixel of the depth camera at a depth of 1 m, metres."""
    if stored.camera is not None:
        return 1 / stored.camera.fx
    return 0.0 if stored.lattice is None else abs(stored.lattice.pitch[0])
