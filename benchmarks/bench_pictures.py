"""Pictures: how many a second at the desk and in the headset, what the loop allocates, memory.

python benchmarks/bench_pictures.py [desk|headset]...

Frames of 217 k and 1 M points, all of them drawn, with the camera turning or the head and hands
moving.  "Drawn" uses this machine's GPU, which may be a program; "undrawn" leaves out the calls
that draw and clear, and is what the page itself can keep up with.  "In time" is what the budget of
points makes of it.  Allocations are sampled by V8, those that were collected included.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from allocations import allocations
from bench_headset import IWER, SWAY, WEAR
from bench_page import COMPLETE, UNDRAWN
from bench_streaming import TOKEN, kinect, pointbrush
from chromium import Tab, tab

from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames

SIZES = (217_088, 1_000_000)
FRAMES = 3
SECONDS = 5.0
TURN = """
__pointbrush.engine.viewer.ticks.push(() => {
  __pointbrush.engine.camera.turn(1, 0);
  __pointbrush.engine.viewer.invalidate();
})
"""
SAMPLED = 3.0


def recording(workspace: Path, points: int) -> None:
    """Frames of ``points`` points: as many walls side by side as it takes."""
    walls = -(-points // len(kinect(0)))
    target = workspace / "sequences" / f"walls-{points}"

    def frame(seed: int) -> PointFrame:
        parts = [kinect(seed + 9 * wall) for wall in range(walls)]
        shift = np.array([3.4, 0, 0], np.float32)
        xyz = np.concatenate([part.xyz + i * shift for i, part in enumerate(parts)])
        rgb = np.concatenate([part.rgb for part in parts if part.rgb is not None])
        return PointFrame(xyz[:points], rgb=rgb[:points])

    import_frames(
        (frame(seed) for seed in range(FRAMES)), target, RecordingInfo(target.name, "", 30.0)
    )


@contextmanager
def page_on(workspace: Path, headset: bool, first: str = "") -> Iterator[tuple[Tab, int]]:
    """A page on the recording, in motion; and the number of its browser's process."""
    with pointbrush(workspace) as url, tab() as page:
        page.open(f"{url}/?token={TOKEN}", (IWER.read_text() + WEAR if headset else "") + first)
        page.until(COMPLETE)
        page.run("__pointbrush.setAdaptive(false)")
        if headset:
            page.until("__pointbrush.state.xr.value.supported === true")
            page.run("__pointbrushHeadset.headset.enter()")
            page.until("__pointbrushHeadset.frames() > 3")
        page.run(SWAY if headset else TURN)
        yield page, page.process


def rate(page: Tab) -> tuple[float, float, int]:
    """Pictures a second, the page's own milliseconds for each, points drawn."""
    time.sleep(1.5)
    page.run("__pointbrush.resetTiming()")
    time.sleep(SECONDS)
    timing = page.run("__pointbrush.timing()")
    own = statistics.median(timing["work"]) + statistics.median(timing["draw"])
    drawn: int = page.run("__pointbrush.shown().drawn")
    return 1000 / statistics.mean(timing["interval"]), own, drawn


def report(page: Tab, what: str) -> None:
    """Print the bytes that a picture allocates."""
    shares = allocations(page, "__pointbrush.counters().pictures", SAMPLED)
    sizes = [
        f"{party} {share.objects:.0f} + {share.numbers:.0f}"
        for party, share in shares.items()
        if party != "emulator"
    ]
    print(f"    {what}: bytes a picture, objects + boxed numbers: {', '.join(sizes)}")


def memory(page: Tab, browser: int) -> str:
    """What one viewer holds on its own machine."""
    page.call("HeapProfiler.collectGarbage")
    heap = page.call("Runtime.getHeapUsage")["usedSize"]
    cached = page.run("__pointbrush.counters().cachedBytes")
    return (
        f"script heap {heap / 2**20:.0f} MiB, cached frames {cached / 2**20:.0f} MiB, "
        f"renderer process {resident(browser, 'renderer') / 2**20:.0f} MiB"
    )


def resident(browser: int, kind: str) -> int:
    """Resident bytes of the browser's largest process of a kind."""
    found = 0
    for status in Path("/proc").glob("[0-9]*/status"):
        try:
            command = (status.parent / "cmdline").read_text()
            if f"--type={kind}" not in command or group(status.parent) != browser:
                continue
            lines = dict(line.split(":", 1) for line in status.read_text().splitlines())
            found = max(found, 1024 * int(lines["VmRSS"].split()[0]))
        except (OSError, KeyError):
            continue
    return found


def group(process: Path) -> int:
    """The group that a process was started in."""
    return int((process / "stat").read_text().rpartition(")")[2].split()[2])


def measure(points: int, *, headset: bool) -> None:
    """Print a block of figures."""
    place = "headset" if headset else "desk"
    with tempfile.TemporaryDirectory() as folder:
        workspace = Path(folder)
        recording(workspace, points)
        with page_on(workspace, headset, UNDRAWN) as (page, browser):
            pictures, own, _ = rate(page)
            print(f"  {place}, {points:,} points, undrawn: {pictures:.0f} pictures/s, ", end="")
            print(f"{own:.2f} ms of the page's own thread for each")
            report(page, "paused")
            page.run("__pointbrush.engine.playback.play()")
            time.sleep(1)
            report(page, "playing from the cache")
            page.run("__pointbrush.engine.playback.pause()")
            print(f"    {memory(page, browser)}")
        with page_on(workspace, headset) as (page, _):
            pictures, own, _ = rate(page)
            print(f"    drawn by this machine: {pictures:.1f} pictures/s")
            page.run("__pointbrush.setAdaptive(true)")
            time.sleep(SECONDS)
            pictures, own, drawn = rate(page)
            print(f"    in time: {pictures:.1f} pictures/s of {drawn:,} points")


def main() -> None:
    """Print the figures."""
    chosen = sys.argv[1:] or ["desk", "headset"]
    print("pictures")
    for place in chosen:
        for points in SIZES:
            measure(points, headset=place == "headset")


if __name__ == "__main__":
    main()
