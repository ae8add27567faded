"""Input sources that the emulator lacks, put in where the browser hands them to a page.

``window.inputs`` lets sources come, move, select and go as the WebXR specification describes it: in
``session.inputSources``, with ``inputsourceschange`` and the events of a selection.
"""

from __future__ import annotations

import json

from tests.e2e.headset import Headset

INPUTS = """
  const there = new Map();
  const { get } = Object.getOwnPropertyDescriptor(XRSession.prototype, 'inputSources');
  Object.defineProperty(XRSession.prototype, 'inputSources', {
    get() { return [...get.call(this), ...[...there.values()].map(({ source }) => source)]; },
  });
  const [SPACE] = Object.getOwnPropertySymbols(device.viewerSpace);
  const origin = device.viewerSpace[SPACE].parentSpace;
  const tell = (type, fields) => {
    const session = window.__pointbrush.engine.viewer.renderer.xr.getSession();
    session.dispatchEvent(Object.assign(new Event(type), { session, frame: null, ...fields }));
  };
  window.inputs = {
    /** A source of a target ray mode; `source` puts in one that there is. */
    come(name, mode, side, profile, source = null) {
      const ray = new XRSpace(origin);
      const grip = mode === 'transient-pointer' ? new XRSpace(origin) : undefined;
      source ??= new XRInputSource(side, mode, [profile], ray, undefined, grip, undefined);
      there.set(name, { source, ray, grip });
      tell('inputsourceschange', { added: [source], removed: [] });
    },
    /** The ray begins at `at` and points to `to`; it is held at `held`. */
    move(name, at, to, held) {
      const { ray, grip } = there.get(name);
      const [x, y, z] = at.map((value, i) => value - to[i]);
      const long = Math.hypot(x, y, z), level = Math.hypot(x, z) || 1;
      const right = [z / level, 0, -x / level], back = [x / long, y / long, z / long];
      const up = [0, 1, 2].map((i) => {
        const [j, k] = [(i + 1) % 3, (i + 2) % 3];
        return back[j] * right[k] - back[k] * right[j];
      });
      ray[SPACE].offsetMatrix.set([...right, 0, ...up, 0, ...back, 0, ...at, 1]);
      grip?.[SPACE].offsetMatrix.set([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, ...held, 1]);
    },
    select(name, down) {
      tell(down ? 'selectstart' : 'selectend', { inputSource: there.get(name).source });
    },
    go(name) {
      const { source } = there.get(name);
      there.delete(name);
      tell('inputsourceschange', { added: [], removed: [source] });
    },
  };
"""

EYES = [0.0, 1.6, 0.0]
HELD = [0.2, 1.2, -0.3]
MOMENTARY = ("transient-pointer", "screen")
"""Modes of sources that come with a press, already pressed, and go with its end."""


def inject(headset: Headset) -> None:
    """Let the page's session take sources from ``Input``."""
    headset.ask(f"(() => {{ {INPUTS} }})()")


def eyes_alone(headset: Headset) -> None:
    """Switch the controllers off: sources of ``Input`` alone point, no hand holds the palette."""
    inject(headset)
    for side in ("left", "right"):
        headset.ask(f"(device.controllers.{side}.connected = false)")
    headset.until("hs.pointers().length === 0 && hs.headset.cockpit.panels.hangs")


class Input:
    """One source of the kinds that come and go with a press, or that only look."""

    def __init__(
        self, headset: Headset, name: str, mode: str, side: str = "none", profile: str = "acme"
    ) -> None:
        self.headset, self.name, self.moving = headset, name, ""
        words = ", ".join(json.dumps(word) for word in (name, mode, side, profile))
        self.coming = f"window.inputs.come({words})"
        """What lets it come; empty once it is there."""
        if mode not in MOMENTARY:
            self.come()

    def come(self, then: str = "null") -> None:
        self.headset.ask(f"({self.coming or 'null'}, {then})")
        self.coming = ""

    def move(self, to: list[float], held: list[float] | None = None) -> None:
        """Look from the eyes to a place of the room, where a momentary source presses."""
        words = ", ".join(json.dumps(at) for at in (EYES, to, held or HELD))
        self.moving = f"window.inputs.move('{self.name}', {words})"
        if not self.coming:
            self.headset.ask(self.moving)
            self.headset.frames()

    def look(self, point: list[float]) -> None:
        """Look at a point of the recording (source coordinates)."""
        self.move(self.headset.ask(f"hs.place({json.dumps(point)})"))

    def call(self, panel: str) -> None:
        """Look at a panel's handle and press, if it is folded."""
        if self.headset.ask(f"hs.open('{panel}')"):
            return
        self.headset.until(f"hs.areas('{panel}').length > 0")
        area = self.headset.ask(f"hs.areas('{panel}')[0]")
        u, v = area["x"] + area["w"] / 2, area["y"] + area["h"] / 2
        self.move(self.headset.ask(f"hs.onPanel('{panel}', {u}, {v})")["at"])
        for down in (True, False):
            self.select(down)
        self.headset.until(f"hs.open('{panel}') && hs.areas('{panel}').length > 0")

    def look_at(self, panel: str, name: str, share: float = 0.5) -> None:
        """Look at a share of the width of what has a name on a panel, called if it is folded."""
        self.call(panel)
        areas = self.headset.ask(f"hs.areas('{panel}')")
        area = next(area for area in areas if area["name"] == name)
        u, v = area["x"] + area["w"] * share, area["y"] + area["h"] / 2
        self.move(self.headset.ask(f"hs.onPanel('{panel}', {u}, {v})")["at"])

    def select(self, down: bool) -> None:
        select = f"window.inputs.select('{self.name}', {json.dumps(down)})"
        self.come(f"{self.moving}, {select}" if self.coming else select)
        self.headset.frames()

    def go(self) -> None:
        self.headset.ask(f"window.inputs.go('{self.name}')")
        self.headset.frames()
