"""The page: frames of a Kinect applied a second, against viser's replay in the same browser.

python benchmarks/bench_page.py [apply|viser|play|open|scale]...

``apply``: frames decoded in the worker and uploaded to the GPU whole, as fast as they come.
``viser``: the same frames replayed by viser at several rates, the best of which counts; also
counted as they are uploaded.  In both pages the calls that draw or clear do nothing: this
machine's GPU is a program, which would measure only itself.
``play``: what the page's own thread spends on a picture of the playing recording, drawn.
``open``: from the wish to open a recording to its first draw of points, in a page that is there.
``scale``: processor time of the page's own thread to open a recording of 2,000 frames, one of 200
labels and one of both, to search a label, to go to another frame and to choose another label.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from bench_streaming import POINTS, TOKEN, kinect, pointbrush, recording, running
from chromium import Tab, tab

from pointbrush.frame import PointFrame
from pointbrush.labels import Write
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace

SECONDS = 5.0
ROUNDS = 3
READY = "!!window.__pointbrush && __pointbrush.shown().total > 0"
COMPLETE = f"{READY} && __pointbrush.shown().drawn === __pointbrush.shown().total"
OPENINGS = 9
DEPTH_BYTES, UPLOAD_BYTES = 2, 6
"""Least bytes of a point that go to the GPU, and most."""
SETTLED = 2.0
"""Seconds that a browser is given to start: its own windows are pages as well."""
# Both run before either page's own scripts: no drawing, the bytes of points that go to the GPU.
UNDRAWN = """
const gl = WebGL2RenderingContext.prototype;
const drawing = ['drawArrays', 'drawElements', 'drawArraysInstanced', 'drawElementsInstanced'];
for (const draw of [...drawing, 'clear']) gl[draw] = () => {};
"""
FIRST = (
    UNDRAWN
    + """
window.pointsAt = null;
gl.drawArrays = (mode, _, count) => {
  if (mode === gl.POINTS && count > 0) window.pointsAt ??= performance.now();
};
"""
)
"""Notes when points are drawn for the first time, in ms since the page was asked for."""
OPEN = """new Promise((resolve) => {
  window.pointsAt = null;
  const start = performance.now();
  __pointbrush.engine.openSequence('NAME');
  const look = () => window.pointsAt ? resolve(window.pointsAt - start) : setTimeout(look, 1);
  look();
})"""
PREPARE = (
    UNDRAWN
    + """
window.uploads = 0;
const sizeOf = (data, count) =>
  count ? count * (data.BYTES_PER_ELEMENT ?? 1) : (data?.byteLength ?? 0);
for (const name of ['bufferData', 'bufferSubData']) {
  const upload = gl[name];
  gl[name] = function (...given) {
    const data = name === 'bufferData' ? given[1] : given[2];
    if (typeof data === 'object') window.uploads += sizeOf(data, given[4]);
    return upload.apply(this, given);
  };
}
// Texels of all textures that points are drawn from have one byte, two or four.
const texels = gl.texSubImage2D;
gl.texSubImage2D = function (...given) {
  const [, , , , width, height, format, type] = given;
  const channels = format === gl.RGBA ? 4 : 1;
  const size = { [gl.UNSIGNED_BYTE]: 1, [gl.UNSIGNED_SHORT]: 2, [gl.FLOAT]: 4 }[type];
  if (given.length > 8) window.uploads += width * height * channels * size;
  return texels.apply(this, given);
};
"""
)

REPLAY = """new Promise((resolve) => {
  const { state, engine: { playback, viewer, link } } = __pointbrush;
  const frames = state.sequence.peek().frames, before = { ...playback.counters };
  const started = performance.now();
  let done = 0, uploadMs = 0;
  const stop = playback.completed.add((frame) => {
    const began = performance.now();
    viewer.show(frame);
    uploadMs += performance.now() - began;
    done += 1;
    playback.forget([frame]);
    link.send({ type: 'seek', frame: (frame.index + 1) % frames });
    const seconds = (performance.now() - started) / 1000;
    if (seconds < SECONDS) return;
    stop();
    const { points, bytes, decodeMs } = playback.counters;
    resolve({
      seconds, frames: done, points: points - before.points, bytes: bytes - before.bytes,
      decodeMs: (decodeMs - before.decodeMs) / done, uploadMs: uploadMs / done,
    });
  });
  playback.forget([...playback.store.all()]);
  link.send({ type: 'seek', frame: 0 });
})"""
"""Seeks from frame to frame.  Each is forgotten once it is on the GPU, so that it is sent again.

``decodeMs`` in the worker and ``uploadMs`` on the page's own thread are of one frame.
"""


def replay(page: Tab, seconds: float) -> Any:
    """Take in frame after frame for some seconds as fast as they come, each uploaded whole."""
    return page.run(REPLAY.replace("SECONDS", str(seconds)))


@contextmanager
def ours(workspace: Path, prepare: str = "", *flags: str) -> Iterator[Tab]:
    with pointbrush(workspace) as url, tab(*flags) as page:
        page.open(f"{url}/?token={TOKEN}", prepare)
        page.until(COMPLETE)
        yield page


def apply(workspace: Path) -> float:
    rates, decodes, uploads, sizes = [], [], [], []
    with ours(workspace, PREPARE) as page:
        replay(page, 2)
        for _ in range(ROUNDS):
            page.run("window.uploads = 0")
            result = replay(page, SECONDS)
            sizes.append(page.run("window.uploads") / (POINTS * result["frames"]))
            assert sizes[-1] >= DEPTH_BYTES
            assert result["points"] >= 0.98 * result["frames"] * POINTS
            rates.append(result["frames"] / result["seconds"])
            decodes.append(result["decodeMs"])
            uploads.append(result["uploadMs"])
            megabytes = result["bytes"] / result["seconds"] / 1e6
    print(
        f"  pointbrush: {statistics.median(rates):.0f} frames/s of {POINTS:,} points "
        f"({megabytes:.0f} MB/s, {result['bytes'] / result['points']:.2f} bytes a point), "
        f"decode {statistics.median(decodes):.2f} ms in the worker, "
        f"upload {statistics.median(uploads):.2f} ms, {max(sizes):.2f} bytes a point "
        f"(goal {UPLOAD_BYTES:.0f})"
    )
    return statistics.median(rates)


def viser(pushed: float) -> float:
    """Frames a second that viser's page uploads when the server pushes ``pushed`` a second."""
    with running("viser_replay.py", str(pushed)) as url, tab() as page:
        page.open(url, PREPARE)
        page.until("window.uploads > 0")
        time.sleep(3)
        frame = upload_of_a_frame(page)
        before, start = page.run("window.uploads"), time.monotonic()
        time.sleep(SECONDS)
        after, stop = page.run("window.uploads"), time.monotonic()
    rate = float((after - before) / frame / (stop - start))
    print(f"  viser, {pushed:.0f} frames/s pushed: {rate:.0f} frames/s")
    return rate


def upload_of_a_frame(page: Tab) -> int:
    """Bytes that viser uploads at once, the smallest step seen: one frame."""
    steps = page.run(
        """new Promise((resolve) => {
          const steps = [];
          let last = window.uploads;
          const look = () => {
            if (window.uploads > last) steps.push(window.uploads - last);
            last = window.uploads;
            if (steps.length < 12) requestAnimationFrame(look); else resolve(steps);
          };
          look();
        })"""
    )
    return int(min(step for step in steps if step > 6 * POINTS))


def play(workspace: Path) -> None:
    with ours(workspace) as page:
        page.run("__pointbrush.setAdaptive(false); __pointbrush.engine.playback.play()")
        time.sleep(4)
        page.run("__pointbrush.resetTiming()")
        time.sleep(SECONDS)
        timing = page.run("__pointbrush.timing()")
        shown = page.run("__pointbrush.shown()")
    work, draw = statistics.median(timing["work"]), statistics.median(timing["draw"])
    rate = 1000 / statistics.mean(timing["interval"])
    print(
        f"  playing, {shown['drawn']:,} points: {work:.2f} ms of the page's own work a picture, "
        f"{draw:.2f} ms in three.js; {rate:.1f} pictures/s (software GPU)"
    )


def opening(workspace: Path) -> None:
    """Two recordings in turn, so that each is opened; the first time is not counted."""
    first = workspace / "sequences" / "kinect"
    other = first.with_name("other")
    import_frames([kinect(0)], other, RecordingInfo("other", "other", 30.0))
    times = []
    with pointbrush(workspace) as url, tab() as page:
        time.sleep(SETTLED)
        page.open(f"{url}/?token={TOKEN}", FIRST)
        page.until("!!window.__pointbrushHeadset")
        for number in range(OPENINGS):
            took = page.run(OPEN.replace("NAME", ("kinect", "other")[number % 2]))
            times.append(took)
            time.sleep(1)
    times = times[1:]
    print(
        f"  opened in {statistics.median(times):.0f} ms "
        f"({min(times):.0f} to {max(times):.0f}), {POINTS:,} points"
    )


SCALES = (("small", 10, 5), ("frames", 2_000, 20), ("labels", 100, 200), ("both", 2_000, 200))
"""Name, frames and labels of a recording; every label has points in every frame.

The first one pays for what a page does once.
"""
SCALE_POINTS = 1_000
STEPS = (
    ("search", "SEARCH.value = 'thing 1'; SEARCH.dispatchEvent(new Event('input'))"),
    ("search ends", "SEARCH.value = ''; SEARCH.dispatchEvent(new Event('input'))"),
    ("other frame", "__pointbrush.engine.playback.seek(__pointbrush.state.frame.value + 7)"),
    ("other label", "__pointbrush.state.activeLabel.value = 17"),
)
SEARCH = "document.getElementById('label-search')"
QUIET = """new Promise((resolve) => {
  let last = performance.now();
  let still = 0;
  const look = () => {
    const now = performance.now();
    still = now - last < 60 ? still + 1 : 0;
    last = now;
    if (still > 20) resolve(); else setTimeout(look, 20);
  };
  look();
})"""
"""Resolves when nothing has held the page's thread up for 20 looks."""


def scaled(workspace: Path, name: str, frames: int, labels: int) -> None:
    """Import a recording, and give each label points in each frame."""
    random = np.random.default_rng(1)
    xyz = random.uniform(-2, 2, (SCALE_POINTS, 3)).astype(np.float32)
    made = (PointFrame(xyz=xyz + np.float32(0.001 * i)) for i in range(frames))
    import_frames(made, workspace / "sequences" / name, RecordingInfo(name, name, 10.0))
    with closing(Workspace(Settings(workspace=workspace))) as opened:
        store = opened.labels
        for number in range(labels):
            store.create_label(name, "a", name=f"thing {number}", category=f"kind {number % 9}")
        points = np.arange(SCALE_POINTS)
        label = (1 + points % labels).astype(np.uint16)
        writes = ((frame, Write(points, label=label, provenance=1)) for frame in range(frames))
        store.apply(name, edit_id=None, author="a", kind="paint", writes=writes, summary="all")


def scale(workspace: Path) -> None:
    for each in SCALES:
        scaled(workspace, *each)
    with pointbrush(workspace) as url, tab() as page:
        time.sleep(SETTLED)
        page.call("Performance.enable", timeDomain="threadTicks")
        page.open(f"{url}/?token={TOKEN}&sequence=none", UNDRAWN)
        page.until("!!window.__pointbrushHeadset")

        def busy() -> float:
            metrics = page.call("Performance.getMetrics")["metrics"]
            return next(m["value"] for m in metrics if m["name"] == "TaskDuration")

        def spent(script: str, done: str = "true") -> float:
            before = busy()
            page.run(f"{script}; undefined")
            page.until(done)
            page.run(QUIET)
            return 1e3 * (busy() - before)

        for name, frames, labels in SCALES:
            there = f"__pointbrush.state.sequence.value?.id === '{name}' && {COMPLETE}"
            listed = f"__pointbrush.state.timeline.value.rows.size === {labels}"
            script = f"__pointbrush.engine.openSequence('{name}')"
            took = [("open", spent(script, f"{there} && {listed}"))]
            for step, script in STEPS:
                took.append((step, spent(script.replace("SEARCH", SEARCH))))
            told = ", ".join(f"{step} {ms:.0f} ms" for step, ms in took)
            print(f"  {frames:,} frames, {labels} labels: {told} of the page's thread", flush=True)


def main() -> None:
    chosen = sys.argv[1:] or ["apply", "viser", "play", "open", "scale"]
    print("page")
    with tempfile.TemporaryDirectory() as folder:
        workspace = Path(folder)
        if {"apply", "play", "open"} & set(chosen):
            recording(workspace)
        rate = apply(workspace) if "apply" in chosen else 0.0
        if "viser" in chosen:
            best = max(viser(pushed) for pushed in (30, 60, 120))
            if rate:
                print(f"  ratio: {rate / best:.1f}")
        if "play" in chosen:
            play(workspace)
        if "open" in chosen:
            opening(workspace)
    if "scale" in chosen:
        with tempfile.TemporaryDirectory() as folder:
            scale(Path(folder))


if __name__ == "__main__":
    main()
