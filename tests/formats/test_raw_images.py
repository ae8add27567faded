"""Raw pictures of ROS: every encoding gives the colours that were taken."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.ros.raw_images import DECODERS, RawImage, pixels_of

HEIGHT, WIDTH = 6, 8
COLOR = (200, 90, 40)
# Of COLOR by ITU-R BT.601 in video range: Y, U, V.
YUV = (117, 90, 180)


def picture(encoding: str, rows: NDArray[np.uint8], *, big: bool = False) -> NDArray[np.uint8]:
    """Decode rows (HEIGHT, bytes), padded as drivers do."""
    padded = np.pad(rows, ((0, 0), (0, 5)))
    image = RawImage(encoding, HEIGHT, WIDTH, padded.shape[1], big, padded.tobytes())
    return pixels_of("topic", image)


@pytest.mark.parametrize(
    ("encoding", "values"),
    [
        ("rgb8", COLOR),
        ("bgr8", COLOR[::-1]),
        ("8uc3", COLOR[::-1]),
        ("rgba8", (*COLOR, 7)),
        ("bgra8", (*COLOR[::-1], 7)),
    ],
)
def test_channels_in_any_order(encoding: str, values: tuple[int, ...]) -> None:
    rows = np.tile(np.array(values, np.uint8), (HEIGHT, WIDTH))
    made = picture(encoding, rows)
    assert made.shape == (HEIGHT, WIDTH, 3)
    assert (made == COLOR).all()


@pytest.mark.parametrize("big", [False, True])
def test_16_bits_keep_their_upper_half(big: bool) -> None:
    kind = ">u2" if big else "<u2"
    grey = np.arange(HEIGHT * WIDTH).reshape(HEIGHT, WIDTH) * 1000 + 300
    rows = grey.astype(kind).view(np.uint8)
    assert np.array_equal(picture("mono16", rows, big=big), grey // 256)
    rows = np.tile(np.array([value * 256 + 9 for value in COLOR], kind), (HEIGHT, WIDTH))
    assert (picture("rgb16", rows.view(np.uint8), big=big) == COLOR).all()


@pytest.mark.parametrize("pattern", ["rggb", "bggr", "gbrg", "grbg"])
def test_bayer_mosaics(pattern: str) -> None:
    rows = np.empty((HEIGHT, WIDTH), np.uint8)
    for place, letter in enumerate(pattern):
        rows[place // 2 :: 2, place % 2 :: 2] = COLOR["rgb".index(letter)]
    assert (picture(f"bayer_{pattern}8", rows) == COLOR).all()


@pytest.mark.parametrize(
    ("encoding", "order"), [("yuv422", "uyvy"), ("uyvy", "uyvy"), ("yuv422_yuy2", "yuyv")]
)
def test_yuv_422(encoding: str, order: str) -> None:
    values = [YUV["yuv".index(letter)] for letter in order]
    made = picture(encoding, np.tile(np.array(values, np.uint8), (HEIGHT, WIDTH // 2)))
    assert np.abs(made.astype(int) - COLOR).max() <= 2


@pytest.mark.parametrize("encoding", sorted(DECODERS))
def test_too_few_bytes_are_refused(encoding: str) -> None:
    for step, data in ((WIDTH - 1, bytes(1000)), (64, bytes(63)), (0, b"")):
        with pytest.raises(BadInputError, match="topic: expected 6 rows of 8 pixels"):
            pixels_of("topic", RawImage(encoding, HEIGHT, WIDTH, step, False, data))
