"""Take the pictures of the headset anew, emulated by iwer; ``docs/pictures.py`` runs it.

Both eyes are shown side by side, as the page draws them.
"""

from __future__ import annotations

from base64 import b64decode
from io import BytesIO
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from playwright.sync_api import Browser

from tests.e2e.headset import Headset, wear

SIZE = (1440, 800)
"""Width and height of the two eyes together, pixels."""
PAGES_WIDTH = 1500
"""Width of the palette's pages together, pixels."""
MOST_BYTES = 300_000
PATIENCE = 180.0
"""Seconds to wait for what the server does; drawing in software leaves it little."""
LEFT, RIGHT, ASIDE = [-0.2, 1.25, -0.5], [0.26, 1.35, -0.45], [0.5, 1.75, -1.5]
"""Hands that show palette and brush, and what that points at, in the headset's space, metres."""
LOW, OUT_OF_SIGHT = [-0.42, 1.05, -0.45], [-0.6, 0.9, 0.1]
TILT = 0.14
"""Turn of a recording whose floor was badly found, radians."""


class Served(Protocol):
    """A server with the sample recording, its first frame labelled and tracked on."""

    api: Any
    path: str
    page: str


def save(picture: Image.Image, target: Path) -> None:
    """Write a JPEG, as good as the size allows."""
    for quality in range(88, 40, -6):
        stream = BytesIO()
        picture.save(stream, "jpeg", quality=quality, optimize=True, progressive=True)
        if stream.tell() <= MOST_BYTES:
            break
    target.write_bytes(stream.getvalue())
    kilobytes = stream.tell() / 1000
    print(f"{target.name}: {picture.width} x {picture.height}, {kilobytes:.0f} kB", flush=True)


def look(headset: Headset) -> Image.Image:
    """Draw a few pictures and return the last one."""
    headset.ask("pb.setDrawing(true)")
    headset.until("pb.shown().drawn === pb.shown().total", PATIENCE)
    headset.frames(3)
    shown = Image.open(BytesIO(headset.page.screenshot(timeout=1000 * PATIENCE))).convert("RGB")
    headset.ask("pb.setDrawing(false)")
    return shown


def hold(headset: Headset) -> None:
    """Hold both hands in sight and look a little down."""
    headset.ask("device.quaternion.set(-0.1, 0, 0, 0.995)")
    headset.move("left", LEFT)
    headset.move("right", RIGHT, ASIDE)


def pages(headset: Headset) -> Image.Image:
    """Return the pages of the palette in rows of three, as they are drawn."""
    shown = []
    for name in ("Labels", "Tools", "View", "Fit boxes", "Work"):
        headset.click("palette", name)
        shown.append(panel(headset))
    headset.click("palette", "Labels")
    headset.click("palette", "New")
    shown.append(panel(headset))
    headset.click("palette", "Back")
    gap, columns = 12, 3
    wide, high = shown[0].width + gap, shown[0].height + gap
    lines = -(-len(shown) // columns)
    whole = Image.new("RGB", (columns * wide - gap, lines * high - gap), "white")
    for i, each in enumerate(shown):
        whole.paste(each, (i % columns * wide, i // columns * high), each)
    height = round(whole.height * PAGES_WIDTH / whole.width)
    return whole.resize((PAGES_WIDTH, height), Image.Resampling.LANCZOS)


def panel(headset: Headset) -> Image.Image:
    """Return what is drawn on the palette."""
    headset.frames(4)
    palette = "window.__pointbrushHeadset.headset.cockpit.panels.palette"
    url = headset.page.evaluate(f"{palette}.texture.image.toDataURL()")
    return Image.open(BytesIO(b64decode(url.partition(",")[2]))).convert("RGBA")


def floor(headset: Headset, server: Served, place: list[float]) -> Image.Image:
    """Stand the recording askew and on its floor again: return the left eye of both."""
    manifest = server.api.get(server.path).json()
    found: NDArray[np.float64] = np.reshape(manifest["room"], (4, 4))
    tilt = np.eye(4)
    c, s = np.cos(TILT), np.sin(TILT)
    tilt[1:3, 1:4] = [[c, -s, 0.25], [s, c, 0.0]]
    askew = tilt @ found
    server.api.patch(server.path, json={"room": askew.ravel().tolist()}).raise_for_status()
    shown = "pb.engine.viewer.room.matrix.elements[13]"
    headset.until(f"Math.abs({shown} - {askew[1, 3]}) < 1e-6")
    headset.click("palette", "View")
    headset.click("palette", "Floor")
    x, y, z = headset.ask(f"hs.place({place})")
    headset.move("right", [0.28, 1.2, -0.3], [x, y, z])
    before = look(headset)
    headset.trigger(1)
    headset.trigger(0)
    headset.until("pb.state.notices.value.at(-1)?.title === 'Floor set'", PATIENCE)
    headset.frames(6)
    after = look(headset)
    headset.click("palette", "Reset to import")
    headset.click("palette", "Done")
    half = SIZE[0] // 2
    both = Image.new("RGB", SIZE, "white")
    both.paste(before.crop((0, 0, half - 4, SIZE[1])), (0, 0))
    both.paste(after.crop((0, 0, half - 4, SIZE[1])), (half + 4, 0))
    return both


def first_minute(browser: Browser, page: str) -> Image.Image:
    """Return the first minute's second step, as a newcomer sees it."""
    headset = wear(browser, page, size=SIZE, drawn=True, newcomer=True)
    headset.ready()
    headset.enter()
    headset.ask("pb.setAdaptive(false)")
    headset.click("added", "Next")
    hold(headset)
    headset.until("hs.tips('right').length > 0")
    shown = look(headset)
    headset.close()
    return shown


def take(server: Served, browser: Browser, target: Path, dust: int, place: list[float]) -> None:
    """Walk through the views; nobody can track the label ``dust``, ``place`` is on the floor."""
    save(first_minute(browser, server.page), target / "headset-first-minute.jpg")
    headset = wear(browser, server.page, size=SIZE, drawn=True)
    headset.ready()
    headset.enter()
    headset.ask("pb.setAdaptive(false)")  # all points, however slowly they are drawn
    hold(headset)
    save(look(headset), target / "headset.jpg")

    headset.move("left", OUT_OF_SIGHT)
    headset.ask("device.quaternion.set(-0.2, 0, 0, 0.98)")
    headset.call("timeline")
    headset.move("right", [0.35, 1.1, -0.4])
    save(look(headset), target / "headset-timeline.jpg")

    hold(headset)
    save(pages(headset), target / "headset-palette.jpg")
    save(floor(headset, server, place), target / "headset-floor.jpg")

    headset.click("palette", "Labels")
    headset.lay_down_controllers()
    hold(headset)
    for shown in ("timeline", "palette"):
        headset.call(shown)
    hold(headset)
    save(look(headset), target / "headset-hands.jpg")
    headset.bare = False
    headset.ask("(device.primaryInputMode = 'controller')")
    headset.until("hs.headset.cockpit.pointers.of('right')?.kind.name === 'controller'")

    headset.ask(f"(pb.state.activeLabel.value = {dust})")
    headset.frames(4)
    headset.click("timeline", "To end")
    headset.until("hs.doubt().halted !== null", PATIENCE)
    hold(headset)
    headset.move("left", OUT_OF_SIGHT)
    save(look(headset), target / "headset-doubt.jpg")

    headset.click("question", "Later")
    headset.click("timeline", "Hide")
    for name in ("View", "Doll", "Put away"):
        headset.click("palette", name)
    hold(headset)
    headset.move("left", LOW)
    save(look(headset), target / "headset-doll.jpg")
    headset.close()
