"""Long strokes over one socket, and what somebody else waits meanwhile.

python benchmarks/bench_long_strokes.py [--strokes 30] [--samples 4000]

One person sends strokes of thousands of samples of each shape at once, on a Kinect frame; another
one paints short strokes on another frame.  Printed: seconds until the last long stroke is durable,
and the short strokes' times from end to answer.
"""

from __future__ import annotations

import argparse
import asyncio
import sys
import tempfile
import time
import uuid
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1]))

from bench_streaming import TOKEN, add_label, pointbrush, recording

from tests.streaming.client import Viewer, viewer

SHAPES = ("ray", "grow", "plane")


async def send_long(client: Viewer, label: int, shape: str, samples: int) -> str:
    """Send a whole stroke at once; returns its id."""
    t = np.linspace(0, 1, samples)
    way = np.column_stack([0.5 * t - 0.25, 0.2 * np.sin(20 * t), np.ones(samples)])
    rays = [{"origin": [0.0, 0.0, 0.0], "direction": row} for row in way.tolist()]
    stroke = str(uuid.uuid4())
    brush = {"label": label, "shape": shape, "radius": 0.05}
    await client.send(type="stroke_begin", id=stroke, frame=0, brush=brush)
    await client.send(type="stroke_samples", id=stroke, samples=rays)
    await client.send(type="stroke_end", id=stroke)
    return stroke


async def short(client: Viewer, label: int) -> float:
    """Seconds from a short stroke's end to its answer."""
    stroke = str(uuid.uuid4())
    brush = {"label": label, "shape": "ray", "radius": 0.05}
    await client.send(type="stroke_begin", id=stroke, frame=1, brush=brush)
    sample = {"origin": [0.0, 0.0, 0.0], "direction": [0.0, 0.0, 1.0]}
    await client.send(type="stroke_samples", id=stroke, samples=[sample])
    begun = time.perf_counter()
    await client.send(type="stroke_end", id=stroke)
    await client.until("stroke_result", timeout=600, final=True, id=stroke)
    return time.perf_counter() - begun


async def measure(url: str, strokes: int, samples: int) -> None:
    """Print a line for each shape."""
    for shape in SHAPES:
        mine, theirs = add_label(url), add_label(url)
        async with viewer(url, TOKEN) as painter, viewer(url, TOKEN) as other:
            await painter.open("kinect", frame=0)
            await other.open("kinect", frame=1)
            begun, waits = time.perf_counter(), []
            sent = [await send_long(painter, mine, shape, samples) for _ in range(strokes)]
            last = asyncio.create_task(
                painter.until("stroke_result", timeout=600, final=True, id=sent[-1])
            )
            while not last.done():
                waits.append(await short(other, theirs))
            await last
            taken = time.perf_counter() - begun
            p50, p95 = np.percentile(waits, [50, 95]) * 1000
            print(
                f"  {shape:6} {strokes} strokes of {samples:,} samples: {taken:5.1f} s; "
                f"{len(waits)} short strokes of somebody else, {p50:.0f} ms p50, {p95:.0f} ms p95",
                flush=True,
            )


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--strokes", type=int, default=30)
    parser.add_argument("--samples", type=int, default=4000)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        workspace = Path(folder) / "workspace"
        recording(workspace)
        with pointbrush(workspace) as url:
            asyncio.run(measure(url, given.strokes, given.samples))


if __name__ == "__main__":
    main()
