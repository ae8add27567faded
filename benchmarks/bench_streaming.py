"""Streaming: against a bare uvicorn WebSocket, four and a hundred viewers, poor links.

python benchmarks/bench_streaming.py [seeks|throughput|four|hundred|others|links]...

Throughput is measured with recordings of 45, 90 and 900 frames: 2.7 GB of temporary disk, and
1.2 GB of memory for the bare WebSocket, which has all its messages there.
"""

from __future__ import annotations

import asyncio
import contextlib
import dataclasses
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import uuid
from collections.abc import Iterator
from contextlib import AbstractContextManager, AsyncExitStack, contextmanager
from pathlib import Path

import httpx
import numpy as np

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from light_viewer import Drinker, LightViewer, Puller, connect_light  # noqa: E402

from pointbrush.frame import PointFrame  # noqa: E402
from pointbrush.sequences import RecordingInfo, import_frames, open_sequence  # noqa: E402
from pointbrush.sequences.storage.manifest import encode_manifest, read_manifest  # noqa: E402
from pointbrush.streaming.encoding import encode_depth, encode_frame  # noqa: E402
from tests.streaming.client import Viewer, viewer  # noqa: E402
from tests.streaming.shaping import shaped  # noqa: E402

POINTS, FRAMES, FPS = 217_088, 45, 30.0
LENGTHS = (45, 90, 900)
TURNS = 6
TOKEN = "a-token-for-the-benchmark"
SECONDS = 5.0
WARM = 0.5
"""Seconds after its start from which a viewer must be in time."""


def kinect(seed: int) -> PointFrame:
    """A 512 x 424 depth image of a wavy wall, unprojected, with colours that vary smoothly."""
    rng = np.random.default_rng(seed)
    v, u = np.mgrid[0:424, 0:512].reshape(2, -1)
    depth = 2.5 + 0.4 * np.sin(u / 60 + seed / 9) + 0.3 * np.cos(v / 45)
    depth += rng.normal(0, 0.0015, POINTS) * depth**2
    xyz = np.column_stack([(u - 256) * depth / 365, (v - 212) * depth / 365, depth])
    shade = 120 + 60 * np.sin(u / 40) + 40 * np.cos(v / 30)
    rgb = shade[:, None] + np.array([20, 0, -20]) + rng.normal(0, 6, (POINTS, 3))
    return PointFrame(xyz.astype(np.float32), rgb=rgb.clip(0, 255).astype(np.uint8))


WALL = kinect(0).xyz.reshape(424, 512, 3)


def recording(workspace: Path) -> Path:
    """Import the recording; distinct frames are few, as only their bytes matter."""
    made = [kinect(seed) for seed in range(9)]
    target = workspace / "sequences" / "kinect"
    frames = (made[i % len(made)] for i in range(FRAMES))
    import_frames(frames, target, RecordingInfo("kinect", "kinect", FPS))
    return target


@contextmanager
def running(*command: str) -> Iterator[str]:
    """A server in a process of its own; yields its URL."""
    process = subprocess.Popen(
        [sys.executable, *command], stdout=subprocess.PIPE, text=True, cwd=ROOT / "benchmarks"
    )
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        assert "ready at" in line, line
        yield line.split("ready at ")[1].split("/?")[0].strip()
    finally:
        process.terminate()
        process.wait(20)


def pointbrush(workspace: Path) -> AbstractContextManager[str]:
    """Our server."""
    return running(
        "-m", "pointbrush.cli", "serve", "--workspace", str(workspace), "--port", "0",
        "--token", TOKEN,
    )  # fmt: skip


def add_label(url: str) -> int:
    """Something new to paint with."""
    answer = httpx.post(
        f"{url}/api/v1/sequences/kinect/labels",
        json={"name": "pin"},
        headers={"Authorization": f"Bearer {TOKEN}"},
    )
    return int(answer.raise_for_status().json()["id"])


def longer(workspace: Path, frames: int) -> str:
    """A recording of so many frames, made of the first one's; returns its name.

    What is streamed lies on the disk once for each frame, so that a long recording is as much
    memory as it would be; what is not is the same files.
    """
    source, name = workspace / "sequences" / "kinect", f"kinect{frames}"
    target = workspace / "sequences" / name
    (target / "frames").mkdir(parents=True)
    sums = json.loads((source / "checksums.json").read_bytes())
    copied = {}
    for i in range(frames):
        for suffix, place in (("points", os.link), ("wire", shutil.copyfile)):
            old, new = f"frames/{i % FRAMES:06d}.{suffix}", f"frames/{i:06d}.{suffix}"
            place(source / old, target / new)
            copied[new] = sums[old]
    (target / "checksums.json").write_text(json.dumps(copied))
    manifest = read_manifest(source)
    each = {
        key: [value[i % FRAMES] for i in range(frames)]
        for key in ("points", "timestamps", "poses", "viewpoints")
        if len(value := getattr(manifest, key)) == FRAMES
    }
    manifest = dataclasses.replace(manifest, id=name, frames=frames, **each)
    (target / "manifest.json").write_bytes(encode_manifest(manifest))
    return name


async def pull(
    url: str, sequence: str, frames: int, seconds: float, *, depth: bool
) -> tuple[float, float]:
    """Complete frames and megabytes a second, one frame after the other as fast as they come.

    Counted from the second round on: that somebody has watched the recording is the usual case.
    """
    client = await connect_light(Puller, url, TOKEN)
    client.frames = frames
    client.send(type="hello", depth=depth)
    client.send(type="open", sequence=sequence)
    while client.done < frames:
        await asyncio.sleep(WARM / 10)
    start, done, nbytes = time.monotonic(), client.done, client.nbytes
    await asyncio.sleep(seconds)
    passed = time.monotonic() - start
    client.close()
    return (client.done - done) / passed, (client.nbytes - nbytes) / passed / 1e6


async def drink(url: str, seconds: float) -> float:
    """Megabytes a second that a bare socket pushes at the same client."""
    client = await connect_light(Drinker, url, "")
    await asyncio.sleep(WARM)
    nbytes = client.nbytes
    await asyncio.sleep(seconds)
    client.close()
    return (client.nbytes - nbytes) / seconds / 1e6


async def throughput(workspace: Path) -> None:
    """Our server against a bare one that sends the same bytes, in turns."""
    for frames in LENGTHS:
        sequence = longer(workspace, frames)
        await against_bare(workspace, sequence, frames, depth=False)
        await against_bare(workspace, sequence, frames, depth=True)
        shutil.rmtree(workspace / "sequences" / sequence)


async def against_bare(workspace: Path, name: str, frames: int, *, depth: bool) -> None:
    """One recording's throughput, and the bare one's, in turns."""
    sequence = open_sequence(workspace / "sequences" / name)
    encode = encode_depth if depth else encode_frame
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as messages:
        for i in range(frames):
            parts = encode(name, sequence[i], 0, len(sequence[i].chunks), final=True)
            Path(messages, f"{i:06d}").write_bytes(b"".join(parts))
        with contextlib.ExitStack() as servers:
            bare_url = servers.enter_context(running("bare_websocket.py", messages))
            shutil.rmtree(messages)
            our_url = servers.enter_context(pointbrush(workspace))
            ours, bare, rates = [], [], []
            for _ in range(TURNS):
                bare.append(await drink(bare_url, SECONDS / 2))
                rate, megabytes = await pull(our_url, name, frames, SECONDS / 2, depth=depth)
                rates.append(rate)
                ours.append(megabytes)
    ratio = statistics.median(o / b for o, b in zip(ours, bare, strict=True))
    print(
        f"throughput, {frames} frames{' as depth images' if depth else ''}: "
        f"{statistics.median(rates):.0f} frames/s, {statistics.median(ours):.0f} MB/s; "
        f"bare uvicorn {statistics.median(bare):.0f} MB/s; ratio {ratio:.2f}",
        flush=True,
    )


async def follow(client: Viewer, seconds: float) -> None:
    """Open, play, and read for a while."""
    await client.open("kinect")
    await client.until("frame")
    await client.send(type="play", frame=0)
    client.arrivals.clear()
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        try:
            await client.receive(left)
        except TimeoutError:
            return
        for frame in [f for f in client.frames if client.frames[f].points]:
            # A cache of one frame: every frame is sent again in every round.
            if frame != client.arrivals[-1][1] if client.arrivals else False:
                del client.frames[frame]
                await client.send(type="forget", frames=[frame])


def summary(clients: list[Viewer], seconds: float) -> str:
    """Frames a second of the slowest viewer, and points a frame."""
    rates = [len({(a[1], round(a[0] * 2)) for a in c.arrivals}) / seconds for c in clients]
    points = [a[2] for c in clients for a in c.arrivals]
    return (
        f"{min(rates):.1f} to {max(rates):.1f} frames/s, "
        f"median {statistics.median(points):,.0f} points a frame"
    )


async def several(url: str, count: int, seconds: float) -> list[Viewer]:
    """``count`` viewers of one playing recording."""
    async with AsyncExitStack() as stack:
        clients = [await stack.enter_async_context(viewer(url, TOKEN)) for _ in range(count)]
        await asyncio.gather(*(follow(client, seconds) for client in clients))
        return clients


async def four(workspace: Path) -> None:
    """Four viewers at 30 frames a second."""
    with pointbrush(workspace) as url:
        clients = await several(url, 4, SECONDS)
    print(f"four viewers: {summary(clients, SECONDS)}")


async def paint(url: str, seconds: float) -> list[float]:
    """Seconds from a stroke's end to its durable answer."""
    times, label = [], add_label(url)
    async with viewer(url, TOKEN) as client:
        await client.open("kinect")
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            _, start = await stroke(client, len(times), label)
            await client.until("stroke_result", final=True)
            times.append(time.perf_counter() - start)
            await asyncio.sleep(0.1)
    return times


async def painter(url: str, seconds: float) -> list[float]:
    """``paint`` in a process of its own: the crowd's event loop must not count."""
    process = await asyncio.create_subprocess_exec(
        sys.executable, __file__, "paint", url, str(seconds), stdout=asyncio.subprocess.PIPE
    )
    out, _ = await process.communicate()
    return [float(line) for line in out.split()]


async def crowd(url: str, count: int, seconds: float) -> list[LightViewer]:
    """``count`` light viewers that start playing in the same moment."""
    clients = [await connect_light(LightViewer, url, TOKEN) for _ in range(count)]
    for client in clients:
        client.send(type="open", sequence="kinect")
    await asyncio.sleep(1.0)
    for client in clients:
        client.arrivals.clear()
        client.started = time.monotonic()
        client.send(type="play", frame=0)
    await asyncio.sleep(seconds)
    for client in clients:
        client.close()
    return clients


async def hundred(workspace: Path) -> None:
    """A hundred followers of one recording, and somebody who paints meanwhile."""
    with pointbrush(workspace) as url:
        alone = await painter(url, 2)
        times, clients = await asyncio.gather(painter(url, SECONDS), crowd(url, 100, SECONDS))
    rates = [len(client.arrivals) / SECONDS for client in clients]
    skew = skews(clients)
    print(
        f"hundred viewers: {min(rates):.1f} to {max(rates):.1f} frames/s each, "
        f"{sum(c.nbytes for c in clients) / SECONDS / 1e6:.0f} MB/s together, "
        f"median {np.median([a[2] for c in clients for a in c.arrivals]):,.0f} bytes a frame; "
        f"behind the clock p50 {np.percentile(skew, 50):.2f} p95 {np.percentile(skew, 95):.2f} "
        f"intervals; stroke answer p50 "
        f"{1e3 * np.percentile(times, 50):.1f} p95 {1e3 * np.percentile(times, 95):.1f} ms "
        f"(alone {1e3 * np.percentile(alone, 50):.1f} and {1e3 * np.percentile(alone, 95):.1f})"
    )


async def others(workspace: Path) -> None:
    """From the end of a stroke until other people's viewers have its delta, and hands that move."""
    with pointbrush(workspace) as url:
        label = add_label(url)
        edits, hands = [], []
        async with AsyncExitStack() as stack:
            painter, *watchers = [
                await stack.enter_async_context(viewer(url, TOKEN)) for _ in range(5)
            ]
            for client in (painter, *watchers):
                await client.open("kinect")
                await client.until("frame", frame=0, final=True)
            for turn in range(60):
                edit, start = await stroke(painter, turn, label)
                edits += await asyncio.gather(
                    *(seen(client, start, "annotation", edit=edit) for client in watchers)
                )
                start = time.perf_counter()
                await painter.send(type="presence", frame=turn % FRAMES)
                hands += await asyncio.gather(
                    *(seen(client, start, "presence", frame=turn % FRAMES) for client in watchers)
                )
    for name, times in (("another's edit", edits), ("another's head and hands", hands)):
        p50, p95 = 1e3 * np.percentile(times, [50, 95])
        print(f"{name} at four others: p50 {p50:.0f} ms, p95 {p95:.0f} ms")


async def seen(client: Viewer, start: float, kind: str, **fields: object) -> float:
    """Seconds since ``start`` when the message is here."""
    await client.until(kind, **fields)
    return time.perf_counter() - start


async def stroke(client: Viewer, turn: int, label: int) -> tuple[str, float]:
    """A stroke of one sample on the wall; its id and the time of its end."""
    edit = str(uuid.uuid4())
    # Elsewhere than the last ones, so that there is always something to change.
    v, u = divmod(6 * turn, 480)
    origin = WALL[212 + 12 * v, 16 + u].tolist()
    await client.send(type="stroke_begin", id=edit, frame=0, brush={"label": label, "radius": 0.05})
    await client.send(type="stroke_samples", id=edit, samples=[{"origin": origin}])
    start = time.perf_counter()
    await client.send(type="stroke_end", id=edit)
    return edit, start


def skews(clients: list[LightViewer]) -> list[float]:
    """How far each viewer's picture is behind the clock that all follow, in frame intervals.

    A viewer shows a frame when it is due or, if that is later, when it arrives.
    """
    behind = []
    for client in clients:
        shown = sorted(
            (max(moment, client.started + step / FPS), step) for moment, step in steps(client)
        )
        times = np.array([moment for moment, _ in shown])
        newest = np.maximum.accumulate([step for _, step in shown])
        grid = np.arange(client.started + WARM, client.arrivals[-1][0], 0.5 / FPS)
        at = np.searchsorted(times, grid, side="right") - 1
        due = (grid - client.started) * FPS
        behind += np.maximum(0, due - newest[at] - 1).tolist()
    return behind


def steps(client: LightViewer) -> Iterator[tuple[float, int]]:
    """Time and number of each frame since the start.

    A number stands for the round in which it is nearest to what was due when it came: a viewer is
    never half a recording behind, and what was still on its way from before the start counts
    for little.
    """
    for moment, frame, _ in client.arrivals:
        due = (moment - client.started) * FPS
        yield moment, frame + FRAMES * round((due - frame) / FRAMES)


async def links(workspace: Path) -> None:
    """One viewer behind a link of 5, 20 and 100 Mbit/s."""
    with pointbrush(workspace) as url:
        for megabits in (5, 20, 100):
            async with shaped(url, megabits * 1e6) as slow:
                clients = await several(slow, 1, 2 * SECONDS)
            used = clients[0].nbytes * 8 / (2 * SECONDS) / 1e6
            print(f"{megabits} Mbit/s: {summary(clients, 2 * SECONDS)}; {used:.1f} Mbit/s used")


async def seeks(workspace: Path) -> None:
    """From opening, and from seeking to a frame that is not here, to its first level and to all."""
    opened, first, full = [], [], []
    with pointbrush(workspace) as url:
        for turn in range(40):
            async with viewer(url, TOKEN) as client:
                start = time.perf_counter()
                await client.open("kinect", frame=turn)
                await client.until("frame", frame=turn)
                opened.append(time.perf_counter() - start)
                target = (turn + 20) % FRAMES
                start = time.perf_counter()
                await client.send(type="seek", frame=target)
                await client.until("frame", frame=target)
                first.append(time.perf_counter() - start)
                while not client.frames[target].final:
                    await client.receive()
                full.append(time.perf_counter() - start)
    for name, times in (("open", opened), ("seek, first level", first), ("seek, all", full)):
        p50, p95 = 1e3 * np.percentile(times, [50, 95])
        print(f"{name}: p50 {p50:.0f} ms, p95 {p95:.0f} ms")


PARTS = {part.__name__: part for part in (seeks, throughput, four, hundred, others, links)}


def main() -> None:
    """Run the parts asked for, or all."""
    if sys.argv[1:2] == ["paint"]:
        print(*asyncio.run(paint(sys.argv[2], float(sys.argv[3]))))
        return
    with tempfile.TemporaryDirectory() as folder:
        workspace = Path(folder) / "workspace"
        recording(workspace)
        for name in sys.argv[1:] or PARTS:
            asyncio.run(PARTS[name](workspace))


if __name__ == "__main__":
    main()
