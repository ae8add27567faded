"""Frames of a depth camera as images: which point is where in them, and their bytes on the wire.

A chunk is a ``Band`` of the lattice.  Its bytes are three numbers (uint32, little-endian), the
lengths of the first three of four parts: a picture in JPEG (empty where the chunk brings none),
frequencies, tokens and low bits (``codec``).  Ahead of the first chunk's frequencies are the depths
that occur, where those are few: pixels then hold numbers of them.
"""

from __future__ import annotations

import io
import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled
from pointbrush.errors import BadInputError
from pointbrush.sequences.depth.codec import (
    Image,
    decode_band,
    encode_band,
    read_varint,
    varint,
)
from pointbrush.sequences.depth.lattice import STRIP, Band, Lattice, Pixels

QUALITIES = (85, 92, 97)
"""JPEG qualities, tried until the colours are near enough."""
COLOR_ERROR = 6.0
"""Greatest root mean square difference of a picture's colours from a frame's own, of 255."""
SPARSE = 1.5
"""Depths are numbered where they could be so many times as many as they are."""

_LENGTHS = struct.Struct("<3I")


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """A frame's points in a lattice: ``order`` (N,) puts them into the order of the bands.

    ``first`` (C + 1,) are the bands' boundaries in it, ``number`` (height, width) is each pixel's
    point, -1 without one.
    """

    pixels: Pixels
    order: NDArray[np.int64]
    first: NDArray[np.int64]
    number: NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class Depth:
    """A frame's chunks as they go over the wire, and how far they are from the frame's values.

    ``error`` metres along the camera's axis, ``side_error`` along the others.
    """

    chunks: list[bytes]
    error: float
    side_error: float
    color_error: float


def place(lattice: Lattice, xyz: NDArray[np.float32], most_error: float) -> Placed | None:
    """Find points (N, 3), local metres, in a lattice; None where they do not go as a depth image.

    They do where each is within ``most_error`` metres of its pixel and each band has a point.
    """
    pixels = lattice.project(xyz)
    if pixels is None or pixels.error.max() > most_error:
        return None
    number = np.full(lattice.height * lattice.width, -1, np.int32)
    number[pixels.pixel] = np.arange(len(xyz), dtype=np.int32)
    image = number.reshape(lattice.height, lattice.width)
    parts = [_visit(image, band) for band in lattice.bands]
    counts = [len(part) for part in parts]
    if not all(counts):
        return None
    first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    return Placed(pixels, np.concatenate(parts), first, image)


def encode_depth(lattice: Lattice, placed: Placed, rgb: NDArray[np.uint8] | None) -> Depth | None:
    """Encode a frame in a lattice; None where its colours would be too far off."""
    pictures = _pictures(lattice, placed.number, rgb)
    if pictures is None:
        return None
    values, listed = _values(placed.pixels.depth)
    image = _image(lattice)
    image[placed.pixels.pixel // lattice.width, placed.pixels.pixel % lattice.width] = values
    chunks = []
    for chunk, band in enumerate(lattice.bands):
        tables, tokens, low = encode_band(image, band, lattice.width)
        if chunk == 0:
            tables = listed + tables
        picture = b""
        if lattice.carries_picture(chunk):
            picture = pictures.jpegs.get(lattice.picture_step(band), b"")
        lengths = _LENGTHS.pack(len(picture), len(tables), len(tokens))
        chunks.append(b"".join((lengths, picture, tables, tokens, low)))
    errors = placed.pixels.error
    side_error = float(errors[list(lattice.sides)].max())
    return Depth(chunks, float(errors[lattice.axis]), side_error, pictures.error)


def decode_depth(lattice: Lattice, chunks: list[bytes]) -> tuple[Pixels, dict[int, bytes]]:
    """The pixels of the points of a frame's first ``chunks``, in stored order, and its pictures.

    The pictures, JPEG, are by the step of their pixels.  Raises BadInputError for other bytes.
    """
    image, listed = _image(lattice), np.zeros(0, np.int64)
    pictures, pixels = {}, []
    for chunk, (band, data) in enumerate(zip(lattice.bands, chunks, strict=False)):
        if len(data) < _LENGTHS.size:
            raise BadInputError("depth: expected the lengths of its parts, got fewer bytes")
        ends = _LENGTHS.size + np.cumsum(_LENGTHS.unpack_from(data))
        picture, tables, tokens = (
            data[start:stop] for start, stop in zip((_LENGTHS.size, *ends[:-1]), ends, strict=True)
        )
        if picture:
            pictures[lattice.picture_step(band)] = picture
        if chunk == 0:
            listed, at = _read_listed(tables)
            tables = tables[at:]
        decode_band(image, band, lattice.width, tables, tokens, data[ends[-1] :])
        inside = image[: lattice.height, : lattice.width]
        pixels.append(_visit(np.where(inside > 0, _row_major(lattice), -1), band))
    pixel = np.concatenate(pixels) if pixels else np.zeros(0, np.int64)
    value = image[pixel // lattice.width, pixel % lattice.width].astype(np.int64)
    return Pixels(pixel, listed[value - 1] if len(listed) else value, np.zeros(3)), pictures


@dataclass(frozen=True, slots=True)
class _Pictures:
    """JPEG files by the step of their pixels, and the error of the finest."""

    jpegs: dict[int, bytes]
    error: float


def _pictures(
    lattice: Lattice, number: NDArray[np.int32], rgb: NDArray[np.uint8] | None
) -> _Pictures | None:
    """The pictures of a frame; None where JPEG cannot say its colours well enough."""
    if rgb is None:
        return _Pictures({}, 0.0)
    known = number >= 0
    colors = rgb.take(_spread(number), axis=0)
    for quality in QUALITIES:
        whole = _jpeg(colors, quality)
        error = _color_error(whole, colors, known)
        if error <= COLOR_ERROR:
            steps = {lattice.picture_step(band) for band in lattice.bands}
            smaller = {step: _jpeg(colors[::step, ::step], quality) for step in steps - {1}}
            return _Pictures({1: whole, **smaller}, error)
    return None


def _jpeg(colors: NDArray[np.uint8], quality: int) -> bytes:
    from PIL import Image as Pillow

    out = io.BytesIO()
    picture = Pillow.fromarray(np.ascontiguousarray(colors))
    picture.save(out, "JPEG", quality=quality, optimize=True)
    return out.getvalue()


def _color_error(jpeg: bytes, colors: NDArray[np.uint8], known: NDArray[np.bool_]) -> float:
    from PIL import Image as Pillow

    shown = np.asarray(Pillow.open(io.BytesIO(jpeg)).convert("RGB"))
    difference = shown[known].astype(np.float32) - colors[known]
    return float(np.sqrt(np.mean(difference * difference)))


def _values(depth: NDArray[np.int64]) -> tuple[NDArray[np.int64], bytes]:
    """Return pixels' values for depths (N,), and the list ahead of the first frequencies."""
    occurs = np.flatnonzero(np.bincount(depth))
    if int(occurs[-1] - occurs[0]) < SPARSE * len(occurs):
        return depth, varint(0)
    steps = np.diff(occurs, prepend=0).tolist()
    listed = varint(len(steps)) + b"".join(varint(step) for step in steps)
    return np.searchsorted(occurs, depth) + 1, listed


def _read_listed(data: bytes) -> tuple[NDArray[np.int64], int]:
    count, at = read_varint(data, 0)
    steps = np.zeros(count, np.int64)
    for n in range(count):
        steps[n], at = read_varint(data, at)
    return np.cumsum(steps), at


def _image(lattice: Lattice) -> Image:
    """An empty image with a margin, where neighbours beyond its edges are looked for."""
    margin = lattice.first_step
    return np.zeros((lattice.height + margin, lattice.width + margin), np.uint16)


def _row_major(lattice: Lattice) -> NDArray[np.int32]:
    pixels = np.arange(lattice.height * lattice.width, dtype=np.int32)
    return pixels.reshape(lattice.height, lattice.width)


@compiled
def _visit(number: NDArray[np.int32], band: Band) -> NDArray[np.int64]:
    """Return the values of a band's pixels that are not negative, in the order of its points."""
    found = np.empty(number.size, np.int64)
    n, width = 0, number.shape[1]
    for strip in range(band.row, band.stop, STRIP * band.down):
        end = min(strip + STRIP * band.down, band.stop)
        for column in range(band.column, width, band.across):
            for row in range(strip, end, band.down):
                if number[row, column] >= 0:
                    found[n] = number[row, column]
                    n += 1
    return found[:n].copy()


@compiled
def _spread(number: NDArray[np.int32]) -> NDArray[np.int32]:
    """The same with each pixel without a point taking the one to its left, or its right.

    An empty row takes the one above, so that no colour ends where nobody sees it.
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
