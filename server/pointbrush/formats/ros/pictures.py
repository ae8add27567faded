"""Pictures in bags: images with CameraInfo, paired with clouds by stamp, placed by transforms."""

from __future__ import annotations

import io
import logging
import re
import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from PIL import Image

from pointbrush.errors import BadInputError
from pointbrush.formats.cameras.pictures import (
    MAX_CAMERAS,
    Camera,
    Matrix,
    Picture,
    PictureSource,
    picture,
    projecting,
    readable,
)
from pointbrush.formats.ros.bag import Bag, BagMessage, Clouds, Topic
from pointbrush.formats.ros.message import (
    COMPRESSED,
    IMAGE,
    INFO,
    cut_off,
    head_of_message,
    kind_of,
    reader_of,
)
from pointbrush.formats.ros.raw_images import RawImage, pixels_of
from pointbrush.formats.ros.transforms import mounts
from pointbrush.formats.times.matching import FrameName, partners

log = logging.getLogger(__name__)
MOST_APART = 0.2
"""Seconds between a cloud and the picture that is taken for it."""
SINGULAR = 1e-9
"""Determinant below which a projection counts as singular."""
_RECTIFIED = re.compile(r"(?:^|[/_])rect(?:ified)?(?:[/_]|$)")
"""Part of the name of a topic with rectified pictures, as in image_proc."""


@dataclass(frozen=True, slots=True)
class ImageTopic:
    """A topic of pictures, and the topic of its camera's intrinsics, or ""."""

    images: Topic
    info: str
    name: str


def bag_pictures(bag: Bag, found: Clouds, path: Path) -> PictureSource | None:
    """Return the cameras of a bag with readable pictures, or None without any.

    Pictures are matched to clouds when they are read.
    """
    topics = _image_topics(found.topics)
    places = mounts(bag, path, found.topics) if topics else None
    cameras: list[tuple[Camera, Topic]] = []
    for topic in topics:
        try:
            frame_id = _first(bag, path, topic.images)
            if frame_id is not None and places is not None:
                place = places(frame_id, found.sensor)
                cameras.append((_camera(bag, path, topic, place), topic.images))
        except BadInputError as error:
            log.warning("the pictures of %s are left out: %s", topic.images.name, error)
    if not cameras:
        return None
    jobs = partial(_jobs, bag, found, path, cameras)
    return PictureSource(tuple(camera for camera, _ in cameras), lambda: readable(jobs()))


def _jobs(
    bag: Bag, found: Clouds, path: Path, cameras: Sequence[tuple[Camera, Topic]]
) -> Iterator[Callable[[], Picture]]:
    """Yield readers of the pictures that were taken with a cloud."""
    for camera, topic in cameras:
        name = f"{path.name} {topic.name}"
        try:
            moments = [FrameName("", stamp) for stamp in found.stamps.tolist()]
            numbers = partners(moments, _stamps(bag, path, topic), near=MOST_APART)
        except BadInputError as error:
            log.warning("the pictures of %s are left out: %s", topic.name, error)
            continue
        taken: dict[int | None, list[int]] = {}
        for frame, number in enumerate(numbers):
            taken.setdefault(number, []).append(frame)
        for number, message in enumerate(bag.messages(path, topic.name)):
            for frame in taken.get(number, ()):
                yield partial(_read, frame, camera, name, topic, message)


def _read(frame: int, camera: Camera, name: str, topic: Topic, message: BagMessage) -> Picture:
    return picture(frame, camera, _content(name, topic, message), name)


def _image_topics(topics: Sequence[Topic]) -> list[ImageTopic]:
    """Return one topic of pictures for each camera, the compressed one if there are both."""
    infos = {topic.name for topic in topics if kind_of(topic.type) == INFO}
    chosen: dict[str, ImageTopic] = {}
    images = [t for t in topics if kind_of(t.type) in (IMAGE, COMPRESSED) and t.count]
    for topic in sorted(images, key=lambda t: (kind_of(t.type) == IMAGE, t.name)):
        own = topic.name.removesuffix("/compressed")
        spaces = [own, own.rpartition("/")[0]]
        info = next((f"{s}/camera_info" for s in spaces if f"{s}/camera_info" in infos), "")
        if "depth" in own.lower() or "disparity" in own.lower():
            log.warning(
                "the images of %s are left out: turn depth images into points with "
                "depth_image_proc", topic.name,
            )  # fmt: skip
            continue
        # image_raw and image_rect are of one camera.
        name = (info.rpartition("/")[0] or own).strip("/").replace("/", "_")
        chosen.setdefault(name, ImageTopic(topic, info, name))
    return list(chosen.values())[:MAX_CAMERAS]


def _first(bag: Bag, path: Path, topic: Topic) -> str | None:
    """The frame id of a topic's first message, None where there is none.

    Raises BadInputError for pictures that cannot be read.
    """
    name = f"{path.name} {topic.name}"
    message = next(iter(bag.messages(path, topic.name)), None)
    if message is None:
        return None
    _, frame_id = head_of_message(name, message, kind_of(topic.type))
    if kind_of(topic.type) == IMAGE:
        pixels_of(name, _raw_image(name, message))
    return frame_id


def _stamps(bag: Bag, path: Path, topic: Topic) -> list[FrameName]:
    """Stamps of a topic's messages."""
    name, kind = f"{path.name} {topic.name}", kind_of(topic.type)
    messages = bag.messages(path, topic.name)
    return [FrameName("", head_of_message(name, each, kind)[0]) for each in messages]


def _content(name: str, topic: Topic, message: BagMessage) -> bytes:
    """A picture as a file: as it was compressed, or as PNG."""
    if kind_of(topic.type) == IMAGE:
        packed = io.BytesIO()
        Image.fromarray(pixels_of(name, _raw_image(name, message))).save(packed, "PNG")
        return packed.getvalue()
    try:
        reader = reader_of(name, message)
        reader.head()
        reader.text()
        return reader.bytes(reader.number("I"))
    except struct.error:
        raise cut_off(name, COMPRESSED, message) from None


def _raw_image(name: str, message: BagMessage) -> RawImage:
    try:
        reader = reader_of(name, message)
        reader.head()
        height, width = reader.number("I"), reader.number("I")
        encoding = reader.text().lower()
        big_endian, step = bool(reader.number("B")), reader.number("I")
        data = reader.bytes(reader.number("I"))
    except struct.error:
        raise cut_off(name, IMAGE, message) from None
    return RawImage(encoding, height, width, step, big_endian, data)


def _camera(bag: Bag, path: Path, topic: ImageTopic, place: Matrix | None) -> Camera:
    """The camera of a topic's pictures by the first CameraInfo.

    Raw pictures are seen by K and the distortion, rectified ones by P without distortion, as the
    definition of sensor_msgs/CameraInfo says; a camera that is not calibrated publishes zeros.
    """
    message = next(iter(bag.messages(path, topic.info)), None) if topic.info else None
    if message is None:
        return Camera(topic.name, None, place)
    try:
        reader = reader_of(f"{path.name} {topic.info}", message)
        reader.head()
        reader.number("I"), reader.number("I")
        model = reader.text()
        distortion = reader.floats(reader.number("I"))
        K = reader.floats(9).reshape(3, 3)
        reader.floats(9)  # R: turns the raw camera to the rectified one
        P = reader.floats(12).reshape(3, 4)
    except struct.error:
        raise cut_off(f"{path.name} {topic.info}", INFO, message) from None
    if _RECTIFIED.search(topic.images.name):
        known = np.isfinite(P).all() and abs(np.linalg.det(P[:, :3])) >= SINGULAR
        return projecting(topic.name, P, place) if known else Camera(topic.name, None, place)
    if not (np.isfinite(K).all() and np.isfinite(distortion).all() and K[0, 0]):
        return Camera(topic.name, None, place)
    return Camera(topic.name, K, place, tuple(distortion.tolist()), model or "plumb_bob")
