"""The cameras of a frame, their pictures, and the frame's points in them."""

from __future__ import annotations

import io
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.formats.cameras.images import opened
from pointbrush.masks import View
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences import StoredFrame
from pointbrush.sequences.depth.lattice import Lattice
from pointbrush.sequences.depth.projection import find
from pointbrush.sequences.pictures import Projection
from pointbrush.sequences.stored_part import StoredPart
from pointbrush.values.masks import LATTICE

Pixels = NDArray[np.uint32]


def camera_names(recording: Recording, frame: int) -> list[str]:
    """Return the names of the cameras with a picture of a frame, the depth image first."""
    pictures = [each.name for each in recording.projections(frame)]
    images = list(depth_images(recording[frame]))
    return images + [name for name in pictures if name not in images]


def depth_images(stored: StoredFrame) -> dict[str, StoredPart]:
    """Return the depth cameras of a frame by the names of their depth images.

    Of several sensors each has its own, such as "depth-front".
    """
    return {
        f"{LATTICE}-{part.name}" if stored.sensors else LATTICE: part
        for part in stored.parts
        if part.camera is not None or part.lattice is not None
    }


def size_of(recording: Recording, frame: int, camera: str) -> tuple[int, int]:
    """Return width and height of a camera's picture or of the depth image, pixels.

    Raises NotFoundError naming the cameras of the frame.
    """
    part = depth_images(recording[frame]).get(camera)
    lattice = None if part is None else part.camera or part.lattice
    if lattice is not None:
        return lattice.width, lattice.height
    found = _camera(recording, frame, camera)
    return found.width, found.height


def view_of(recording: Recording, frame: int, camera: str) -> View:
    """Return a frame's points, stored order, in the picture of a camera or in its depth image.

    Raises NotFoundError naming the cameras of the frame, BadInputError without calibration.
    """
    stored = recording[frame]
    part = depth_images(stored).get(camera)
    if part is not None and (found := depth_pixels(stored, part)) is not None:
        eye = np.zeros(3) if part.viewpoint is None else part.viewpoint
        pixel = np.full(stored.count, -1, np.int32)
        pixel[found.numbers] = found.pixel
        return View.of_lattice(camera, found.size, pixel, np.linalg.norm(stored.xyz - eye, axis=1))
    return View.of_camera(
        _camera(recording, frame, camera), stored.xyz + np.asarray(recording.manifest.shift)
    )


def camera_picture(recording: Recording, frame: int, camera: str) -> NDArray[np.uint8]:
    """Return the colours (H, W, 3) of a camera's picture, or of the points of the depth image.

    Pixels of a depth image without a point are black.  Raises NotFoundError, and BadInputError for
    a depth image without colours.
    """
    width, height = size_of(recording, frame, camera)
    stored = recording[frame]
    part = depth_images(stored).get(camera)
    if part is not None and (found := depth_pixels(stored, part)) is not None:
        if stored.rgb is None:
            raise BadInputError(f"camera {camera!r}: expected points with colours, got none")
        picture = np.zeros((height * width, 3), np.uint8)
        picture[found.pixel] = stored.rgb[found.numbers]
        return picture.reshape(height, width, 3)
    name, content = recording.picture(frame, camera)
    with opened(name, io.BytesIO(content), "a picture") as image:
        if image.size != (width, height):
            raise BadInputError(f"{name}: expected {width}x{height} pixels, got {image.size}")
        return np.asarray(image.convert("RGB"))


def _camera(recording: Recording, frame: int, name: str) -> Projection:
    """Return the camera of a picture of a frame; raises NotFoundError."""
    for each in recording.projections(frame):
        if each.name == name:
            return each
    names = ", ".join(camera_names(recording, frame)) or "none"
    raise NotFoundError(f"camera: expected one of frame {frame} ({names}), got {name[:60]!r}")


class DepthPixels(NamedTuple):
    """A depth image of a ``size``, width and height, and the row-major ``pixel`` (M,) of points.

    ``numbers`` (M,): of these points, stored order, increasing.
    """

    size: tuple[int, int]
    pixel: Pixels
    numbers: NDArray[np.int64]


def depth_pixels(stored: StoredFrame, part: StoredPart) -> DepthPixels | None:
    """Return the pixels of a depth camera's points.

    The import stores the pixels of depth images; for other recordings, points are projected into
    the lattice of the frame.  None: the points do not fit a depth image.
    """
    numbers = np.arange(stored.count)
    if stored.sensor is not None:
        numbers = np.flatnonzero(stored.sensor == part.sensor)
    pixel, camera, lattice = stored.pixel, part.camera, part.lattice
    if pixel is not None and camera is not None:
        return DepthPixels((camera.width, camera.height), pixel[numbers], numbers)
    if lattice is None:
        return None
    xyz = stored.xyz
    if stored.sensor is not None:
        xyz = stored.sensor_xyz()[stored.source_index[numbers]].astype(np.float32)
    found = find(lattice, xyz)
    if found is None:
        return None
    row, column = np.divmod(found.pixel, lattice.width)
    right, down = _upright(lattice)
    column = column if right else lattice.width - 1 - column
    row = row if down else lattice.height - 1 - row
    pixel = (row * lattice.width + column).astype(np.uint32)
    return DepthPixels((lattice.width, lattice.height), pixel, numbers)


def _upright(lattice: Lattice) -> tuple[bool, bool]:
    """Return whether columns run to the right and rows down, as the camera sees them.

    Cameras that look along +z have y down (OpenCV), along -z y up (OpenGL); others have z up.
    """
    across, down = lattice.sides
    up = np.zeros(3)
    up[down] = -lattice.sign if lattice.axis == 2 else 1
    forward = np.zeros(3)
    forward[lattice.axis] = lattice.sign
    right = np.cross(forward, up)
    return bool(right[across] * lattice.pitch[0] > 0), bool(up[down] * lattice.pitch[1] < 0)
