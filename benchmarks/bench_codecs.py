"""Ways to send a depth camera's frame: bytes a point, and a browser's milliseconds to decode them.

python benchmarks/bench_codecs.py

One frame of the sample recording in each codec that was considered, decoded by turns in headless
Chromium (the vertex codec by the project's own WebAssembly, deflate and JPEG by the browser).  For
a depth image "the points" are its depths and a bitmap of its colours, ready to upload.
"""

from __future__ import annotations

import base64
import io
import json
import statistics
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from chromium import ROOT, tab
from numpy.typing import NDArray
from PIL import Image

from pointbrush.samples import generate
from pointbrush.sequences.octree.order import morton_order, progressive
from pointbrush.sequences.wire.chunk import Grid, encode_chunk, wire_colors

STEP = 1 / 1024
"""Metres between two values of a coordinate, as for a room."""
QUALITY = 90
LATTICE = (8, 4, 2, 1)
"""Every eighth row and column first, then what lies between them."""
ROUNDS = 25
DECODER = ROOT / "webxr_client/node_modules/meshoptimizer/meshopt_decoder.mjs"

DECODE = """
async (parts, decoder) => {
  const { MeshoptDecoder } = await import(decoder);
  await MeshoptDecoder.ready;
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const inflate = async (data) => new Uint8Array(await new Response(
    new Blob([data]).stream().pipeThrough(new DecompressionStream('deflate'))).arrayBuffer());
  const unzigzag = (z) => (z >>> 1) ^ -(z & 1);
  const decoders = {
    plain: async ({ data }) => new Uint8Array(data.buffer),
    vertex: async ({ data, count }) =>
      MeshoptDecoder.decodeVertexBuffer(new Uint8Array(count * 12), count, 12, data),
    planes: async ({ data, count, words }) => {
      const planes = await inflate(data);
      const out = new Uint16Array(count * words);
      for (let lane = 0; lane < words; lane++) {
        const [low, high] = [2 * lane * count, (2 * lane + 1) * count];
        for (let i = 0, value = 0; i < count; i++) {
          value += unzigzag(planes[low + i] | (planes[high + i] << 8));
          out[i * words + lane] = value;
        }
      }
      return out;
    },
    picture: async ({ data }) => createImageBitmap(new Blob([data], { type: 'image/jpeg' })),
  };
  for (const part of parts) part.data = bytes(part.data);
  const began = performance.now();
  await Promise.all(parts.map((part) => decoders[part.codec](part)));
  return performance.now() - began;
}
"""


@dataclass(frozen=True, slots=True)
class Part:
    """Bytes for one of the page's decoders; ``words`` 16-bit values for each of ``count``."""

    codec: str
    data: bytes
    count: int = 0
    words: int = 1

    def sent(self) -> dict[str, Any]:
        """As the page takes it."""
        data = base64.b64encode(self.data).decode()
        return {"codec": self.codec, "data": data, "count": self.count, "words": self.words}


def planes(values: NDArray[np.uint16]) -> Part:
    """Differences (N, words) to the value before, low and high bytes apart, deflated."""
    steps = np.diff(values.T, axis=1, prepend=np.uint16(0))  # modulo 65536
    zigzag = (steps << 1) ^ (steps.view(np.int16) >> 15).view(np.uint16)
    split = np.stack([zigzag & 0xFF, zigzag >> 8], axis=1).astype(np.uint8)
    return Part("planes", zlib.compress(split.tobytes(), 6), len(values), values.shape[1])


def picture(colors: NDArray[np.uint8]) -> Part:
    """An image (H, W, 3) as JPEG with full chroma."""
    data = io.BytesIO()
    Image.fromarray(colors).save(data, "JPEG", quality=QUALITY, subsampling=0)
    return Part("picture", data.getvalue())


def lattice(height: int, width: int) -> Iterator[tuple[slice, slice]]:
    """Rows and columns of the images whose first ones are a coarser image."""
    yield slice(0, height, LATTICE[0]), slice(0, width, LATTICE[0])
    for step in LATTICE[1:]:
        for row, column in ((0, step), (step, 0), (step, step)):
            yield slice(row, height, 2 * step), slice(column, width, 2 * step)


def candidates() -> tuple[int, dict[str, list[Part]]]:
    """Number of points, and each codec's parts."""
    frame = next(iter(generate("juggling", frames=1).frames))
    assert frame.camera is not None
    assert frame.rgb is not None
    height, width, count = frame.camera.height, frame.camera.width, len(frame.xyz)
    depth = np.zeros(height * width, np.uint16)
    colors = np.zeros((height * width, 3), np.uint8)
    depth[frame.pixel], colors[frame.pixel] = np.rint(frame.xyz[:, 2] * 1000), frame.rgb
    depth, colors = depth.reshape(height, width), colors.reshape(height, width, 3)

    local = frame.xyz.astype(np.float32)
    order, first = progressive(morton_order(local))
    xyz, rgb = local[order], frame.rgb[order]
    grid = np.rint((xyz - xyz.min(axis=0)) / STEP).astype(np.uint16)
    red_green, blue = rgb[:, 0] | rgb[:, 1].astype(np.uint16) << 8, rgb[:, 2].astype(np.uint16)
    words = np.column_stack([grid, red_green, blue])
    of_colors, shared = wire_colors(rgb, None, None, count), Grid(np.zeros(3), STEP, None)
    chunks = [
        Part(
            "vertex",
            encode_chunk(xyz[start:stop], of_colors[start:stop], shared).data,
            stop - start,
        )
        for start, stop in pairwise(first)
    ]

    levels = list(lattice(height, width))
    return count, {
        "float32 positions, RGB": [Part("plain", xyz.tobytes() + rgb.tobytes())],
        "16-bit positions, RGB": [Part("plain", grid.tobytes() + rgb.tobytes())],
        "the same, differences, shuffled, deflate": [planes(words)],
        "vertex codec in levels that refine": chunks,
        "depth (deflate) and colours (JPEG), whole": [
            planes(depth.reshape(-1, 1)),
            picture(colors),
        ],
        "the same in levels that refine": [
            part
            for rows, columns in levels
            for part in (
                planes(np.ascontiguousarray(depth[rows, columns]).reshape(-1, 1)),
                picture(np.ascontiguousarray(colors[rows, columns])),
            )
        ],
    }


def main() -> None:
    count, codecs = candidates()
    module = base64.b64encode(DECODER.read_bytes()).decode()
    decoder = f"data:text/javascript;base64,{module}"
    times: dict[str, list[float]] = {name: [] for name in codecs}
    with tab() as page:
        page.run(f"window.decode = {DECODE}; 0")
        for counted in [False] + [True] * ROUNDS:
            for name, parts in codecs.items():
                sent = json.dumps([part.sent() for part in parts])
                took = page.run(f"window.decode({sent}, {json.dumps(decoder)})")
                if counted:
                    times[name].append(took)
    print(f"{count:,} points: bytes a point, milliseconds to decode (median of {ROUNDS})")
    for name, parts in codecs.items():
        nbytes = sum(len(part.data) for part in parts) / count
        print(f"  {name:42} {nbytes:6.2f} {statistics.median(times[name]):8.2f}")


if __name__ == "__main__":
    main()
