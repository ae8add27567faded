"""Boxes of a recording for writers, and objects made of the boxes of frames."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.boxes.figures import FrameBox
from pointbrush.geometry.oriented_box import (
    UNKNOWN_OCCLUSION,
    Attributes,
    AttributeValue,
    BoxPose,
    OrientedBox,
)
from pointbrush.geometry.quaternions import quaternion_of, rotation_of
from pointbrush.values.kinds import SensorType

Floats = NDArray[np.float64]
DIGITS = 8
"""Hexadecimal digits of a token that are the number of a label or a frame."""
SAME_SIZE = 1e-3
"""Metres by which sizes of one box may differ in its frames without a warning."""
HEADING = "heading_known"
"""Attribute of a box in files, present with the value False if the heading is unknown."""
File = tuple[str, bytes]
"""Name and content of a file of an export."""


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A camera: ``K`` (3, 3), ``T_camera_source`` (4, 4), pixels."""

    K: Floats
    T_camera_source: Floats
    width: int
    height: int


@dataclass(frozen=True, slots=True, eq=False)
class ScenePart:
    """One of several sensors of a frame: ``T_source_sensor`` (4, 4), ``time`` seconds."""

    name: str
    type: SensorType
    T_source_sensor: Floats
    time: float


@dataclass(frozen=True, slots=True, eq=False)
class SceneFrame:
    """A frame with its boxes, in source coordinates.

    ``name`` of its source file, without ending; ``time`` seconds; ``points`` in each box;
    ``up`` (3,); ``pose`` ``T_world_source`` (4, 4) or None; ``view`` the camera of pictures;
    ``parts`` its sensors if the recording has several, and ``radar_points`` in each box.
    """

    index: int
    name: str
    time: float
    boxes: tuple[FrameBox, ...]
    points: tuple[int, ...] = ()
    up: Floats = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    pose: Floats | None = None
    view: View | None = None
    parts: tuple[ScenePart, ...] = ()
    radar_points: tuple[int, ...] = ()

    @property
    def stem(self) -> str:
        """File name by its number, without ending."""
        return f"{self.index:06d}"

    def counted(self) -> Iterator[tuple[FrameBox, int]]:
        """Yield each box with its number of points, 0 if they were not counted."""
        yield from zip(self.boxes, self.points or [0] * len(self.boxes), strict=True)

    def radar_counted(self) -> Iterator[tuple[FrameBox, int, int]]:
        """Yield each box with its numbers of points that are not of radars, and that are."""
        radar = self.radar_points or [0] * len(self.boxes)
        for (box, points), of_radar in zip(self.counted(), radar, strict=True):
            yield box, points - of_radar, of_radar


@dataclass(frozen=True, slots=True)
class Scene:
    """Id and classes of a recording, with their colours ``#rrggbb``."""

    recording: str
    classes: Mapping[str, str]

    def token(self, kind: str, number: int) -> str:
        """Make a token of 32 hexadecimal digits; the last ones are ``number``."""
        digest = hashlib.sha256(f"{self.recording}/{kind}".encode()).hexdigest()
        return f"{digest[: 32 - DIGITS]}{number:0{DIGITS}x}"


def label_of(key: str) -> int:
    """Read the label's id in the key of a box of our own export; 0 for none."""
    if len(plain := key.replace("-", "")) == 32:
        return int(plain[-DIGITS:], 16)
    return int(key) if key.isascii() and key.isdigit() else 0


def by_frame(
    boxes: Iterable[OrientedBox], names: Mapping[int, str]
) -> dict[int, tuple[FrameBox, ...]]:
    """List the boxes of each frame; ``names`` are the classes of labels."""
    found: dict[int, list[FrameBox]] = {}
    for box in boxes:
        for frame, pose in box.poses.items():
            found.setdefault(frame, []).append(
                FrameBox(
                    names.get(box.label, f"label {box.label}"),
                    str(box.label),
                    pose.centre,
                    box.size,
                    rotation_of(pose.quaternion),
                    box.label,
                    _known({**box.attributes, **pose.attributes, **_heading(box)}),
                )
            )
    return {frame: tuple(each) for frame, each in sorted(found.items())}


def _heading(box: OrientedBox) -> Attributes:
    return {} if box.heading_known else {HEADING: False}


def _known(attributes: Attributes) -> Attributes:
    """Leave out an unknown occlusion: each format writes a missing attribute as unknown."""
    if attributes.get("occluded") != UNKNOWN_OCCLUSION:
        return attributes
    return {name: value for name, value in attributes.items() if name != "occluded"}


@dataclass(frozen=True, slots=True, eq=False)
class BoxTrack:
    """An object of boxes of frames, with their ``name``, ``key``, ``label`` and ``heading_known``.

    ``resized``: its boxes differ in size between frames; ``size`` is the median.  ``first`` is one
    of the boxes.
    """

    name: str
    key: str
    label: int
    size: Floats
    poses: Mapping[int, BoxPose]
    attributes: Attributes
    resized: bool
    first: FrameBox
    heading_known: bool = True

    def box(self, label: int) -> OrientedBox:
        """Make the box of a label, imported."""
        return OrientedBox(
            0, label, self.size, self.poses, self.attributes, "imported", self.heading_known
        )


def tracked(frames: Iterable[tuple[int, Sequence[FrameBox]]]) -> list[BoxTrack]:
    """Join the boxes of each object by its key; a box without one is an object of its own.

    Attributes that are the same in all frames are the object's.
    """
    found: dict[tuple[str, str, int, int], dict[int, FrameBox]] = {}
    single = 0
    for frame, boxes in frames:
        seen: dict[tuple[str, str, int], int] = {}
        for box in boxes:
            alike = (box.name, box.key, box.label)
            if box.key:
                # An object has one box in a frame: a second box belongs to another object.
                number = seen[alike] = seen.get(alike, -1) + 1
            else:
                single += 1
                number = single
            found.setdefault((*alike, number), {})[frame] = box
    return [_track(boxes) for boxes in found.values()]


def _track(boxes: Mapping[int, FrameBox]) -> BoxTrack:
    first = next(iter(boxes.values()))
    known = all(box.attributes.get(HEADING, True) for box in boxes.values())
    sizes = np.stack([box.size for box in boxes.values()])
    every = [{k: v for k, v in b.attributes.items() if k != HEADING} for b in boxes.values()]
    shared = _shared(every)
    poses = {
        frame: BoxPose(
            box.center,
            quaternion_of(box.rotation),
            "imported",
            attributes={k: v for k, v in own.items() if k not in shared},
        )
        for (frame, box), own in zip(boxes.items(), every, strict=True)
    }
    resized = bool((np.ptp(sizes, axis=0) > SAME_SIZE).any())
    size = np.median(sizes, axis=0)
    return BoxTrack(first.name, first.key, first.label, size, poses, shared, resized, first, known)


def _shared(attributes: Sequence[Attributes]) -> dict[str, AttributeValue]:
    first, *others = attributes
    return {
        name: value
        for name, value in first.items()
        if all(name in other and other[name] == value for other in others)
    }
