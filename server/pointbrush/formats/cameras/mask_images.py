"""Masks as PNG files: an index or a grey value for each pixel."""

from __future__ import annotations

import io
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pointbrush.errors import BadInputError
from pointbrush.formats.cameras.images import opened
from pointbrush.values.masks import VOID

VOID_8_BIT = 255
"""VOID in an image of 8 bits, as in Pascal VOC and Cityscapes."""
FASTEST = 1
"""Level of compression of masks that are drawn again after each edit."""
MODES = {"1": np.uint8, "L": np.uint8, "P": np.uint8, "I;16": np.uint16, "I;16B": np.uint16}
"""Types of the values of PNG files, by Pillow's name of their mode."""

Mask = NDArray[np.uint8] | NDArray[np.uint16]


def read_mask(name: str, content: bytes, size: tuple[int, int] | None = None) -> Mask:
    """Return the values (H, W) of a PNG: uint8 for 1 to 8 bits, uint16 for 16.

    ``size``: expected width and height, which are compared before the pixels are decoded.
    Raises BadInputError, naming ``name``, for another size, kind of file or kind of pixels.
    """
    with opened(name, io.BytesIO(content), "a PNG mask") as image:
        if image.format != "PNG":
            raise BadInputError(f"{name}: expected a PNG mask, got {image.format}")
        if size is not None and image.size != size:
            raise BadInputError(f"{name}: expected {_size(*size)} pixels, got {_size(*image.size)}")
        # Pillow reads 16 bit grey as I in some versions.
        kind = MODES.get("I;16" if image.mode == "I" else image.mode)
        if kind is None:
            raise BadInputError(
                f"{name}: expected a PNG with an index or a grey value a pixel, got {image.mode}"
            )
        return np.asarray(image).astype(kind)


def _size(width: int, height: int) -> str:
    return f"{width}x{height}"


def write_mask(mask: NDArray[np.uint16], colors: dict[int, str]) -> bytes:
    """Return a mask (H, W) as PNG: 8-bit index with the colours (#rrggbb) of its values.

    VOID is 255, transparent.  A value over 254 makes the PNG 16-bit grey, in which VOID is 65535.
    """
    out = io.BytesIO()
    if max(colors, default=0) >= VOID_8_BIT or mask[mask != VOID].max(initial=0) >= VOID_8_BIT:
        Image.fromarray(mask).save(out, "PNG")
        return out.getvalue()
    image = Image.fromarray(np.where(mask == VOID, VOID_8_BIT, mask).astype(np.uint8), "L")
    table = np.zeros((256, 3), np.uint8)
    for value, color in colors.items():
        table[value] = list(bytes.fromhex(color[1:]))
    image.putpalette(table.tobytes())
    image.save(out, "PNG", transparency=bytes([255] * VOID_8_BIT + [0]))
    return out.getvalue()


def draw_mask(mask: NDArray[np.uint16], colors: Mapping[int, str]) -> bytes:
    """Return a mask (H, W) as PNG to lay over the picture: only values with a colour are seen."""
    table = np.zeros((1 << 16, 4), np.uint8)
    for value, color in colors.items():
        table[value] = [*bytes.fromhex(color[1:]), 255]
    out = io.BytesIO()
    Image.fromarray(table[mask], "RGBA").save(out, "PNG", compress_level=FASTEST)
    return out.getvalue()
