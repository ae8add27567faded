"""A scan larger than a page or the server may hold: its first picture, and many who look about.

python benchmarks/bench_large.py [FOLDER] [--viewers 40] [--seconds 20]

``FOLDER`` is what ``bench_import.py --points N --keep FOLDER`` has left; without it a scan of 5 M
points is made.  Printed are the time to the page's first picture, and the server's memory while
every viewer asks for chunks from all over the scan, and while the annotation is read and replaced.
"""

from __future__ import annotations

import argparse
import asyncio
import io
import os
import random
import statistics
import sys
import tempfile
import time
from pathlib import Path

import httpx
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from bench_import import run_child, write_scan
from bench_page import FIRST, SETTLED
from bench_streaming import TOKEN, pointbrush
from chromium import tab
from light_viewer import LightViewer, connect_light

POINTS = 5_000_000
WISH = 16
"""Chunks asked for at once."""
RELABELLED = 1_000_000
OPENINGS = 5


class Wanderer(LightViewer):
    """Asks for chunks of the one frame, anywhere in it, again and again."""

    chunks = 1

    def frame(self, number: int, _final: bool, length: int) -> None:
        self.send(type="credit", frames=1, nbytes=length)
        wanted = random.sample(range(self.chunks), min(WISH, self.chunks))
        self.send(type="want", frame=number, chunks=wanted)


def server() -> int:
    """The process of the one server that runs below this one."""
    children = Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
    (found,) = [
        int(child)
        for child in children
        if b"pointbrush.cli" in Path(f"/proc/{child}/cmdline").read_bytes()
    ]
    return found


def resident(what: str) -> float:
    """MiB of the server, files included: ``VmRSS`` now, ``VmHWM`` at most so far."""
    lines = Path(f"/proc/{server()}/status").read_text().splitlines()
    (found,) = [int(line.split()[1]) for line in lines if line.startswith(what)]
    return found / 1024


def memory() -> str:
    """What the server takes."""
    return f"{resident('VmRSS'):.0f} MiB, {resident('VmHWM'):.0f} at most so far"


def pictures(url: str) -> None:
    """From the page's address to its first points, in a browser that has never seen the page."""
    times = []
    for _ in range(OPENINGS):
        with tab() as page:
            time.sleep(SETTLED)
            page.open(f"{url}/?token={TOKEN}", FIRST)
            page.until("!!window.pointsAt")
            times.append(page.run("window.pointsAt") / 1000)
    print(
        f"  first picture {statistics.median(times):.2f} s ({min(times):.2f} to {max(times):.2f})"
    )


async def wander(url: str, viewers: int, seconds: float, chunks: int) -> None:
    """Many viewers, each somewhere else all the time."""
    Wanderer.chunks = chunks
    clients = [await connect_light(Wanderer, url, TOKEN) for _ in range(viewers)]
    for client in clients:
        client.send(type="open", sequence="scan")
    await asyncio.sleep(seconds)
    megabytes = sum(client.nbytes for client in clients) / seconds / 1e6
    for client in clients:
        client.close()
    print(f"  {viewers} viewers, {megabytes:.0f} MB/s together: {memory()}")


def annotate(url: str, points: int) -> None:
    """Read the whole annotation, and put it back with a million points changed."""
    path = f"{url}/api/v1/sequences/scan"
    with httpx.Client(headers={"Authorization": f"Bearer {TOKEN}"}, timeout=600) as client:
        label = client.post(f"{path}/labels", json={"name": "one"}).raise_for_status().json()["id"]
        start = time.monotonic()
        answer = client.get(f"{path}/frames/0/annotation").raise_for_status()
        print(f"  annotation read in {time.monotonic() - start:.1f} s: {memory()}")
        values = np.load(io.BytesIO(answer.content))
        values[points // 2 : points // 2 + RELABELLED] = label
        body = io.BytesIO()
        np.save(body, values)
        start = time.monotonic()
        client.put(f"{path}/frames/0/annotation", content=body.getvalue()).raise_for_status()
        print(f"  {RELABELLED:,} points put in {time.monotonic() - start:.1f} s: {memory()}")


def change_everything(url: str) -> None:
    """Edits of the whole scan: painted by one ball, put with mixed labels, undone and redone."""
    path = f"{url}/api/v1/sequences/scan"
    with httpx.Client(headers={"Authorization": f"Bearer {TOKEN}"}, timeout=3600) as client:
        label = client.post(f"{path}/labels", json={"name": "all"}).raise_for_status().json()["id"]
        about = client.get(path).raise_for_status().json()
        lo, hi = (np.array(about["bounds"][corner]) for corner in ("lo", "hi"))
        middle, radius = ((lo + hi) / 2).tolist(), float(np.linalg.norm(hi - lo) / 2)
        stroke = {
            "label": label, "shape": "sphere", "radius": radius, "samples": [{"origin": middle}]
        }  # fmt: skip
        values = np.random.default_rng(1).integers(0, label + 1, sum(about["points"]))
        body = io.BytesIO()
        np.save(body, values.astype(np.uint16))
        del values
        for what, send in {
            "a ball round everything painted": lambda: client.post(
                f"{path}/frames/0/strokes", json=stroke
            ),
            "labels at random put": lambda: client.put(
                f"{path}/frames/0/annotation", content=body.getvalue()
            ),
            "undone": lambda: client.post(f"{path}/undo"),
            "redone": lambda: client.post(f"{path}/redo"),
            "a label deleted": lambda: client.delete(f"{path}/labels/{label}"),
        }.items():
            start = time.monotonic()
            send().raise_for_status()
            print(f"  {what} in {time.monotonic() - start:.0f} s: {memory()}", flush=True)


def measure(workspace: Path, viewers: int, seconds: float) -> None:
    with pointbrush(workspace) as url:
        headers = {"Authorization": f"Bearer {TOKEN}"}
        table = httpx.get(f"{url}/api/v1/sequences/scan/frames/0/chunks", headers=headers).json()
        print(f"large: {table['points']:,} points, {len(table['chunks']):,} chunks; {memory()}")
        pictures(url)
        asyncio.run(wander(url, viewers, seconds, len(table["chunks"])))
        annotate(url, table["points"])
        change_everything(url)


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("--viewers", type=int, default=40)
    parser.add_argument("--seconds", type=float, default=20)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as made:
        workspace = (given.folder or Path(made)) / "workspace"
        if given.folder is None:
            scan = Path(made) / "scan.las"
            write_scan(scan, POINTS)
            run_child("--import", str(scan), str(workspace / "sequences/scan"))
        measure(workspace, given.viewers, given.seconds)


if __name__ == "__main__":
    main()
