"""The cameras of a frame, their pictures, and the frame's points in them."""

from __future__ import annotations

import io

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
from pointbrush.values.masks import LATTICE

Pixels = NDArray[np.uint32]


def camera_names(recording: Recording, frame: int) -> list[str]:
    """Return the names of the cameras with a picture of a frame, the depth image first."""
    pictures = [each.name for each in recording.projections(frame)]
    return ([LATTICE] if has_lattice(recording[frame]) else []) + [
        name for name in pictures if name != LATTICE
    ]


def has_lattice(stored: StoredFrame) -> bool:
    """Return whether a frame is stored with the lattice of its depth camera."""
    return stored.pixel is not None or stored.lattice is not None


def size_of(recording: Recording, frame: int, camera: str) -> tuple[int, int]:
    """Return width and height of a camera's picture or of the depth image, pixels.

    Raises NotFoundError naming the cameras of the frame.
    """
    stored = recording[frame]
    lattice = stored.camera or stored.lattice
    if camera == LATTICE and lattice is not None:
        return lattice.width, lattice.height
    found = _camera(recording, frame, camera)
    return found.width, found.height


def view_of(recording: Recording, frame: int, camera: str) -> View:
    """Return a frame's points, stored order, in the picture of a camera or in its depth image.

    Raises NotFoundError naming the cameras of the frame, BadInputError without calibration.
    """
    stored = recording[frame]
    if camera == LATTICE and (found := lattice_pixels(stored)) is not None:
        size, pixel = found
        eye = np.zeros(3) if stored.viewpoint is None else stored.viewpoint
        return View.of_lattice(LATTICE, size, pixel, np.linalg.norm(stored.xyz - eye, axis=1))
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
    if camera == LATTICE and (found := lattice_pixels(stored)) is not None:
        if stored.rgb is None:
            raise BadInputError(f"camera {camera!r}: expected points with colours, got none")
        picture = np.zeros((height * width, 3), np.uint8)
        picture[found[1]] = stored.rgb
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


def lattice_pixels(stored: StoredFrame) -> tuple[tuple[int, int], Pixels] | None:
    """Return width and height of a frame's depth image, and its points' pixels (N,), stored order.

    The import stores the pixels of depth images; for other recordings, points are projected into
    the lattice of the frame.  None: the points do not fit a depth image.
    """
    pixel, camera, lattice = stored.pixel, stored.camera, stored.lattice
    if pixel is not None and camera is not None:
        return (camera.width, camera.height), pixel
    found = None if lattice is None else find(lattice, stored.xyz)
    if lattice is None or found is None:
        return None
    row, column = np.divmod(found.pixel, lattice.width)
    right, down = _upright(lattice)
    column = column if right else lattice.width - 1 - column
    row = row if down else lattice.height - 1 - row
    return (lattice.width, lattice.height), (row * lattice.width + column).astype(np.uint32)


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
