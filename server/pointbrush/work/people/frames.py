"""People in a stored frame, as numbers of its points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pointbrush.masks.people.memory import Memory
from pointbrush.masks.people.model import PersonModel
from pointbrush.masks.people.motion import find_motion
from pointbrush.masks.people.options import PeopleOptions
from pointbrush.masks.people.persons import find_persons
from pointbrush.masks.people.picture import DepthPicture, depth_picture, points_of
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences.stored_part import StoredPart
from pointbrush.work.masks.views import depth_images, depth_pixels

SAME_PLACE_M = 0.5
"""Distance within which people that two cameras see are one person, metres."""

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
    return stored.rgb is not None and bool(depth_images(stored))


class Search:
    """Finds people in frames of a recording, in their order; not thread-safe.

    Frames seconds apart show what moves; the frames before tell what the model has looked at.
    """

    def __init__(self, recording: Recording, model: PersonModel, options: PeopleOptions) -> None:
        self._recording, self._model, self._options = recording, model, options
        self._memory: dict[str, Memory] = {}
        self._compared: dict[tuple[int, str], _Pictured] = {}

    def people_in(self, frame: int) -> list[PersonInFrame]:
        """Return the people in a frame, the nearest first; none in a frame without a picture.

        Each depth camera is searched, and a person whom several of them see is one person.
        """
        people: list[PersonInFrame] = []
        for camera in depth_images(self._recording[frame]):
            people = _joined(people, self._seen_by(camera, frame))
        return people

    def _seen_by(self, camera: str, frame: int) -> list[PersonInFrame]:
        """Return the people in the picture of one depth camera, the nearest first."""
        pictured = self._picture(frame, camera)
        if pictured is None:
            return []
        picture, number, xyz = pictured
        motion = find_motion(picture, self._others(frame, camera), self._options)
        people = []
        look, options = self._model.probability, self._options
        memory = self._memory.setdefault(camera, Memory(options))
        for person in find_persons(picture, look, options, memory, motion):
            numbers = points_of(person.mask, picture, number, xyz)
            place = np.median(picture.room[person.mask], axis=0).astype(np.float64)
            depth = float(np.median(picture.depth[person.mask]))
            people.append(PersonInFrame(frame, numbers, person.score, place, depth))
        return people

    def _picture(self, frame: int, camera: str) -> _Pictured:
        known = self._compared.get((frame, camera))
        return known or _pictured(self._recording, frame, camera, self._options)

    def _others(self, frame: int, camera: str) -> Iterator[DepthPicture]:
        """Yield pictures of the recording's first, middle and last frame, if they are far apart."""
        last, fps = len(self._recording) - 1, self._recording.manifest.fps
        for other in sorted({0, last // 2, last}):
            if abs(other - frame) < self._options.compared_apart * fps:
                continue
            key = other, camera
            if key not in self._compared:
                self._compared[key] = _pictured(self._recording, other, camera, self._options)
            if (pictured := self._compared[key]) is not None:
                yield pictured[0]


def _joined(people: list[PersonInFrame], others: list[PersonInFrame]) -> list[PersonInFrame]:
    """Return people of one or more cameras and those of another one, joined by their places."""
    result = list(people)
    for other in others:
        far = [float(np.linalg.norm(each.place - other.place)) for each in people]
        if not far or min(far) > SAME_PLACE_M:
            result.append(other)
            continue
        at = int(np.argmin(far))
        numbers = np.union1d(result[at].numbers, other.numbers)
        score = max(result[at].score, other.score)
        result[at] = replace(result[at], numbers=numbers, score=score)
    return result


def _pictured(recording: Recording, frame: int, camera: str, options: PeopleOptions) -> _Pictured:
    """Return a depth camera's picture of a frame, its points by pixel, and the frame's points."""
    stored = recording[frame]
    part = depth_images(stored).get(camera)
    found = None if stored.rgb is None or part is None else depth_pixels(stored, part)
    if found is None or stored.rgb is None or part is None:
        return None
    width, height = found.size
    number = np.full((height, width), -1, np.int32)
    number.ravel()[found.pixel] = found.numbers
    eye = np.zeros(3) if part.viewpoint is None else part.viewpoint
    T, pitch = recording.manifest.T_room_local, _pitch(part)
    picture = depth_picture(number, stored.xyz, stored.rgb, eye, T, pitch, options.columns)
    return picture, number, stored.xyz


def _pitch(part: StoredPart) -> float:
    """Return the width of a pixel of the depth camera at a depth of 1 m, metres."""
    if part.camera is not None:
        return 1 / part.camera.fx
    return 0.0 if part.lattice is None else abs(part.lattice.pitch[0])
