"""What a viewer costs the server in memory: those who follow, and those who stop reading.

python benchmarks/bench_memory.py [--viewers 100]

The server has a Kinect recording. Resident memory is read once one viewer has had every frame,
while many follow it at 30 frames a second, and while as many have stopped reading and somebody
paints: what waits for them is theirs alone.
"""

from __future__ import annotations

import argparse
import asyncio
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from bench_large import resident
from bench_streaming import FRAMES, TOKEN, paint, pointbrush, recording
from light_viewer import LightViewer, Puller, connect_light

SECONDS = 8.0


async def watched(seconds: float) -> float:
    """The server's greatest resident memory in the next seconds, MiB."""
    most, end = 0.0, time.monotonic() + seconds
    while time.monotonic() < end:
        most = max(most, resident("VmRSS"))
        await asyncio.sleep(0.1)
    return most


async def followers(url: str, count: int) -> list[LightViewer]:
    clients = [await connect_light(LightViewer, url, TOKEN) for _ in range(count)]
    for client in clients:
        client.send(type="open", sequence="kinect")
        client.send(type="play", frame=0)
    return clients


async def alone(url: str) -> float:
    """One viewer has had every frame: what all share is there."""
    client = await connect_light(Puller, url, TOKEN)
    client.frames = FRAMES
    client.send(type="open", sequence="kinect")
    most = await watched(SECONDS)
    client.close()
    return most


async def following(url: str, count: int) -> float:
    clients = await followers(url, count)
    most = await watched(SECONDS)
    for client in clients:
        client.close()
    return most


async def stalled(url: str, count: int) -> float:
    clients = await followers(url, count)
    await asyncio.sleep(1.0)
    for client in clients:
        client.stop_reading()
    painting = asyncio.create_task(paint(url, SECONDS))
    most = await watched(SECONDS)
    strokes = len(await painting)
    for client in clients:
        client.close()
    print(f"  ({strokes} strokes meanwhile)")
    return most


async def measure(url: str, count: int) -> None:
    base = await alone(url)
    print(f"memory of the server: {base:.0f} MiB with one viewer who has had every frame")
    for what, run in (("follow", following), ("do not read", stalled)):
        most = await run(url, count)
        each = (most - base) / count
        print(f"  {count} viewers who {what}: {most:.0f} MiB, {each:.2f} MiB each")


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--viewers", type=int, default=100)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        workspace = Path(folder) / "workspace"
        recording(workspace)
        with pointbrush(workspace) as url:
            asyncio.run(measure(url, given.viewers))


if __name__ == "__main__":
    main()
