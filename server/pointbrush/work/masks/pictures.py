"""Pictures of a frame as arrays of colours."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.cameras.images import opened
from pointbrush.sequences import Sequence as Recording
from pointbrush.values.masks import LATTICE
from pointbrush.work.masks.views import lattice_pixels, size_of


def picture_of(recording: Recording, frame: int, camera: str) -> NDArray[np.uint8]:
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
