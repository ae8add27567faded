"""The page: frames of a Kinect applied a second, against viser's replay in the same browser.

python benchmarks/bench_page.py [apply|viser|play]...

``apply``: every frame decoded in the worker and uploaded to the GPU whole, as fast as frames
come; nothing drawn, since this machine's GPU is a program.  ``viser``: the same frames replayed
by viser as fast as it can, counted where its page receives them (before it uploads or draws).
``play``: what the page's own thread spends on a picture of the playing recording.
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

from bench_streaming import POINTS, TOKEN, pointbrush, recording, running
from chromium import Tab, tab

SECONDS = 5.0
ROUNDS = 3
READY = "!!window.__pointbrush && __pointbrush.shown().total > 0"
COMPLETE = f"{READY} && __pointbrush.shown().drawn === __pointbrush.shown().total"
# Counts what viser's page gets from its worker: messages that carry a cloud of all points.
COUNT_CLOUDS = """
window.clouds = 0;
const Plain = window.Worker;
window.Worker = class extends Plain {
  constructor(...given) {
    super(...given);
    this.addEventListener('message', (event) => {
      for (const message of event.data?.messages ?? []) {
        if (message.type === 'PointCloudMessage') window.clouds += 1;
      }
    });
  }
};
"""


@contextmanager
def ours(workspace: Path) -> Iterator[Tab]:
    with pointbrush(workspace) as url, tab() as page:
        page.open(f"{url}/?token={TOKEN}")
        page.until(COMPLETE)
        yield page


def apply(workspace: Path) -> float:
    rates, decodes, uploads = [], [], []
    with ours(workspace) as page:
        page.run("__pointbrush.setDrawing(false)")
        page.run("__pointbrush.replay(2)")
        for _ in range(ROUNDS):
            result = page.run(f"__pointbrush.replay({SECONDS})")
            assert result["points"] >= 0.98 * result["frames"] * POINTS
            rates.append(result["frames"] / result["seconds"])
            decodes.append(result["decodeMs"])
            uploads.append(result["uploadMs"])
            megabytes = result["bytes"] / result["seconds"] / 1e6
    print(
        f"  pointbrush: {statistics.median(rates):.0f} frames/s of {POINTS:,} points "
        f"({megabytes:.0f} MB/s, {result['bytes'] / result['points']:.2f} bytes a point), "
        f"decode {statistics.median(decodes):.2f} ms in the worker, "
        f"upload {statistics.median(uploads):.2f} ms"
    )
    return statistics.median(rates)


def viser(pause: float) -> float:
    """Frames a second that viser's page receives when the server waits ``pause`` in between."""
    with running("viser_replay.py", str(pause)) as url, tab() as page:
        page.open(url, COUNT_CLOUDS)
        page.until("window.clouds > 3")
        time.sleep(2)
        before, start = page.run("window.clouds"), time.monotonic()
        time.sleep(SECONDS)
        after, stop = page.run("window.clouds"), time.monotonic()
    rate = float((after - before) / (stop - start))
    print(f"  viser, {1 / pause:.0f} frames/s pushed: {rate:.0f} frames/s received")
    return rate


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


def main() -> None:
    chosen = sys.argv[1:] or ["apply", "viser", "play"]
    print("page")
    with tempfile.TemporaryDirectory() as folder:
        workspace = Path(folder)
        if "apply" in chosen or "play" in chosen:
            recording(workspace)
        rate = apply(workspace) if "apply" in chosen else 0.0
        if "viser" in chosen:
            best = max(viser(1 / pushed) for pushed in (30, 60, 120))
            if rate:
                print(f"  ratio: {rate / best:.1f}")
        if "play" in chosen:
            play(workspace)


if __name__ == "__main__":
    main()
