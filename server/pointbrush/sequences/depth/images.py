"""Frames of a depth camera as images: the pixels of their points, and their bytes on the wire.

A chunk is a ``Band`` of the lattice.  Its bytes are three numbers (uint32, little-endian), the
lengths of the first three of four parts: a picture in JPEG (empty where the chunk brings none),
frequencies, tokens and low bits (``codec``).  If few depths occur, a list of them precedes the
first chunk's frequencies, and pixels hold indices of it.
"""

from __future__ import annotations

import io
import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled
from pointbrush.sequences.depth.codec import Bytes, Image, encode_band, varint
from pointbrush.sequences.depth.lattice import FARTHEST, Lattice
from pointbrush.sequences.depth.projection import Placed

QUALITIES = ((85, "4:2:0"), (87, "4:2:2"), (92, "4:2:2"), (97, "4:4:4"))
"""JPEG qualities and chroma samplings, tried until the colour error is small enough."""
COARSE_QUALITY = 75, "4:2:0"
"""Quality and sampling of smaller pictures, which are shown until a finer one arrives."""
COLOR_ERROR = 6.0
"""Greatest root mean square difference of a picture's colours from a frame's own, of 255."""
_JPEG_PIXEL = 4
"""Most bytes of a pixel of a JPEG file, reached by noise."""
SPARSE = 1.5
"""Depths are indexed if the range of depths is at least so many times the number of depths."""

LENGTHS = struct.Struct("<3I")


@dataclass(frozen=True, slots=True, eq=False)
class Depth:
    """A frame's encoded chunks, and their errors.

    ``error`` metres along the camera's axis, ``side_error`` along the others.
    """

    chunks: list[bytes]
    error: float
    side_error: float
    color_error: float


def encode_depth(lattice: Lattice, placed: Placed, rgb: Bytes | None) -> Depth | None:
    """Encode a frame in a lattice; return None if its colour error would be too large."""
    found = placed.found
    pictures = _pictures(lattice, found.number, rgb)
    if pictures is None:
        return None
    image, listed = _numbered(found.image)
    chunks = []
    for chunk, band in enumerate(lattice.bands):
        tables, tokens, low = encode_band(image, band, lattice.width)
        if chunk == 0:
            tables = listed + tables
        picture = b""
        if lattice.carries_picture(chunk):
            picture = pictures.jpegs.get(lattice.picture_step(band), b"")
        lengths = LENGTHS.pack(len(picture), len(tables), len(tokens))
        chunks.append(b"".join((lengths, picture, tables, tokens, low)))
    side_error = float(found.error[list(lattice.sides)].max())
    return Depth(chunks, float(found.error[lattice.axis]), side_error, pictures.error)


@dataclass(frozen=True, slots=True)
class _Pictures:
    """JPEG files by the step of their pixels, and the error of the finest."""

    jpegs: dict[int, bytes]
    error: float


def _pictures(lattice: Lattice, number: NDArray[np.int32], rgb: Bytes | None) -> _Pictures | None:
    """Return the pictures of a frame, or None if JPEG's colour error is too large."""
    if rgb is None:
        return _Pictures({}, 0.0)
    colors = rgb.take(_spread(number), axis=0)
    for quality in QUALITIES:
        whole = _jpeg(colors, *quality)
        error = _color_error(whole, colors, number)
        if error <= COLOR_ERROR:
            steps = {lattice.picture_step(band) for band in lattice.bands}
            smaller = {step: _jpeg(colors[::step, ::step], *COARSE_QUALITY) for step in steps - {1}}
            return _Pictures({1: whole, **smaller}, error)
    return None


def _jpeg(colors: Bytes, quality: int, sampling: str) -> bytes:
    from PIL import Image as Pillow
    from PIL import ImageFile

    # Pillow raises OSError for a picture larger than its buffer, such as noise.
    most = _JPEG_PIXEL * colors.shape[0] * colors.shape[1]
    ImageFile.MAXBLOCK = max(ImageFile.MAXBLOCK, most)
    out = io.BytesIO()
    picture = Pillow.fromarray(np.ascontiguousarray(colors))
    picture.save(out, "JPEG", quality=quality, subsampling=sampling, optimize=True)
    return out.getvalue()


def _color_error(jpeg: bytes, colors: Bytes, number: NDArray[np.int32]) -> float:
    from PIL import Image as Pillow

    shown = np.asarray(Pillow.open(io.BytesIO(jpeg)).convert("RGB"))
    return float(np.sqrt(_mean_square(shown, colors, number)))


@compiled
def _mean_square(shown: Bytes, colors: Bytes, number: NDArray[np.int32]) -> float:
    """The mean squared difference of two pictures (height, width, 3) where there is a point."""
    total, count = np.int64(0), 0
    for row in range(number.shape[0]):
        for column in range(number.shape[1]):
            if number[row, column] >= 0:
                count += 3
                for part in range(3):
                    off = np.int64(shown[row, column, part]) - np.int64(colors[row, column, part])
                    total += off * off
    return total / count


def _numbered(image: Image) -> tuple[Image, bytes]:
    """Return the image with indices of depths if few occur, and the encoded list of depths.

    The list precedes the first frequencies.
    """
    occurs = np.flatnonzero(_occurring(image)[1:]) + 1
    if int(occurs[-1] - occurs[0]) < SPARSE * len(occurs):
        return image, varint(0)
    numbers = np.zeros(FARTHEST + 1, np.uint16)
    numbers[occurs] = np.arange(1, len(occurs) + 1)
    steps = np.diff(occurs, prepend=0).tolist()
    return numbers.take(image), varint(len(steps)) + b"".join(varint(step) for step in steps)


@compiled
def _occurring(image: Image) -> NDArray[np.bool_]:
    """Whether each depth (65536,) occurs."""
    occurs = np.zeros(FARTHEST + 1, np.bool_)
    for value in image.flat:
        occurs[value] = True
    return occurs


@compiled
def _spread(number: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the image with each pixel without a point replaced by the one to its left or right.

    An empty row is replaced by the row above, so that empty pixels add no edges to the picture.
    """
    out = number.copy()
    height, width = out.shape
    for row in range(height):
        for column in range(1, width):
            if out[row, column] < 0:
                out[row, column] = out[row, column - 1]
        for column in range(width - 2, -1, -1):
            if out[row, column] < 0:
                out[row, column] = out[row, column + 1]
        if out[row, 0] < 0 and row:
            out[row] = out[row - 1]
    for row in range(height - 2, -1, -1):
        if out[row, 0] < 0:
            out[row] = out[row + 1]
    return out
