"""A hand at the desk: presses keys and buttons of the real page, drags over it, and counts."""

from __future__ import annotations

import io
import math
import re
import time
from dataclasses import dataclass
from typing import Any

import httpx
import numpy as np
from numpy.typing import NDArray

from tests.e2e.desk import Desk

NOTCH = 1.15
"""Factor by which `[` and `]` change the brush."""
TRACKING_SECONDS = 600.0
"""Patience with one tracking run."""
LOOKED = 150
"""Milliseconds that the pointer rests before its preview is looked at."""


MOST_CORNERS, MOST_NOTCHES = 60, 30
"""Places that a view from above shows, and turns of the wheel to come that near."""
FILLED = 0.8
"""Part of the window that they fill."""


@dataclass
class Work:
    """What a hand did, and how long: ``seconds`` without those of ``tracking``."""

    strokes: int = 0
    clicks: int = 0
    notches: int = 0
    keys: int = 0
    seconds: float = 0.0
    tracking: float = 0.0


class Hand:
    """Works on one recording that is open in ``desk``; ``api`` is for looking, never for doing."""

    def __init__(self, desk: Desk, api: httpx.Client, sequence: str) -> None:
        self.desk, self.api, self.sequence = desk, api, sequence
        self.work = Work()
        palette = self._get("labels").json()
        self.digits = {label["id"]: str(k) for k, label in enumerate(palette, start=1)}

    # ── looking ──────────────────────────────────────────────────────────────────────────

    def _get(self, path: str) -> httpx.Response:
        return self.api.get(f"/sequences/{self.sequence}/{path}").raise_for_status()

    def _load(self, path: str) -> NDArray[Any]:
        array: NDArray[Any] = np.load(io.BytesIO(self._get(path).content))
        return array

    def labels(self, frame: int) -> NDArray[np.uint16]:
        """Labels (N,) that the server has, source order."""
        return self._load(f"frames/{frame}/annotation")

    def points(self, frame: int) -> NDArray[np.float32]:
        """Coordinates (N, 3), source order."""
        xyz: NDArray[np.float32] = self._load(f"frames/{frame}/points")["xyz"]
        return xyz

    @property
    def offered(self) -> dict[str, Any] | None:
        """What the object tool shows."""
        view: dict[str, Any] | None = self.desk.ask("pb.state.object.value")
        return view

    # ── doing ────────────────────────────────────────────────────────────────────────────

    def key(self, name: str, times: int = 1) -> None:
        """Press a key."""
        for _ in range(times):
            self.desk.press(name)
        self.work.keys += times

    def button(self, name: str, *, exact: bool = True) -> None:
        """Click on a button of the page."""
        self.desk.page.get_by_role("button", name=name, exact=exact).click()
        self.work.clicks += 1

    def check(self, name: str, *, on: bool) -> None:
        """Click on a check box that is not as wanted."""
        box = self.desk.page.get_by_role("checkbox", name=name, exact=True)
        if box.is_checked() != on:
            box.click()
            self.work.clicks += 1

    def wheel(self, notches: int) -> None:
        """Turn the wheel, away from oneself where positive."""
        step = int(math.copysign(1, notches))
        for _ in range(abs(notches)):
            self.desk.page.mouse.wheel(0, -100 * step)
        self.work.notches += abs(notches)

    def go(self, frame: int) -> None:
        """Go to a frame, by tens and ones."""
        away = frame - int(self.desk.ask("pb.state.frame.value"))
        side = "Right" if away > 0 else "Left"
        tens, ones = divmod(abs(away), 10)
        self.key(f"Shift+Arrow{side}", tens)
        self.key(f"Arrow{side}", ones)
        shown = f"pb.shown().frame === {frame} && pb.shown().points === pb.shown().total"
        self.desk.until(f"{shown} && pb.shown().total > 0")

    def choose(self, label: int) -> None:
        """Make a label the active one."""
        if self.desk.ask("pb.state.activeLabel.value") != label:
            self.key(self.digits[label])
            self.desk.until(f"pb.state.activeLabel.value === {label}")

    def tool(self, tool: str, shape: str, key: str) -> None:
        """Paint by a shape, which has a key; or erase by it."""
        if self.desk.ask("pb.state.brush.value.shape") != shape:
            self.key(key)
        if self.desk.ask("pb.state.tool.value") != tool:
            self.key("c")
        self.desk.until(
            f"pb.state.tool.value === '{tool}' && pb.state.brush.value.shape === '{shape}'"
        )

    def size(self, radius: float) -> None:
        """Bring the brush as near to a radius (metres) as its notches do."""
        now = self.desk.ask("pb.state.brush.value.radius")
        notches = round(math.log(radius / now) / math.log(NOTCH))
        self.key("]" if notches > 0 else "[", abs(notches))

    def drag(self, path: NDArray[np.floating]) -> None:
        """Draw over places (n, 3) with the button held."""
        mouse, places = self.desk.page.mouse, [self.desk.place(place) for place in path.tolist()]
        mouse.move(*places[0])
        mouse.down()
        for place in places[1:]:
            mouse.move(*place)
        mouse.up()
        self.work.strokes += 1
        self.desk.settled()

    def outline(self, corners: NDArray[np.float64]) -> None:
        """Draw round corners (n, 2), pixels of the window, with the button held."""
        mouse = self.desk.page.mouse
        mouse.move(*corners[0].tolist())
        mouse.down()
        for corner in [*corners[1:], corners[0]]:
            mouse.move(*corner.tolist())
        mouse.up()
        self.work.strokes += 1
        self.desk.settled()

    def look_down(self, wanted: NDArray[np.bool_]) -> None:
        """Look from above, as near as shows all of what is wanted of the first frame."""
        self.button("Top")
        self._rest()
        places = self.points(0)[wanted]
        around = places[:: -(-len(places) // MOST_CORNERS)].astype(np.float64)
        box = self.desk.page.locator("#view").bounding_box()
        assert box is not None
        width, height = box["width"], box["height"]
        self.desk.page.mouse.move(box["x"] + width / 2, box["y"] + height / 2)
        while self.work.notches < MOST_NOTCHES:
            seen = np.array([self.desk.place(place.tolist()) for place in around])
            seen -= [box["x"] + width / 2, box["y"] + height / 2]
            if (np.abs(seen) > FILLED * np.array([width, height]) / 2).any():
                break
            self.wheel(1)
            self._rest()
        self.wheel(-1)
        self._rest()

    def _rest(self) -> None:
        """Wait until the camera has come to rest."""
        self.desk.page.wait_for_timeout(LOOKED)
        self.desk.until("!pb.engine.camera.flying")

    def point_at(self, place: NDArray[np.floating]) -> None:
        """Rest the pointer on a place (3,)."""
        self.desk.page.mouse.move(*self.desk.place([float(v) for v in place]))
        self.desk.page.wait_for_timeout(LOOKED)

    def click(self, *, removes: bool = False) -> None:
        """Click where the pointer is."""
        keyboard, mouse = self.desk.page.keyboard, self.desk.page.mouse
        if removes:
            keyboard.down("Alt")
            self.work.keys += 1
        mouse.down()
        mouse.up()
        if removes:
            keyboard.up("Alt")
        self.work.clicks += 1
        self.desk.page.wait_for_timeout(LOOKED)
        self.desk.settled()

    def track(self, labels: list[int], names: dict[int, str], stop: int) -> None:
        """Carry labels from the frame on screen to another, by the form, and wait."""
        self.button("Track…")
        boxes = self.desk.page.get_by_role("dialog", name="Track labels")
        for label, name in names.items():
            box = boxes.get_by_role("checkbox", name=name, exact=True)
            if box.count() and box.is_checked() != (label in labels):
                box.click()
                self.work.clicks += 1
        target = boxes.get_by_label("To", exact=True)
        if target.input_value() != str(stop):
            target.fill(str(stop))
            self.work.keys += len(str(stop))
        before = {job["id"] for job in self._jobs()}
        boxes.get_by_role("button", name=re.compile(r"^Track \d")).click()
        self.work.clicks += 1
        begun = time.perf_counter()
        while not (mine := [job for job in self._jobs() if job["id"] not in before]) or (
            mine[0]["state"] in ("queued", "running")
        ):
            if time.perf_counter() - begun > TRACKING_SECONDS:
                raise TimeoutError(f"tracking to frame {stop} did not end")
            time.sleep(0.1)
        if mine[0]["state"] != "done":
            raise RuntimeError(f"tracking {mine[0]['state']}: {mine[0]['error']}")
        spent = time.perf_counter() - begun
        self.work.tracking += spent
        self.work.seconds -= spent

    def _jobs(self) -> list[dict[str, Any]]:
        jobs: list[dict[str, Any]] = self.api.get("/jobs").raise_for_status().json()
        return [job for job in jobs if job["kind"] == "tracking"]
