"""Raw pictures of sensor_msgs/Image as pixels of 8 bits.

Encodings: ros/common_msgs, sensor_msgs/include/sensor_msgs/image_encodings.h.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.cameras.pictures import MAX_BYTES

Bytes = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class RawImage:
    """A picture of a message; ``step``: bytes of a row."""

    encoding: str
    height: int
    width: int
    step: int
    big_endian: bool
    data: bytes

    def rows(self, where: str, pixel: int) -> Bytes:
        """Bytes (height, width, pixel) of the pixels; raises BadInputError for fewer."""
        width, step = self.width * pixel, self.step
        fits = 0 < step * self.height <= min(len(self.data), MAX_BYTES)
        if not (0 < width <= step and fits):
            raise BadInputError(
                f"{where}: expected {self.height} rows of {self.width} pixels, got "
                f"{len(self.data):,} bytes in rows of {step}"
            )
        rows = np.frombuffer(self.data, np.uint8, step * self.height).reshape(-1, step)
        return rows[:, :width].reshape(self.height, self.width, pixel)


def pixels_of(where: str, image: RawImage) -> Bytes:
    """Decode a picture to (height, width) grey or (height, width, 3) red, green, blue.

    Raises BadInputError for an encoding that is not read, or data of another size.
    """
    decoder = DECODERS.get(image.encoding)
    if decoder is None:
        raise BadInputError(
            f"{where}: expected pictures of {', '.join(DECODERS)}, got {image.encoding[:40]!r}"
        )
    return decoder(where, image)


def _plain(channels: tuple[int, ...], pixel: int, where: str, image: RawImage) -> Bytes:
    """Return pixels; ``channels``: places of red, green and blue, or of grey alone."""
    made = image.rows(where, pixel)[..., list(channels)]
    return made[..., 0] if len(channels) == 1 else made


def _wide(channels: tuple[int, ...], pixel: int, where: str, image: RawImage) -> Bytes:
    """Return the upper 8 bits of pixels with 16 bits a channel, as ``_plain``."""
    upper = tuple(2 * channel + (not image.big_endian) for channel in channels)
    return _plain(upper, 2 * pixel, where, image)


def _bayer(pattern: str, where: str, image: RawImage) -> Bytes:
    """Return colours from the mean of each colour's pixels in the 3x3 round a pixel.

    ``pattern`` names the colours of the first two pixels of the first two rows.
    """
    raw = image.rows(where, 1)[..., 0].astype(np.float32)
    made = np.empty((*raw.shape, 3), np.uint8)
    for channel, color in enumerate("rgb"):
        mask = np.zeros(raw.shape, np.float32)
        for place in (i for i, letter in enumerate(pattern) if letter == color):
            mask[place // 2 :: 2, place % 2 :: 2] = 1
        made[..., channel] = np.rint(_sum_3x3(raw * mask) / np.maximum(_sum_3x3(mask), 1))
    return made


def _sum_3x3(values: NDArray[np.float32]) -> NDArray[np.float32]:
    padded = np.pad(values, 1)
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    return np.asarray(rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:], np.float32)


def _yuv_422(luma: int, where: str, image: RawImage) -> Bytes:
    """Pairs of pixels that share their chroma (ITU-R BT.601, video range, as cv_bridge has it);
    ``luma`` is the place of the first luma in their four bytes.
    """
    if image.width % 2:
        raise BadInputError(f"{where}: expected an even number of pixels a row for YUV 4:2:2")
    pairs = image.rows(where, 2).reshape(image.height, -1, 4).astype(np.float32)
    y = 1.164 * (pairs[..., [luma, luma + 2]] - 16)
    u, v = (pairs[..., [at]] - 128 for at in (1 - luma, 3 - luma))
    colors = (y + 1.596 * v, y - 0.392 * u - 0.813 * v, y + 2.017 * u)
    made = np.stack(colors, axis=-1).reshape(image.height, image.width, 3)
    return np.asarray(np.rint(made.clip(0, 255)), np.uint8)


DECODERS: Mapping[str, Callable[[str, RawImage], Bytes]] = MappingProxyType({
    **dict.fromkeys(("mono8", "8uc1"), partial(_plain, (0,), 1)),
    **dict.fromkeys(("bgr8", "8uc3"), partial(_plain, (2, 1, 0), 3)),
    "rgb8": partial(_plain, (0, 1, 2), 3),
    "rgba8": partial(_plain, (0, 1, 2), 4),
    "bgra8": partial(_plain, (2, 1, 0), 4),
    "mono16": partial(_wide, (0,), 1),
    "rgb16": partial(_wide, (0, 1, 2), 3),
    "bgr16": partial(_wide, (2, 1, 0), 3),
    **{f"bayer_{each}8": partial(_bayer, each) for each in ("rggb", "bggr", "gbrg", "grbg")},
    **dict.fromkeys(("yuv422", "uyvy"), partial(_yuv_422, 1)),
    **dict.fromkeys(("yuv422_yuy2", "yuyv"), partial(_yuv_422, 0)),
})  # fmt: skip
"""Decoders by encoding, in lower case."""
