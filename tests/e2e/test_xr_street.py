"""In the headset, in a recording of hundreds of metres: what is near the eyes is there too."""

from __future__ import annotations

import io
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from playwright.sync_api import Browser

from pointbrush.formats import read
from pointbrush.sequences import RecordingInfo, import_frames
from tests.e2e.headset import Headset, wear
from tests.e2e.server import LiveServer

WIDE = 400.0
MAGENTA = (220, 0, 220)
HANDS = {"left": [-0.2, 1.35, -0.35], "right": [0.1, 1.48, -0.4]}


def write_street(folder: Path) -> None:
    """A street 400 m long between two walls, all of one colour that nothing else has."""
    rng = np.random.default_rng(0)
    along = rng.uniform(-WIDE / 2, WIDE / 2, 16_000)
    across, up = rng.uniform(-8, 8, 16_000), np.zeros(16_000)
    across[8_000:] = np.where(rng.random(8_000) < 0.5, -8, 8)
    up[8_000:] = rng.uniform(0, 6, 8_000)
    xyz = np.stack([along, across, up], axis=1).astype(np.float32)
    folder.mkdir()
    np.savez(folder / "0.npz", xyz=xyz, rgb=np.full((16_000, 3), MAGENTA, np.uint8))


@pytest.fixture
def street(tmp_path: Path) -> Iterator[LiveServer]:
    workspace = tmp_path / "workspace"
    write_street(tmp_path / "street")
    (workspace / "sequences").mkdir(parents=True)
    frames = read(tmp_path / "street")
    target = workspace / "sequences" / "street"
    import_frames(frames, target, RecordingInfo("street", "Street", 10.0))
    server = LiveServer(workspace)
    server.start()
    yield server
    server.stop()
    shutil.rmtree(workspace)


def picture(headset: Headset) -> NDArray[Any]:
    headset.frames(3)
    shot = headset.page.screenshot()
    return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB")).astype(int)


def in_left_eye(headset: Headset, place: str) -> tuple[int, int]:
    """Where a place of the scene (an expression) is on the page, in pixels."""
    u, v = headset.ask(
        f"""(() => {{
          const {{ xr }} = pb.engine.viewer.renderer, eye = xr.getCamera().cameras[0];
          const at = ({place}).clone().project(eye), {{ x, y, z, w }} = eye.viewport;
          const {{ width, height }} = pb.engine.viewer.canvas;
          return [(x + (at.x + 1) / 2 * z) / width, 1 - (y + (at.y + 1) / 2 * w) / height];
        }})()"""
    )
    box = headset.page.locator("#view").bounding_box()
    assert box is not None
    return int(box["x"] + u * box["width"]), int(box["y"] + v * box["height"])


def changed(one: NDArray[Any], other: NDArray[Any], at: tuple[int, int], size: int) -> float:
    """Share of the pixels of a square that differ visibly."""
    x, y = at
    cut = (slice(max(0, y - size), y + size), slice(max(0, x - size), x + size))
    return float((np.abs(one[cut] - other[cut]).max(axis=2) > 12).mean())


def test_hands_palette_and_the_far_end_of_a_street_are_seen(
    browser: Browser, street: LiveServer
) -> None:
    street.create_label("street", "car", "#5ea2ff")
    headset = wear(browser, street.page_url, drawn=True)
    headset.ready()
    headset.enter()
    headset.set_radius(0.05)
    headset.ask("pb.setDrawing(true)")
    for hand, at in HANDS.items():
        headset.move(hand, at, [at[0], 1.6, -3.0])
    cockpit = "hs.headset.cockpit"
    palette = f"{cockpit}.panels.palette"
    # Folded, it is a handle on its lower edge.
    across = f"({palette}.size.handle.at - 0.5) * {palette}.size.width"
    handle = f"{palette}.mesh.position.clone()"
    handle += f".set({across}, 0.014 - {palette}.size.height / 2, 0)"
    handle = in_left_eye(headset, f"{palette}.mesh.localToWorld({handle})")
    brush = in_left_eye(headset, f"{cockpit}.painter.tip")
    grip = in_left_eye(headset, f"{cockpit}.pointers.of('right').place")
    depth = "pb.engine.viewer.renderer.xr.getSession().renderState"
    # The nearest plane, also where depth is reversed and the session has the planes swapped.
    assert headset.ask(f"Math.min({depth}.depthNear, {depth}.depthFar)") <= 0.05
    assert headset.ask("pb.engine.viewer.reversible")
    with_hands = picture(headset)
    headset.screenshot("street-with-hands")
    for hand in HANDS:
        headset.ask(f"(device.controllers.{hand}.connected = false)")
    headset.until("hs.headset.cockpit.pointers.of('right') === null")
    without = picture(headset)
    headset.screenshot("street-without-hands")
    assert changed(with_hands, without, handle, 8) > 0.2
    assert changed(with_hands, without, brush, 3) > 0.5
    assert changed(with_hands, without, grip, 8) > 0.3
    # The street goes on to its end: its colour is in the picture, walls meet far ahead.
    magenta = (without[..., 0] > 90) & (without[..., 1] < 60) & (without[..., 2] > 90)
    assert magenta.mean() > 0.01
    headset.close()
    assert headset.complaints == []
