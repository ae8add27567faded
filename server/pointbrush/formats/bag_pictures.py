"""Pictures in bags: images with CameraInfo, paired with clouds by stamp, placed by /tf_static."""

from __future__ import annotations

import io
import logging
import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pointbrush.errors import BadInputError
from pointbrush.formats.bag import Bag, BagMessage, Clouds, Topic
from pointbrush.formats.pictures import (
    MAX_BYTES,
    MAX_CAMERAS,
    Camera,
    Matrix,
    Picture,
    PictureSource,
    picture,
    readable,
)
from pointbrush.formats.poses import of_quaternion
from pointbrush.formats.ros_message import cut_off, reader_of

log = logging.getLogger(__name__)
IMAGE, COMPRESSED, INFO, TRANSFORMS = "Image", "CompressedImage", "CameraInfo", "TFMessage"
MOST_APART = 0.2
"""Seconds between a cloud and the picture that is taken for it."""
MAX_TRANSFORMS = 100_000
ENCODINGS = {
    "rgb8": ("RGB", 3, (0, 1, 2)),
    "bgr8": ("RGB", 3, (2, 1, 0)),
    "rgba8": ("RGB", 4, (0, 1, 2)),
    "bgra8": ("RGB", 4, (2, 1, 0)),
    "mono8": ("L", 1, (0,)),
    "8uc1": ("L", 1, (0,)),
    "8uc3": ("RGB", 3, (2, 1, 0)),
}
"""Of raw images: Pillow's mode, bytes a pixel, and which of them are red, green and blue."""


@dataclass(frozen=True, slots=True)
class ImageTopic:
    """A topic of pictures, and that of its camera's intrinsics, or ""."""

    images: Topic
    info: str
    name: str


def bag_pictures(bag: Bag, found: Clouds, path: Path) -> PictureSource | None:
    """The cameras of a bag whose pictures can be read; None where there are none.

    Which picture is of which cloud is found when the pictures are read.
    """
    topics = _image_topics(found.topics)
    places = _transforms(bag, path, found.topics) if topics else None
    cameras: list[tuple[Camera, Topic]] = []
    for topic in topics:
        try:
            frame_id, is_read = _first(bag, path, topic.images)
            if is_read and places is not None:
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
    """Readers of the pictures that were taken with a cloud."""
    for camera, topic in cameras:
        name = f"{path.name} {topic.name}"
        try:
            taken = _nearest(found.stamps, _stamps(bag, path, topic))
        except BadInputError as error:
            log.warning("the pictures of %s are left out: %s", topic.name, error)
            continue
        for number, message in enumerate(bag.messages(path, topic.name)):
            for frame in taken.get(number, ()):
                yield partial(_read, frame, camera, name, topic, message)


def _read(frame: int, camera: Camera, name: str, topic: Topic, message: BagMessage) -> Picture:
    return picture(frame, camera, _content(name, topic, message), name)


def _kind(topic: Topic) -> str:
    package, _, kind = topic.type.rpartition("/")
    return kind if package.split("/")[0] in ("sensor_msgs", "tf2_msgs", "tf") else ""


def _image_topics(topics: Sequence[Topic]) -> list[ImageTopic]:
    """One topic of pictures for each camera: the compressed one where there are both."""
    infos = {topic.name for topic in topics if _kind(topic) == INFO}
    chosen: dict[str, ImageTopic] = {}
    images = [t for t in topics if _kind(t) in (IMAGE, COMPRESSED) and t.count]
    for topic in sorted(images, key=lambda t: (_kind(t) == IMAGE, t.name)):
        own = topic.name.removesuffix("/compressed")
        spaces = [own, own.rpartition("/")[0]]
        info = next((f"{s}/camera_info" for s in spaces if f"{s}/camera_info" in infos), "")
        # Depth images are clouds by themselves; image_raw and image_rect are of one camera.
        if "depth" in own.lower() or "disparity" in own.lower():
            continue
        name = (info.rpartition("/")[0] or own).strip("/").replace("/", "_")
        chosen.setdefault(name, ImageTopic(topic, info, name))
    return list(chosen.values())[:MAX_CAMERAS]


def _first(bag: Bag, path: Path, topic: Topic) -> tuple[str, bool]:
    """The frame id of a topic's first message, and whether its pictures can be read."""
    name = f"{path.name} {topic.name}"
    message = next(iter(bag.messages(path, topic.name)), None)
    if message is None:
        return "", False
    try:
        reader = reader_of(name, message)
        _, frame_id = reader.head()
        if _kind(topic) == COMPRESSED:
            return frame_id, True
        reader.number("I"), reader.number("I")
        return frame_id, reader.text().lower() in ENCODINGS
    except struct.error:
        raise cut_off(name, _kind(topic), message) from None


def _stamps(bag: Bag, path: Path, topic: Topic) -> NDArray[np.float64]:
    """Stamps (n,) of a topic's messages, seconds."""
    stamps, name = [], f"{path.name} {topic.name}"
    for message in bag.messages(path, topic.name):
        try:
            stamp, _ = reader_of(name, message).head()
        except struct.error:
            raise cut_off(name, _kind(topic), message) from None
        stamps.append(stamp or message.time)
    return np.array(stamps)


def _nearest(clouds: NDArray[np.float64], images: NDArray[np.float64]) -> dict[int, list[int]]:
    """Frames by the number of the message whose picture is nearest in time."""
    order = np.argsort(images, kind="stable")
    after = np.searchsorted(images[order], clouds).clip(1, max(len(images) - 1, 1))
    taken: dict[int, list[int]] = {}
    for frame, (stamp, at) in enumerate(zip(clouds.tolist(), after.tolist(), strict=True)):
        near = order[max(at - 1, 0) : at + 1]
        best = int(near[np.abs(images[near] - stamp).argmin()])
        if abs(float(images[best]) - stamp) <= MOST_APART:
            taken.setdefault(best, []).append(frame)
    return taken


def _content(name: str, topic: Topic, message: BagMessage) -> bytes:
    try:
        reader = reader_of(name, message)
        reader.head()
        if _kind(topic) == COMPRESSED:
            reader.text()
            return reader.bytes(reader.number("I"))
        height, width = reader.number("I"), reader.number("I")
        encoding = reader.text().lower()
        reader.number("B")
        step = reader.number("I")
        data = reader.bytes(reader.number("I"))
    except struct.error:
        raise cut_off(name, _kind(topic), message) from None
    if encoding not in ENCODINGS:
        raise BadInputError(f"{name}: expected images of {', '.join(ENCODINGS)}, got {encoding}")
    mode, size, channels = ENCODINGS[encoding]
    if not (0 < width * size <= step and len(data) >= step * height <= MAX_BYTES and height):
        raise BadInputError(
            f"{name}: expected {height} rows of {width} pixels, got {len(data):,} bytes in rows of "
            f"{step}"
        )
    rows = np.frombuffer(data, np.uint8, step * height).reshape(height, step)
    pixels = rows[:, : width * size].reshape(height, width, size)[..., list(channels)]
    packed = io.BytesIO()
    Image.fromarray(pixels[..., 0] if mode == "L" else pixels, mode).save(packed, "PNG")
    return packed.getvalue()


def _camera(
    bag: Bag,
    path: Path,
    topic: ImageTopic,
    place: Matrix | None,
) -> Camera:
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
    except struct.error:
        raise cut_off(f"{path.name} {topic.info}", INFO, message) from None
    if not (np.isfinite(K).all() and np.isfinite(distortion).all() and K[0, 0]):
        return Camera(topic.name, None, place)  # an uncalibrated camera publishes zeros
    return Camera(topic.name, K, place, tuple(distortion.tolist()), model or "plumb_bob")


# ── transforms ───────────────────────────────────────────────────────────────────────────────


def _transforms(
    bag: Bag, path: Path, topics: Sequence[Topic]
) -> Callable[[str, str], Matrix | None]:
    """``T_to_from`` of two frame ids by the bag's static transforms."""
    parents: dict[str, tuple[str, Matrix]] = {}
    for topic in topics:
        if _kind(topic) == TRANSFORMS and topic.name.strip("/") == "tf_static":
            for message in bag.messages(path, topic.name):
                for child, parent, matrix in _of_message(f"{path.name} {topic.name}", message):
                    if len(parents) < MAX_TRANSFORMS:
                        parents[child] = (parent, matrix)
    return partial(_between, parents)


def _of_message(name: str, message: BagMessage) -> Iterator[tuple[str, str, Matrix]]:
    """(child, parent, T_parent_child) of a message."""
    try:
        reader = reader_of(name, message)
        for _ in range(reader.number("I")):
            _, parent = reader.head()
            child = reader.text()
            yield child.strip("/"), parent.strip("/"), of_quaternion(name, reader.floats(7))
    except struct.error:
        raise cut_off(name, TRANSFORMS, message) from None


def _between(parents: dict[str, tuple[str, Matrix]], target: str, source: str) -> Matrix | None:
    """``T_target_source``, or None where the tree does not connect them."""
    target, source = target.strip("/"), source.strip("/")
    up_source, up_target = _to_ancestors(parents, source), _to_ancestors(parents, target)
    common = next((frame for frame in up_source if frame in up_target), None)
    if common is None:
        return None
    return np.asarray(np.linalg.inv(up_target[common]) @ up_source[common])


def _to_ancestors(parents: dict[str, tuple[str, Matrix]], frame: str) -> dict[str, Matrix]:
    """``T_ancestor_frame`` of a frame and all above it; a circle ends."""
    found = {frame: np.eye(4)}
    while frame in parents:
        parent, matrix = parents[frame]
        if parent in found:
            break
        found[parent] = matrix @ found[frame]
        frame = parent
    return found
