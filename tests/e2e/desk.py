"""A page in Chromium, and what a person does with it."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, BrowserContext, ConsoleMessage, Page

from tests.e2e.chromium import TOUR_LEFT, UNDRAWN
from tests.waiting import PATIENCE

RESULTS = Path(__file__).parents[2] / "test-results"


class Desk:
    """One browser window.  Everything the page complains about is kept in ``complaints``."""

    def __init__(self, context: BrowserContext, url: str, *, newcomer: bool = False) -> None:
        self.context = context
        context.set_default_timeout(1e3 * PATIENCE)
        if not newcomer:
            context.add_init_script(TOUR_LEFT)
        self.page: Page = context.new_page()
        self.complaints: list[str] = []
        self.page.on("console", self._console)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.goto(url)

    def _console(self, message: ConsoleMessage) -> None:
        if message.type == "error":
            self.complaints.append(message.text)

    # ── looking ──────────────────────────────────────────────────────────────────────────

    def ask(self, expression: str) -> Any:
        """The value of an expression over ``pb``, the page's test hook."""
        script = f"() => {{ const pb = window.__pointbrush; return ({expression}); }}"
        text = self.page.evaluate(f"JSON.stringify(({script})()) ?? 'null'")
        return json.loads(text)

    def until(self, expression: str, patience: float = PATIENCE) -> Any:
        """Wait for an expression to hold; returns its value."""
        deadline = time.monotonic() + patience
        while not (value := self.ask(expression)):
            if time.monotonic() > deadline:
                raise AssertionError(f"the page never came to: {expression}; {self.summary()}")
            self.page.wait_for_timeout(30)
        return value

    def summary(self) -> str:
        asked = "[pb.shown(), pb.counters(), pb.state.connection.value, pb.state.notices.value]"
        return f"{self.ask(asked)} {self.complaints}"

    def ready(self) -> None:
        """The open recording's frame is complete on screen."""
        self.until(
            "window.__pointbrush && pb.shown().total > 0 && pb.shown().drawn === pb.shown().total"
        )
        # Panels and headset come after the first picture.
        self.until("window.__pointbrushHeadset !== undefined")

    def labels(self, frame: int | None = None) -> dict[int, int]:
        counts = self.ask(f"pb.labels({'' if frame is None else frame})")
        return {int(label): count for label, count in counts.items()}

    def screenshot(self, name: str) -> Path:
        RESULTS.mkdir(exist_ok=True)
        path = RESULTS / f"{name}.png"
        self.page.screenshot(path=path)
        return path

    # ── doing ────────────────────────────────────────────────────────────────────────────

    def place(self, point: list[float]) -> tuple[float, float]:
        """Where a point (source coordinates) is in the window."""
        x, y = self.ask(f"pb.project({json.dumps(point)})")
        box = self.page.locator("#view").bounding_box()
        assert box is not None
        return box["x"] + x, box["y"] + y

    def paint(self, points: list[list[float]], *, release: bool = True) -> None:
        """Drag with the left button over places in the room."""
        mouse = self.page.mouse
        mouse.move(*self.place(points[0]))
        mouse.down()
        for point in points[1:]:
            mouse.move(*self.place(point), steps=4)
        if release:
            mouse.up()

    def settled(self) -> None:
        """The server has answered every edit."""
        self.until("pb.state.pending.value === 0")

    def pictures(self, count: int = 8) -> None:
        """Wait for this many more pictures, in tests that nothing changes."""
        self.page.evaluate(
            """count => new Promise((resolve) => {
              const next = () => (count-- > 0 ? requestAnimationFrame(next) : resolve());
              next();
            })""",
            count,
        )

    def press(self, keys: str) -> None:
        self.page.keyboard.press(keys)


def launch(
    browser: Browser,
    url: str,
    width: int = 1280,
    height: int = 720,
    *,
    drawn: bool = False,
    newcomer: bool = False,
) -> Desk:
    """Open a window; ``drawn``: with its points in it, which a program in place of a GPU draws.

    ``newcomer``: somebody who has not seen the tour of first steps.
    """
    context = browser.new_context(
        viewport={"width": width, "height": height}, accept_downloads=True
    )
    if not drawn:
        context.add_init_script(UNDRAWN)
    return Desk(context, url, newcomer=newcomer)
