"""The frames of a recording before they are read."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from pointbrush.formats.cameras.pictures import PictureSource
from pointbrush.formats.options import Extras, ReadOptions
from pointbrush.formats.ros.bag import Topic
from pointbrush.formats.sensors.joining import JoinedSensor
from pointbrush.formats.times.timing import CAMERA_FPS
from pointbrush.frame import PointFrame

INNER = ("raw", "npz", "velodyne", "velodyne_points", "data", "points", "frames")
"""Folders within a recording, with names that do not describe it."""


@dataclass(frozen=True, slots=True)
class FrameFile:
    """The file ``name`` to read with ``read``, and facts about its frame from the folder."""

    name: str
    read: Callable[[ReadOptions], Iterator[PointFrame]]
    known: Extras = field(default_factory=Extras)


@dataclass(frozen=True, slots=True)
class DepthFacts:
    """Description of depth images for users: sources of their colours and intrinsics, and the
    pictures beside them that are not used."""

    color: str
    intrinsics: str
    unused: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Listing:
    """The frames of a folder; ``count`` is None if a file holds an unknown number.

    ``order`` and ``rate_from`` describe the sources of the order and of ``fps``; ``assumed_fps`` is
    used if ``fps`` is unknown.  ``poses_from``: the file of poses; ``topics``: topics of a bag;
    ``pictures``: camera pictures by frame.  ``dataset``: dataset that defines the numbers of labels
    beside the points, "" if it is unknown; ``depth`` describes depth images.  ``sensors``: the
    sensors of joined frames, the reference first; its files are the files of the frames.
    """

    format: str
    frames: list[FrameFile]
    times: list[float] | None = None
    fps: float | None = None
    count: int | None = None
    order: str = "by number in the file names"
    rate_from: str = ""
    assumed_fps: float = CAMERA_FPS
    poses_from: str = ""
    topics: tuple[Topic, ...] = ()
    topic: str = ""
    pictures: PictureSource | None = None
    dataset: str = ""
    depth: DepthFacts | None = None
    sensors: tuple[JoinedSensor, ...] = ()
