"""Take the pictures of boxes anew, on generated traffic; ``docs/pictures.py`` runs it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import httpx
import numpy as np
from playwright.sync_api import Browser

from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush_samples.traffic import TrueTraffic, traffic
from tests.e2e.desk import Desk, launch

SEED, FRAMES = 3, 3
SIZE = (1440, 810)
"""Window, pixels."""
TOKEN = "token-of-the-boxes"
SURE = 0.92
"""Confidence that boxes have here."""
BEHIND, ABOVE = 7.0, 4.5
"""Metres from the car to the eye."""


@contextmanager
def serving(workspace: Path, made: TrueTraffic) -> Iterator[tuple[httpx.Client, str]]:
    """Serve the traffic, all of it labelled; yields the API and the page's address."""
    (workspace / "sequences").mkdir(parents=True)
    frames = (replace(one.frame, pose=one.T_room_frame) for one in made.frames)
    target = workspace / "sequences" / "drive"
    import_frames(frames, target, RecordingInfo("drive", "Drive", 10.0))
    command = [sys.executable, "-m", "pointbrush.cli", "serve", "--port", "0"]
    command += ["--workspace", str(workspace)]
    environment = os.environ | {"POINTBRUSH_TOKEN": TOKEN}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        try:
            assert process.stdout is not None
            found = next(filter(None, (re.search(r"http://[^/\s]+", s) for s in process.stdout)))
            headers = {"Authorization": f"Bearer {TOKEN}"}
            address = f"{found[0]}/api/v1/sequences/drive"
            with httpx.Client(base_url=address, headers=headers, timeout=60) as api:
                yield api, f"{found[0]}/?token={TOKEN}"
        finally:
            process.terminate()


def label(api: httpx.Client, made: TrueTraffic) -> dict[int, int]:
    """Make a label and a box of each object; returns labels by those of the truth."""
    ids = {}
    for number, (truth, box) in enumerate(sorted(made.boxes.items()), start=1):
        kind = made.kinds[truth]
        body = {"name": f"{kind} {number}", "category": kind}
        ids[truth] = api.post("/labels", json=body).raise_for_status().json()["id"]
        poses = {
            str(frame): {
                "centre": pose.centre.tolist(),
                "quaternion": pose.quaternion.tolist(),
                "provenance": "fitted",
                "confidence": SURE,
            }
            for frame, pose in box.poses.items()
        }
        whole = {"label": ids[truth], "size": box.size.tolist(), "poses": poses}
        api.post("/boxes", json=whole | {"provenance": "fitted"}).raise_for_status()
    lookup = np.zeros(max(ids) + 1, np.uint16)
    lookup[list(ids)] = list(ids.values())
    for frame, one in enumerate(made.frames):
        stream = BytesIO()
        np.save(stream, lookup[one.instance])
        path, headers = f"/frames/{frame}/annotation", {"Content-Type": "application/x-npy"}
        api.put(path, content=stream.getvalue(), headers=headers).raise_for_status()
    return ids


def best(made: TrueTraffic) -> int:
    """Find the car with the most points in the first frame."""
    instance = made.frames[0].instance
    cars = [truth for truth in made.boxes if made.kinds[truth] == "car"]
    return max(cars, key=lambda truth: int((instance == truth).sum()))


def take(browser: Browser, folder: Path, save: Callable[[Desk, str], None]) -> None:
    """Look at a car's box in the cloud and in three views."""
    made = traffic(SEED, FRAMES)
    with serving(folder / "traffic", made) as (api, page):
        ids = label(api, made)
        car = best(made)
        desk = launch(browser, page, *SIZE, drawn=True)
        desk.ready()
        desk.press("Shift+B")
        desk.ask(f"(pb.state.activeLabel.value = {ids[car]})")
        x, y, z = made.boxes[car].poses[0].centre.tolist()
        desk.ask(f"(pb.engine.viewer.room.updateMatrixWorld(), pb.look(...{_eye(desk, x, y, z)}))")
        desk.page.locator(".box-view.top svg").wait_for()
        desk.page.wait_for_timeout(1500)
        save(desk, "desk-boxes")
        desk.close()


def _eye(desk: Desk, x: float, y: float, z: float) -> str:
    """Places of the eye and of the car in the room, beside it and above."""
    at = desk.ask(
        f"""(() => {{
          const [a, b, c] = pb.state.sequence.value.shift;
          const at = pb.engine.viewer.camera.position.clone();
          at.set({x} - a, {y} - b, {z} - c).applyMatrix4(pb.engine.viewer.room.matrixWorld);
          return at.toArray();
        }})()"""
    )
    eye = [at[0] + 0.6 * BEHIND, at[1] + ABOVE, at[2] + BEHIND]
    return str([eye, at])
