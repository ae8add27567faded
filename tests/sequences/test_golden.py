"""Bytes of a small frame that the page's tests decode too (webxr_client reads the same files).

``python tests/sequences/test_golden.py`` writes them anew after a deliberate change.
"""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np

from pointbrush.frame import PointFrame
from pointbrush.sequences.columns import encode_frame
from pointbrush.sequences.octree.quantise import ROOM_STEP
from pointbrush.sequences.wire.chunk import Grid
from tests.sequences.vertex_decoder import decode_points, dequantise

GOLDEN = Path(__file__).parents[1] / "golden"


def small_frame() -> PointFrame:
    """9,000 points of a rough bowl, in integers so that no platform rounds otherwise."""
    number = np.arange(9000, dtype=np.int64)
    x, z = number % 100 - 50, number // 100 - 45
    noise = (number * 2654435761 >> 7) % 17
    y = (x * x + z * z) // 40 + noise
    xyz = np.stack([x * 8, y * 4, z * 8], axis=1).astype(np.float32) / np.float32(512)
    shade = 2 * y + noise * 9  # common to the colours, so that differences to green are sent
    rgb = np.stack([shade + x, shade, shade - z], axis=1).astype(np.uint8)
    return PointFrame(xyz, rgb, intensity=(number % 256).astype(np.float32))


def content() -> tuple[bytes, dict[str, Any]]:
    encoded = encode_frame(small_frame(), Grid(np.zeros(3), ROOM_STEP, (0.0, 255.0)))
    names = encoded.arrays["chunks"].dtype.names
    assert names is not None
    chunks = [
        {"index": index, **{name: row[name].tolist() for name in names}}
        for index, row in enumerate(encoded.arrays["chunks"])
    ]
    decoded = [
        decode_points(encoded.wire[c["offset"] : c["offset"] + c["nbytes"]], c["count"])
        for c in chunks
    ]
    vertices = np.concatenate(decoded)
    return encoded.wire, {
        "count": len(vertices),
        "stride": 12,
        "position_error": encoded.error,
        "chunks": chunks,
        "decoded_base64": base64.b64encode(vertices.tobytes()).decode(),
        "first_positions": encoded.arrays["xyz"][:8].tolist(),
    }


def test_golden_bytes_are_what_we_encode() -> None:
    wire, description = content()
    assert (GOLDEN / "frame_small.bin").read_bytes() == wire
    assert json.loads((GOLDEN / "frame_small.json").read_text()) == description


def test_golden_positions_are_within_their_error() -> None:
    wire, description = content()
    chunk = description["chunks"][0]
    vertices = decode_points(wire[: chunk["nbytes"]], chunk["count"])
    q = np.ascontiguousarray(vertices[:8, :6]).view(np.uint16)
    positions = dequantise(q, np.array(chunk["origin"]), np.array(chunk["scale"]))
    difference = np.abs(positions - np.array(description["first_positions"]))
    assert difference.max() <= description["position_error"]


if __name__ == "__main__":
    data, text = content()
    (GOLDEN / "frame_small.bin").write_bytes(data)
    (GOLDEN / "frame_small.json").write_text(json.dumps(text, indent=1) + "\n")
