"""Memory of the server while many people paint, minute by minute.

python benchmarks/bench_annotators.py [--people 50] [--minutes 10]

Each annotator sends a short stroke every two to five seconds somewhere in a Kinect recording, over
a socket of their own.  Resident memory is printed by its kind: what the server made (anonymous),
and files that it maps, which the system takes back when it needs room.  Goal: after the first
minute what the server made grows by less than 50 MiB.
"""

from __future__ import annotations

import argparse
import asyncio
import random
import sys
import tempfile
import time
import uuid
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from bench_large import resident
from bench_streaming import FRAMES, TOKEN, add_label, pointbrush, recording
from light_viewer import LightViewer, connect_light

PAUSE = (2.0, 5.0)
"""Seconds between two strokes of one annotator."""


async def annotator(url: str, label: int, end: float, seed: int) -> int:
    """Paint until ``end``; returns the number of strokes sent."""
    dice, strokes = random.Random(seed), 0
    client = await connect_light(LightViewer, url, TOKEN)
    client.send(type="hello", name=f"annotator {seed}")
    client.send(type="open", sequence="kinect")
    while time.monotonic() < end:
        await asyncio.sleep(dice.uniform(*PAUSE))
        stroke, frame = str(uuid.UUID(int=dice.getrandbits(128), version=4)), dice.randrange(FRAMES)
        way = [dice.uniform(-0.3, 0.3), dice.uniform(-0.3, 0.3), 1.0]
        brush = {"label": label, "shape": "ray", "radius": 0.05}
        sample = {"origin": [0.0, 0.0, 0.0], "direction": way}
        client.send(type="seek", frame=frame)
        client.send(type="stroke_begin", id=stroke, frame=frame, brush=brush)
        client.send(type="stroke_samples", id=stroke, samples=[sample])
        client.send(type="stroke_end", id=stroke)
        strokes += 1
    client.close()
    return strokes


async def measure(url: str, people: int, minutes: int) -> None:
    """Print a line a minute."""
    label, begun = add_label(url), time.monotonic()
    work = [
        asyncio.create_task(annotator(url, label, begun + 60 * minutes, seed))
        for seed in range(people)
    ]
    for minute in range(minutes + 1):
        await asyncio.sleep(max(0.0, begun + 60 * minute - time.monotonic()))
        made, mapped = resident("RssAnon"), resident("RssFile")
        print(f"  minute {minute:2}: {made:6.0f} MiB made, {mapped:6.0f} MiB of files", flush=True)
    strokes = sum(await asyncio.gather(*work))
    print(f"  {strokes} strokes of {people} annotators in {minutes} minutes")


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--people", type=int, default=50)
    parser.add_argument("--minutes", type=int, default=10)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        workspace = Path(folder) / "workspace"
        recording(workspace)
        with pointbrush(workspace) as url:
            asyncio.run(measure(url, given.people, given.minutes))


if __name__ == "__main__":
    main()
