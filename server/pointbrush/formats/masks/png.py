"""PNG files of masks: an index, a grey value or a colour for each pixel."""

from __future__ import annotations

import io
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pointbrush.errors import BadInputError
from pointbrush.formats.cameras.images import opened
from pointbrush.formats.masks.mask import Size, require_size
from pointbrush.values.masks import VOID

VOID_8_BIT = 255
"""VOID in an image of 8 bits, as in Pascal VOC and Cityscapes."""
FASTEST = 1
"""Level of compression of masks that are drawn again after each edit."""
DEEP = ("I;16", "I;16B", "I;16L", "I")
"""Pillow's modes of images with 16 bits or more."""
PLAIN = ("1", "L", "P", *DEEP)
"""Pillow's modes of images of numbers; others are of colours."""


def read_png(name: str, content: bytes, size: Size) -> Image.Image:
    """Return the decoded image of a mask's PNG.

    Raises BadInputError, naming ``name``, for another size or another kind of file.
    """
    with opened(name, io.BytesIO(content), "a mask in PNG") as image:
        if image.format != "PNG":
            raise BadInputError(f"{name}: expected a mask in PNG, got {image.format}")
        require_size(name, image.size, size)
        image.load()
    return image


def read_mask(name: str, content: bytes, size: Size) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """Return the values (H, W) of a mask's PNG: uint8 for 1 to 8 bits, uint16 for 16.

    Raises BadInputError as ``read_png`` does, and for an image of colours.
    """
    image = read_png(name, content, size)
    if image.mode not in PLAIN:
        raise BadInputError(
            f"{name}: expected a PNG with an index or a grey value for each pixel, got {image.mode}"
        )
    values = np.asarray(image)
    return values.astype(np.uint16) if image.mode in DEEP else values.astype(np.uint8)


def write_mask(mask: NDArray[np.uint16], colors: dict[int, str]) -> bytes:
    """Return a mask (H, W) as a PNG of 8-bit indices with the colours (#rrggbb) of its values.

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


def write_overlay(mask: NDArray[np.uint16], colors: Mapping[int, str]) -> bytes:
    """Return a mask (H, W) as a PNG to lay over the picture; values without a colour are clear."""
    table = np.zeros((1 << 16, 4), np.uint8)
    for value, color in colors.items():
        table[value] = [*bytes.fromhex(color[1:]), 255]
    out = io.BytesIO()
    Image.fromarray(table[mask], "RGBA").save(out, "PNG", compress_level=FASTEST)
    return out.getvalue()
