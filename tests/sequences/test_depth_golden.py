"""Bytes of two small depth images that the page's tests decode too.

``python tests/sequences/test_depth_golden.py`` writes them anew after a deliberate change.
"""

from __future__ import annotations

import base64
import io
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pointbrush.frame import PointFrame
from pointbrush.sequences.columns import encode_frame
from pointbrush.sequences.depth.lattice import Lattice
from pointbrush.sequences.wire.chunk import Grid
from tests.sequences.depth_decoder import decode_depth, unproject

GOLDEN = Path(__file__).parents[1] / "golden"
LATTICE = Lattice(
    width=96,
    height=72,
    axis=2,
    sign=1.0,
    tangent=(-0.5, -0.375),
    pitch=(1 / 96, 1 / 96),
    eye=(0.25, 0.0, -0.5),
    unit=0.001,
)

STEPS = {"fine": 1, "coarse": 7}
"""Units from one depth of a sensor to the next: those of the coarse one are listed."""


def small_frame(step: int) -> PointFrame:
    """A ball before a rough wall, with holes; in integers so that no platform rounds otherwise."""
    number = np.arange(LATTICE.width * LATTICE.height)
    x, y = number % LATTICE.width - 48, number // LATTICE.width - 30
    noise = (number * 2654435761 >> 9) % 23
    ball = x * x + y * y < 400
    depth = np.where(ball, 800 + (x * x + y * y) // 4, 2000 + 6 * x + noise) // step * step
    seen = (number % 89 != 0) & ((x + y) % 61 > 2)
    rgb = np.stack([128 + x, np.where(ball, 200, 90) + noise, 128 - y], axis=1).astype(np.uint8)
    xyz = unproject(LATTICE, number[seen], depth[seen]).astype(np.float32)
    return PointFrame(xyz, rgb[seen])


def content(step: int) -> tuple[bytes, dict[str, Any]]:
    encoded = encode_frame(small_frame(step), Grid(np.zeros(3), 2.0**-10, None, lattice=LATTICE))
    xyz, ends = encoded.arrays["xyz"], encoded.arrays["depth_ends"]
    table = encoded.arrays["chunks"]
    start = len(encoded.wire) - int(ends[-1] - (table["offset"] + table["nbytes"])[-1])
    starts = [start, *ends[:-1].tolist()]
    chunks = [
        {
            "index": index,
            "offset": starts[index] - start,
            "nbytes": int(ends[index]) - starts[index],
            **{name: row[name].tolist() for name in ("level", "first", "count", "lo", "hi")},
        }
        for index, row in enumerate(table)
    ]
    data = encoded.wire[start:]
    pixels, pictures = decode_depth(LATTICE, parts_of(data, chunks))
    decoded = {size: picture(jpeg) for size, jpeg in pictures.items()}
    return data, {
        "lattice": asdict(LATTICE),
        "lo": xyz.min(axis=0).tolist(),
        "hi": xyz.max(axis=0).tolist(),
        "position_error": max(encoded.error, encoded.side_error + 1e-5),
        "count": len(xyz),
        "chunks": chunks,
        "xyz_base64": base64.b64encode(xyz.astype("<f4").tobytes()).decode(),
        "pixels": pixels.pixel.tolist(),
        "pictures": [
            {
                "width": shown.shape[1],
                "nbytes": len(pictures[size]),
                "rgb_base64": base64.b64encode(shown.tobytes()).decode(),
            }
            for size, shown in decoded.items()
        ],
    }


def parts_of(data: bytes, chunks: list[dict[str, Any]]) -> list[bytes]:
    return [data[chunk["offset"] : chunk["offset"] + chunk["nbytes"]] for chunk in chunks]


def picture(jpeg: bytes) -> NDArray[np.uint8]:
    return np.asarray(Image.open(io.BytesIO(jpeg)).convert("RGB"))


def without_picture(chunk: bytes) -> bytes:
    return chunk[4:12] + chunk[12 + int.from_bytes(chunk[:4], "little") :]


def test_golden_depth_is_what_we_encode_but_for_the_pictures_of_other_jpeg_libraries() -> None:
    for name, step in STEPS.items():
        kept = (GOLDEN / f"depth_{name}.bin").read_bytes()
        described = json.loads((GOLDEN / f"depth_{name}.json").read_text())
        data, description = content(step)
        ours = map(without_picture, parts_of(data, description["chunks"]))
        theirs = map(without_picture, parts_of(kept, described["chunks"]))
        assert list(ours) == list(theirs)
        assert description["xyz_base64"] == described["xyz_base64"]


def test_golden_depth_says_every_point_within_its_error() -> None:
    for name, step in STEPS.items():
        described = json.loads((GOLDEN / f"depth_{name}.json").read_text())
        data = (GOLDEN / f"depth_{name}.bin").read_bytes()
        pixels, pictures = decode_depth(LATTICE, parts_of(data, described["chunks"]))
        xyz = np.frombuffer(base64.b64decode(described["xyz_base64"]), "<f4").reshape(-1, 3)
        frame = small_frame(step)
        assert len(pixels.pixel) == len(frame)
        found = unproject(LATTICE, pixels.pixel, pixels.depth)
        assert np.abs(found - xyz).max() <= described["position_error"]
        assert sorted(map(tuple, xyz.tolist())) == sorted(map(tuple, frame.xyz.tolist()))
        assert set(pictures) == {1, 2}


if __name__ == "__main__":
    for name, step in STEPS.items():
        data, text = content(step)
        (GOLDEN / f"depth_{name}.bin").write_bytes(data)
        (GOLDEN / f"depth_{name}.json").write_text(json.dumps(text) + "\n")
