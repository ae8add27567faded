"""The frames of a recording before they are read."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from pointbrush.formats.bag import Topic
from pointbrush.formats.options import Extras, ReadOptions
from pointbrush.formats.pictures import PictureSource
from pointbrush.formats.timing import CAMERA_FPS
from pointbrush.frame import PointFrame

INNER = ("raw", "npz", "velodyne", "velodyne_points", "data", "points", "frames")
"""Folders within a recording, which say nothing about it."""


@dataclass(frozen=True, slots=True)
class FrameFile:
    """The file ``name`` to read with ``read``, and what its folder tells of its frame."""

    name: str
    read: Callable[[ReadOptions], Iterator[PointFrame]]
    known: Extras = field(default_factory=Extras)


@dataclass(frozen=True, slots=True)
class DepthFacts:
    """Facts about depth images, in words: where their colours and intrinsics come from, and the
    pictures beside them that are not used."""

    color: str
    intrinsics: str
    unused: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Listing:
    """The frames of a folder; ``count`` is None where a file holds an unknown number.

    ``order`` and ``rate_from`` say in words what the order and ``fps`` come from; ``assumed_fps``
    is taken where ``fps`` is not known.  ``poses_from`` is the file of poses; ``topics`` are those
    of a bag; ``pictures`` those of cameras, by frame.  ``dataset`` is the one whose numbers the
    labels beside the points are, "" where it is not known; ``depth`` tells of depth images.
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
