"""The headset: what the page's own thread spends on a picture inside a playing Kinect recording.

python benchmarks/bench_headset.py

The headset is emulated (the npm package iwer); draw calls do nothing, because this machine's GPU is
a program.  Counted is everything of ours before the draw: hands, panels, brush, presence, time, and
bringing a new frame's points over.  Bytes allocated are sampled by V8 and counted where a function
of the page (three.js in it) asked for them; the emulated runtime's own are left out.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
import uuid
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from bench_page import PREPARE, ours
from bench_streaming import POINTS, recording
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
SWAY = """
setInterval(() => {
  const t = performance.now() / 400;
  const { left, right } = window.device.controllers;
  right.position.set(0.2 * Math.sin(t), 1.3, -0.5 + 0.1 * Math.cos(t));
  left.position.set(-0.25, 1.2 + 0.05 * Math.sin(t), -0.4);
}, 8)
"""
BOXES = """(() => {
  const { view } = __pointbrush.state;
  view.value = { ...view.value, boxes: true };
})()"""
SECONDS = 6.0
BUDGET_MS = 2.0
SAMPLING = 512
"""Bytes between two samples of the heap."""
LABELS, LABELLED = 8, 10
"""Labels, and every how many points one of them has one."""


def label(workspace: Path) -> None:
    """A tenth of each frame's points belong to somebody: boxes and trails have work to do."""
    opened = Workspace(Settings(workspace=workspace))
    try:
        (recording,) = opened.sequences()
        for number in range(LABELS):
            opened.create_label(recording.id, "bench", name=f"thing {number + 1}")
        numbers = np.arange(0, POINTS, LABELLED)
        values = (1 + np.arange(len(numbers)) % LABELS).astype(np.uint16)
        opened.store.apply(
            recording.id,
            edit_id=str(uuid.uuid4()),
            author="bench",
            kind="paint",
            writes={i: Write(numbers, label=values, provenance=1) for i in range(recording.frames)},
            summary="",
        )
    finally:
        opened.close()


def allocated(page: Tab) -> float:
    """Bytes a picture that the page's own functions allocate."""
    page.call(
        "HeapProfiler.startSampling",
        samplingInterval=SAMPLING,
        includeObjectsCollectedByMajorGC=True,
        includeObjectsCollectedByMinorGC=True,
    )
    before = page.run("__pointbrushHeadset.frames()")
    time.sleep(SECONDS)
    pictures = page.run("__pointbrushHeadset.frames()") - before
    return own_bytes(page.call("HeapProfiler.stopSampling")["profile"]["head"]) / pictures


def own_bytes(node: dict[str, Any]) -> int:
    """Of a node of V8's profile and all below it, in the page's scripts."""
    mine: int = node["selfSize"] if "/assets/" in node["callFrame"]["url"] else 0
    return mine + sum(own_bytes(child) for child in node["children"])


def main() -> None:
    print("headset")
    with tempfile.TemporaryDirectory() as folder:
        workspace = Path(folder)
        recording(workspace)
        label(workspace)
        with ours(workspace, IWER.read_text() + WEAR + PREPARE + ANSWERS) as page:
            page.until("__pointbrush.state.xr.value.supported === true")
            page.run("__pointbrushHeadset.headset.enter()")
            page.until("__pointbrushHeadset.frames() > 10")
            page.run(SWAY)
            page.run("__pointbrush.setAdaptive(false)")
            page.run(
                "__pointbrush.state.view.value = { ...__pointbrush.state.view.value, boxes: true }"
            )
            page.run("__pointbrush.engine.playback.play()")
            for doing in ("playing", "painting"):
                if doing == "painting":
                    page.run("device.controllers.right.updateButtonValue('trigger', 1)")
                time.sleep(2)
                page.run("__pointbrush.resetTiming()")
                time.sleep(SECONDS)
                timing = page.run("__pointbrush.timing()")
                work = sorted(timing["work"])
                print(
                    f"  {doing}, {POINTS:,} points: {statistics.median(work):.2f} ms of the page's "
                    f"own work a picture (95 %: {work[int(0.95 * len(work))]:.2f}, "
                    f"goal {BUDGET_MS:.0f}), {statistics.median(timing['draw']):.2f} ms in "
                    f"three.js, {1000 / statistics.mean(timing['interval']):.0f} pictures/s, "
                    f"{allocated(page) / 1000:.1f} kB allocated a picture"
                )


if __name__ == "__main__":
    main()
