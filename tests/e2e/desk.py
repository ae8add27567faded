"""A page in Chromium, and what a person does with it."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from playwright.sync_api import Browser, ConsoleMessage, Error, Page, ViewportSize

from tests.e2e.chromium import TOUR_LEFT, UNDRAWN
from tests.waiting import PATIENCE

RESULTS = Path(__file__).parents[2] / "test-results"
SIZE = (1280, 720)
EVERY = 10
"""Milliseconds between two looks at the page."""


class Desk:
    """One browser window.  Everything the page complains about is kept in ``complaints``."""

    hooks = "const pb = window.__pointbrush;"
    """Names that expressions use."""

    def __init__(
        self,
        page: Page,
        url: str,
        scripts: Sequence[str] = (UNDRAWN, TOUR_LEFT),
        size: tuple[int, int] = SIZE,
    ) -> None:
        """Load ``url``, which runs ``scripts`` before its own."""
        self.page = page
        self.context = page.context
        self.context.set_default_timeout(1e3 * PATIENCE)
        for script in scripts:
            self.page.add_init_script(script)
        if size != SIZE:
            self.page.set_viewport_size({"width": size[0], "height": size[1]})
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
        script = f"() => {{ {self.hooks} return ({expression}); }}"
        text = self.page.evaluate(f"JSON.stringify(({script})()) ?? 'null'")
        return json.loads(text)

    def until(self, expression: str, patience: float = PATIENCE, *, first: str = "") -> Any:
        """Evaluate the statements ``first``, and wait for an expression; returns its value."""
        deadline = time.monotonic() + patience
        while not (value := self._wait(expression, deadline - time.monotonic(), first)):
            if time.monotonic() > deadline:
                raise AssertionError(f"the page never came to: {expression}; {self.summary()}")
            first = ""
        return value

    def _wait(self, expression: str, seconds: float, first: str) -> Any:
        """Wait in the page until an expression is true or the time is over; returns its value."""
        script = f"""async () => {{
          const end = performance.now() + {1e3 * seconds};
          {first}
          for (;;) {{
            {self.hooks}
            const value = ({expression});
            if (value || performance.now() >= end) return JSON.stringify(value) ?? 'null';
            await new Promise((done) => setTimeout(done, {EVERY}));
          }}
        }}"""
        try:
            return json.loads(self.page.evaluate(script))
        except Error as error:
            if "context was destroyed" not in error.message:
                raise
            return None  # the page has been loaded anew: look again

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

    def close(self) -> None:
        """Close all windows of the browser profile, which another test may take."""
        for page in self.context.pages[1:]:
            page.close()


def blank_page(browser: Browser, url: str) -> Page:
    """A page in a browser profile that knows nothing of ``url`` but the files of the page.

    The first page of a profile keeps its process alive: a new one would load and compile these
    files anew, which takes longer than most tests.
    """
    address = urlsplit(url)
    origin = f"{address.scheme}://{address.netloc}"
    context = next((each for each in browser.contexts if len(each.pages) == 1), None)
    if context is None:
        viewport = ViewportSize(width=SIZE[0], height=SIZE[1])
        context = browser.new_context(viewport=viewport, accept_downloads=True)
        context.new_page().goto(f"{origin}/icon.svg")
    context.clear_cookies()
    stored = {"origin": origin, "storageTypes": "local_storage,indexeddb"}
    session = context.new_cdp_session(context.pages[0])
    session.send("Storage.clearDataForOrigin", stored)
    session.detach()
    return context.new_page()


def launch(
    browser: Browser,
    url: str,
    width: int = SIZE[0],
    height: int = SIZE[1],
    *,
    drawn: bool = False,
    newcomer: bool = False,
) -> Desk:
    """Open a window; ``drawn``: with its points in it, which a program in place of a GPU draws.

    ``newcomer``: a person who has not seen the tour of first steps.
    """
    scripts = [*([] if drawn else [UNDRAWN]), *([] if newcomer else [TOUR_LEFT])]
    return Desk(blank_page(browser, url), url, scripts, (width, height))
