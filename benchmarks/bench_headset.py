"""The headset: what the page's own thread spends on a picture inside a playing Kinect recording.

python benchmarks/bench_headset.py

The headset is emulated (the npm package iwer); draw calls do nothing, because this machine's GPU is
a program.  Counted is everything of ours before the draw: hands, panels, brush, presence, time, and
bringing a new frame's points over; and the whole callback of a picture, three.js and the calls to
draw included.  Then what a picture of frames that are cached allocates, by whose code asks for it:
objects, and numbers that V8 boxes.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from allocations import SEPARATE, allocations
from bench_page import PREPARE, ours
from bench_streaming import POINTS, kinect, recording
from chromium import Tab

from pointbrush.labels import Write
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace

IWER = Path(__file__).parents[1] / "webxr_client/node_modules/iwer/build/iwer.min.js"
WEAR = """;(() => {
  const device = new IWER.XRDevice(IWER.metaQuest3, { stereoEnabled: true });
  device.installRuntime({ forceInstall: true });
  window.device = device;
})();"""
# The emulator asks the GPU for its state in every picture, and each answer waits for the queue.
ANSWERS = """
const answers = new Map(), ask = gl.getParameter;
gl.getParameter = function (name) {
  if (!answers.has(name)) answers.set(name, ask.call(this, name));
  return answers.get(name);
};
"""
# Script time of a picture: the whole callback, three.js and its draw calls as well.
CALLBACKS = """;(() => {
  const ask = XRSession.prototype.requestAnimationFrame;
  let callback = null;
  window.callbackMs = [];
  const timed = (now, frame) => {
    const began = performance.now();
    callback(now, frame);
    window.callbackMs.push(performance.now() - began);
  };
  XRSession.prototype.requestAnimationFrame = function (next) {
    callback = next;
    return ask.call(this, timed);
  };
})();"""
SWAY = """
setInterval(() => {
  const t = performance.now() / 400;
  const { left, right } = window.device.controllers;
  const [x, y, z] = window.surface ?? [0.4, 1.3, -0.5];
  // A brush wanders: painting on what is painted changes nothing.
  const [aside, up] = window.surface ? [0.5 * Math.sin(t / 5), 0.4 * Math.sin(t / 23)] : [0, 0];
  right.position.set(x + 0.2 * Math.sin(t) + aside, y + up, z + 0.1 * Math.cos(t));
  left.position.set(-0.25, 1.2 + 0.05 * Math.sin(t), -0.4);
}, 8)
"""
BOXES = """(() => {
  const { view } = __pointbrush.state;
  view.value = { ...view.value, boxes: true };
})()"""
PICTURES = "__pointbrushHeadset.frames()"
SECONDS = 6.0
SAMPLED = 4.0
WARM_UP = 20.0
"""Seconds until V8 has compiled what runs in every picture; until then it boxes every number."""
CACHED = "__pointbrush.counters().cachedFrames >= __pointbrush.state.sequence.value.frames"
BUDGET_MS, CALLBACK_MS = 2.0, 3.0
"""Own work before the draw, and the whole callback, at the 95th percentile."""
LABELS, LABELLED = 8, 10
"""Labels, and every how many points one of them has one."""


def label(workspace: Path) -> None:
    """A tenth of each frame's points belong to somebody: boxes and trails have work to do."""
    opened = Workspace(Settings(workspace=workspace))
    try:
        (recording,) = opened.library.manifests()
        for number in range(LABELS):
            opened.labels.create_label(recording.id, "bench", name=f"thing {number + 1}")
        numbers = np.arange(0, POINTS, LABELLED)
        values = (1 + np.arange(len(numbers)) % LABELS).astype(np.uint16)
        opened.labels.apply(
            recording.id,
            edit_id=str(uuid.uuid4()),
            author="bench",
            kind="paint",
            writes={i: Write(numbers, label=values, provenance=1) for i in range(recording.frames)},
            summary="",
        )
    finally:
        opened.close()


@contextmanager
def inside(workspace: Path, *flags: str) -> Iterator[Tab]:
    """A page inside the recording that moves its hands, with everything drawn over it."""
    with ours(workspace, IWER.read_text() + WEAR + CALLBACKS + PREPARE + ANSWERS, *flags) as page:
        page.until("__pointbrush.state.xr.value.supported === true")
        page.run("__pointbrushHeadset.headset.enter()")
        page.until("__pointbrushHeadset.frames() > 10")
        page.run(SWAY)
        page.run("__pointbrush.setAdaptive(false)")
        page.run(BOXES)
        yield page


PARTIES = {"ours": "ours", "three": "three.js", "libraries": "signals", "emulator": "emulator"}
TRACK = """(() => {
  __pointbrush.engine.playback.pause();
  __pointbrush.engine.track({ labels: [1], start: 0, stop: 40, method: 'auto',
    overwrite: 'tracked', stop_unsure: false });
})()"""
RUNNING = "__pointbrush.state.jobs.value.some((job) => job.state === 'running')"


def main() -> None:
    """Print the figures."""
    print("headset")
    with tempfile.TemporaryDirectory() as folder:
        workspace = Path(folder)
        recording(workspace)
        label(workspace)
        with inside(workspace) as page:
            for doing in acting(page):
                times(page, doing)
                print(f"    numbers boxed a picture, bytes: {allocated(page, 'numbers')}")
        with inside(workspace, SEPARATE) as page:
            for doing in acting(page):
                print(f"  {doing}, objects a picture, bytes: {allocated(page, 'objects')}")


def middle() -> list[float]:
    """A point of the recording's wall."""
    xyz = kinect(0).xyz
    return [float(value) for value in xyz[len(xyz) // 2]]


def acting(page: Tab) -> Iterator[str]:
    """Play what has come whole; paint; then watch a tracking run's results arrive."""
    trigger = "device.controllers.right.updateButtonValue('trigger', {})"
    page.run("__pointbrush.engine.playback.play()")
    page.until(CACHED)
    time.sleep(WARM_UP)
    yield "playing"
    page.run(f"(window.surface = __pointbrushHeadset.place({middle()}))")
    page.run(trigger.format(1))
    time.sleep(WARM_UP)
    yield "painting"
    page.run(trigger.format(0))
    page.run(TRACK)
    page.until(RUNNING)
    yield "tracking"


def times(page: Tab, doing: str) -> None:
    """Print what a picture costs."""
    page.run("(__pointbrush.resetTiming(), window.callbackMs.length = 0)")
    time.sleep(SECONDS)
    timing = page.run("__pointbrush.timing()")
    work, callbacks = sorted(timing["work"]), page.run("window.callbackMs")
    print(
        f"  {doing}, {POINTS:,} points: {statistics.median(work):.2f} ms of the page's "
        f"own work a picture (95 %: {work[int(0.95 * len(work))]:.2f}, "
        f"goal {BUDGET_MS:.0f}), {shown(timing['draw'])} in "
        f"three.js, {1000 / statistics.mean(timing['interval']):.0f} pictures/s; "
        f"after it, when there is something to send, {shown(timing['after'])}; "
        f"the whole callback {shown(callbacks)}, goal {CALLBACK_MS:.0f}"
    )


def shown(milliseconds: list[float]) -> str:
    """Median and 95th percentile, in words."""
    if not milliseconds:
        return "nothing"
    after = sorted(milliseconds)
    return f"{statistics.median(after):.2f} ms (95 %: {after[int(0.95 * len(after))]:.2f})"


def allocated(page: Tab, what: Literal["objects", "numbers"]) -> str:
    """Bytes a picture by who asked for them, in words."""
    shares = allocations(page, PICTURES, SAMPLED)
    sizes = [f"{name} {getattr(shares[key], what):.0f}" for key, name in PARTIES.items()]
    mine = shares["ours"].worst(numbers=what == "numbers")
    return ", ".join(sizes) + (f" (ours: {mine})" if mine else "")


if __name__ == "__main__":
    main()
