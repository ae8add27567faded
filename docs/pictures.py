"""Take the pictures of desk and headset anew: ``make pictures``, or ``python docs/pictures.py``.

A server of its own serves the sample recording with the true labels of its first frame, which are
tracked on; Chromium shows each view.  Written are small JPEGs in ``docs/images``.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import httpx
import numpy as np
from numpy.typing import NDArray
from PIL import Image
from playwright.sync_api import Browser, sync_playwright

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from docs import (  # noqa: E402
    box_pictures,
    headset_pictures,
    sensor_pictures,
    study_pictures,
    team_pictures,
)
from pointbrush.samples import Recording, generate  # noqa: E402
from tests.e2e.chromium import EXECUTABLE, FLAGS  # noqa: E402
from tests.e2e.desk import Desk, launch  # noqa: E402

IMAGES = Path(__file__).parent / "images"
TOKEN = "token-of-the-pictures"
Points = NDArray[np.floating]


@dataclass(frozen=True)
class Options:
    """Size of what is shown and written."""

    frames: int = 10  # of the sample recording
    width: int = 1440  # window, pixels
    height: int = 810
    written: int = 1200  # width of a picture, pixels
    floor: tuple[float, float, float] = (0.0, 1.1, 2.8)  # near what is pointed at, y down, metres
    flat: float = 0.03  # of the lowest point, metres
    strokes: int = 3  # of a label to learn from; four times as many of the room
    dust: int = 60  # points of a label that cannot be followed
    most_bytes: int = 120_000  # of a picture
    patience: float = 180.0  # seconds for a job


OPTIONS = Options()


class Server:
    """``pointbrush demo`` in a workspace of its own."""

    def __init__(self, api: httpx.Client, address: str) -> None:
        self.api, self.address = api, address
        (listed,) = api.get("/sequences").raise_for_status().json()
        self.path = f"/sequences/{listed['id']}"

    @property
    def page(self) -> str:
        return f"{self.address}/?token={TOKEN}"

    def put(self, frame: int, labels: NDArray[np.uint16]) -> None:
        """Label a frame's points (N,)."""
        stream = BytesIO()
        np.save(stream, labels)
        path = f"{self.path}/frames/{frame}/annotation"
        headers = {"Content-Type": "application/x-npy"}
        self.api.put(path, content=stream.getvalue(), headers=headers).raise_for_status()

    def track(self, labels: list[int]) -> None:
        """Carry labels of the first frame to the last one."""
        body = {"start": 0, "stop": OPTIONS.frames - 1, "labels": labels}
        job = self.api.post(f"{self.path}/tracking", json=body).raise_for_status().json()["id"]
        deadline = time.monotonic() + OPTIONS.patience
        while self.api.get(f"/jobs/{job}").json()["state"] in ("queued", "running"):
            if time.monotonic() > deadline:
                raise TimeoutError(f"tracking took more than {OPTIONS.patience:.0f} s")
            time.sleep(0.2)


@contextmanager
def serving(workspace: Path) -> Iterator[Server]:
    """Make the sample recording, and serve it."""
    command = [sys.executable, "-m", "pointbrush.cli", "demo", "--port", "0"]
    command += ["--sample-frames", str(OPTIONS.frames), "--workspace", str(workspace)]
    environment = os.environ | {"POINTBRUSH_TOKEN": TOKEN}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        try:
            assert process.stdout is not None
            found = next(filter(None, (re.search(r"http://[^/\s]+", s) for s in process.stdout)))
            headers = {"Authorization": f"Bearer {TOKEN}"}
            with httpx.Client(base_url=f"{found[0]}/api/v1", headers=headers, timeout=60) as api:
                yield Server(api, found[0])
        finally:
            process.terminate()


def save(desk: Desk, name: str, part: str = "body") -> None:
    """Write what a part of the page shows, as good as the size allows."""
    # Labels' names and rings fade in: a picture shows them as they stay.
    ends = "each.effect.getComputedTiming().endTime !== Infinity"
    desk.page.evaluate(
        f"document.getAnimations().filter((each) => {ends}).forEach((each) => each.finish())"
    )
    shown = Image.open(BytesIO(desk.page.locator(part).first.screenshot())).convert("RGB")
    if shown.width > OPTIONS.written:
        height = round(shown.height * OPTIONS.written / shown.width)
        shown = shown.resize((OPTIONS.written, height), Image.Resampling.LANCZOS)
    for quality in range(88, 40, -6):
        stream = BytesIO()
        shown.save(stream, "jpeg", quality=quality, optimize=True, progressive=True)
        if stream.tell() <= OPTIONS.most_bytes:
            break
    (IMAGES / f"{name}.jpg").write_bytes(stream.getvalue())
    print(f"{name}.jpg: {shown.width} x {shown.height}, {stream.tell() / 1000:.0f} kB", flush=True)


def object_tool(desk: Desk, middle: list[float]) -> None:
    """Point at a person, one level up from the part."""
    desk.press("j")
    desk.page.mouse.move(*desk.place(middle))
    desk.until("pb.state.object.value?.ready && pb.state.object.value.levels > 1", OPTIONS.patience)
    save(desk, "desk-object")
    desk.press("b")


def normals(desk: Desk) -> None:
    """Colour points by the direction of their surface."""
    chosen = desk.page.get_by_label("Colour points by")
    chosen.select_option("normal")
    desk.page.locator("#view").focus()
    save(desk, "desk-normal", "#stage")
    chosen.select_option("rgb")


def clip(desk: Desk) -> None:
    """Show only what is round the active object."""
    desk.press("y")
    desk.page.locator(".signs .sign").first.wait_for()
    save(desk, "desk-clip")
    desk.press("y")


def mask(desk: Desk) -> None:
    """Show the labels as a mask over the large picture of the depth camera, with the brush."""
    pictures = desk.page.get_by_role("button", name="Pictures of the cameras")
    pictures.click()
    desk.page.get_by_role("button", name="Show the picture of depth large").click()
    large = desk.page.locator(".camera-large")
    large.get_by_role("button", name="Mask").click()
    large.get_by_role("radio", name="Brush").click()
    large.locator("img.camera-mask").wait_for()
    desk.page.mouse.move(0, OPTIONS.height / 2)  # without the button's tip
    save(desk, "desk-mask")
    large.get_by_role("radio", name="Look").click()
    large.get_by_role("button", name="Close the large picture").click()
    pictures.click()


def review(desk: Desk) -> None:
    """Open the findings: what cannot be followed is suspicious, too."""
    desk.page.get_by_role("button", name="Work").click()
    desk.page.get_by_role("tab", name="Findings").click()
    desk.page.locator(".entries li").first.wait_for()
    save(desk, "desk-review")


def doubt(desk: Desk, server: Server, truth: NDArray[np.uint16]) -> int:
    """Track a label on points all over the room: nobody can be sure where such a thing went."""
    body = {"name": "dust", "color": "#e86fd0"}
    dust = server.api.post(f"{server.path}/labels", json=body).raise_for_status().json()["id"]
    room = np.flatnonzero(truth == 0)
    scattered = truth.copy()
    scattered[np.random.default_rng(0).choice(room, OPTIONS.dust, replace=False)] = dust
    server.put(0, scattered)
    server.track([dust])
    desk.ask(f"pb.state.activeLabel.value = {dust}")
    desk.until(f"pb.state.timeline.value.rows.get({dust})?.points[0] > 0")
    save(desk, "desk-timeline", "#timeline")
    return int(dust)


def by_example(desk: Desk, server: Server, truth: NDArray[np.uint16], xyz: Points) -> None:
    """Paint a little of each label and of the room in the last frame, and predict the rest."""
    last = f"{server.path}/frames/{OPTIONS.frames - 1}"
    labels = sorted(set(truth.tolist()))
    known = [label["id"] for label in server.api.get(f"{server.path}/labels").json()]
    server.api.post(f"{last}/clear", json={"labels": known}).raise_for_status()
    body = {"name": "room", "color": "#8fbf9a"}
    room = server.api.post(f"{server.path}/labels", json=body).raise_for_status().json()["id"]
    rng = np.random.default_rng(0)
    for label in labels:
        mine = np.flatnonzero(truth == label)
        for at in xyz[rng.choice(mine, OPTIONS.strokes if label else 4 * OPTIONS.strokes)].tolist():
            stroke = {"shape": "sphere", "radius": 0.06, "label": label or room, "tool": "paint"}
            stroke |= {"only_unlabeled": True, "samples": [{"origin": at}]}
            server.api.post(f"{last}/strokes", json=stroke).raise_for_status()
    desk.press("End")
    desk.page.get_by_role("button", name="By example").click()
    desk.page.get_by_role("button", name="Learn from painted points").click()
    desk.page.get_by_text("in doubt").wait_for()
    desk.page.locator(".example-told .spinner").wait_for(state="detached")
    desk.page.mouse.move(0, OPTIONS.height / 2)  # without the button's tip
    save(desk, "desk-example")
    desk.page.get_by_role("button", name="By example").click()
    server.api.delete(f"{server.path}/labels/{room}").raise_for_status()
    desk.press("Home")


def take(server: Server, browser: Browser, recording: Recording) -> int:
    """Walk through the views, from the first visit to the list of recordings.

    Returns the label that cannot be followed.
    """
    truth, xyz = recording.truth[0], recording.frames[0].xyz
    size = (OPTIONS.width, OPTIONS.height)
    newcomer = launch(browser, server.page, *size, drawn=True, newcomer=True)
    newcomer.page.locator(".tour").wait_for(timeout=OPTIONS.patience * 1000)
    newcomer.ready()
    newcomer.page.get_by_role("button", name="Next").click()
    newcomer.page.get_by_role("button", name="Next").click()
    save(newcomer, "desk-tour")
    newcomer.close()

    server.put(0, truth)
    server.track(sorted(set(truth.tolist()) - {0}))
    desk = launch(browser, server.page, *size, drawn=True)
    desk.ready()
    person = max(set(truth.tolist()) - {0}, key=lambda label: int((truth == label).sum()))
    desk.ask(f"pb.state.activeLabel.value = {person}")
    save(desk, "desk")
    normals(desk)
    mine = xyz[truth == person]
    nearest = mine[np.linalg.norm(mine - mine.mean(axis=0), axis=1).argmin()]
    object_tool(desk, nearest.tolist())
    clip(desk)
    mask(desk)
    desk.page.get_by_role("button", name="Light theme").click()
    desk.page.mouse.move(0, OPTIONS.height / 2)  # without the button's tip
    save(desk, "desk-light")
    desk.page.get_by_role("button", name="Dark theme").click()
    dust = doubt(desk, server, truth)
    review(desk)
    desk.page.get_by_role("button", name="Work").click()
    last = OPTIONS.frames - 1
    by_example(desk, server, recording.truth[last], recording.frames[last].xyz)
    desk.close()
    return dust


def main() -> None:
    recording = generate("juggling", 0, OPTIONS.frames)
    xyz = recording.frames[0].xyz
    with (
        tempfile.TemporaryDirectory() as folder,
        serving(Path(folder) / "workspace") as server,
        sync_playwright() as playwright,
    ):
        chromium = playwright.chromium.launch(executable_path=EXECUTABLE, args=FLAGS)
        dust = take(server, chromium, recording)
        floor = xyz[xyz[:, 1] > xyz[:, 1].max() - OPTIONS.flat]
        nearest = floor[np.linalg.norm(floor - OPTIONS.floor, axis=1).argmin()]
        box_pictures.take(chromium, Path(folder), save)
        team_pictures.take(chromium, Path(folder), save)
        sensor_pictures.take(chromium, Path(folder), save)
        headset_pictures.take(server, chromium, IMAGES, dust, nearest.tolist())
        study_pictures.take(
            chromium,
            Path(folder),
            save,
            lambda eyes, name: headset_pictures.save(eyes, IMAGES / f"{name}.jpg"),
        )
        chromium.close()


if __name__ == "__main__":
    main()
