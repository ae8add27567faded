"""An emulated headset in Chromium: the npm package iwer as the page's WebXR runtime."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser

from tests.e2e.chromium import TOUR_LEFT, UNDRAWN
from tests.e2e.desk import SIZE, Desk, blank_page

IWER = (
    Path(__file__).parents[2] / "webxr_client" / "node_modules" / "iwer" / "build" / "iwer.min.js"
)

# Attempts to bring a ray to a control of a panel that moves.
POINTING_TRIES = 5

# Lengths of the pulses that tell what is felt, milliseconds.
PAINTING = 25
TICK = 6

QUEST = "new IWER.XRDevice(IWER.metaQuest3, { stereoEnabled: true })"
VIVE = """(() => {
  const gamepad = {
    mapping: 'xr-standard',
    buttons: [
      { id: 'trigger', type: 'analog', eventTrigger: 'select' },
      { id: 'squeeze', type: 'binary', eventTrigger: 'squeeze' },
      { id: 'touchpad', type: 'binary' },
    ],
    axes: [{ id: 'touchpad', type: 'x-axis' }, { id: 'touchpad', type: 'y-axis' }],
  };
  const layout = { gamepad, numHapticActuators: 1 };
  const controllerConfig = {
    profileId: 'htc-vive',
    fallbackProfileIds: ['generic-trigger-squeeze-touchpad'],
    layout: { left: layout, right: layout },
  };
  const config = { ...IWER.metaQuest3, name: 'Vive', controllerConfig };
  return new IWER.XRDevice(config, { stereoEnabled: true });
})()"""

# A person who has left the first minute, which begins by itself once in each browser.
GUIDED = (
    "if (location.origin !== 'null') localStorage['pointbrush.headset'] ??= '{\"guide\":false}';"
)

# Every pulse is noted: strength and milliseconds, for both hands together.
SPY = """
  window.pulses = [];
  for (const hand of ['left', 'right']) {
    const { gamepad } = device.controllers[hand].inputSource;
    const felt = (strength, milliseconds) => window.pulses.push({ hand, strength, milliseconds });
    const refused = () => Promise.reject(new DOMException('not visible', 'InvalidStateError'));
    const actuators = HAPTICS;
    for (const name of ['hapticActuators', 'vibrationActuator'])
      Object.defineProperty(gamepad, name, { value: actuators[name] });
  }
"""
PULSING = "{ pulse: (power, ms) => { felt(power, ms); return Promise.resolve(true); } }"
RUMBLING = """{ effects: ['dual-rumble'], playEffect: (_, { strongMagnitude, duration }) => {
  felt(strongMagnitude, duration);
  return Promise.resolve('complete');
} }"""
HAPTICS = {
    "Quest Browser": f"{{ hapticActuators: [{PULSING}] }}",
    "Chromium": f"{{ vibrationActuator: {RUMBLING} }}",
    "Firefox": "{ hapticActuators: [{ pulse: refused }] }",
    "Safari": "{ vibrationActuator: null }",
}
"""What a controller's gamepad has for pulses, by browser; what it has not is undefined there."""


def runtime(device: str, haptics: str = "Quest Browser") -> str:
    return f"""{IWER.read_text()};
(() => {{
  const device = {device};
  device.installRuntime({{ forceInstall: true }});
  window.device = device;
  // The emulated session always says no, whatever its device has.
  Object.defineProperty(XRSession.prototype, 'isSystemKeyboardSupported', {{
    get: () => device.isSystemKeyboardSupported,
  }});
  {SPY.replace("HAPTICS", HAPTICS[haptics])}
}})();"""


class Headset(Desk):
    """A desk whose page runs in a headset; poses are given in the headset's own space."""

    hooks = Desk.hooks + "const hs = window.__pointbrushHeadset;"

    bare = False
    """Hands without controllers are what is moved: a pinch stands for the trigger."""

    # ── session ──────────────────────────────────────────────────────────────────────────

    def ready(self) -> None:
        # Drawing in software is slow, and what is drawn is for the eyes.
        self.until("window.__pointbrush !== undefined")
        self.ask("pb.setDrawing(false)")
        super().ready()

    def enter(self) -> None:
        self.page.get_by_role("button", name="Enter VR").click()
        self.until("hs.headset.cockpit && hs.frames() > 2")

    def frames(self, count: int = 2) -> None:
        """Let some pictures pass: what a test sets arrives with the next one."""
        self.act("", count)

    def act(self, action: str, count: int = 2) -> None:
        """Run statements in the page, and let some pictures pass."""
        first = f"{self.hooks} const seen = hs.frames(); {action};"
        self.until(f"hs.frames() >= seen + {count}", first=first)

    def hides_model(self, panel: str) -> bool:
        """Whether a panel is before the recording's box, or behind it, for the eyes."""
        value: bool = self.ask(
            f"""(() => {{
              const {{ viewer }} = pb.engine, {{ rig }} = hs.headset.cockpit;
              const seen = (places) => {{
                const to = places.map(([x, y, z]) => rig.headInRig.clone().set(x, y, z));
                for (const way of to) way.sub(rig.headInRig);
                const across = to.map(({{ x, z }}) => Math.atan2(x, -z));
                const up = to.map(({{ x, y, z }}) => Math.atan2(y, Math.hypot(x, z)));
                return [across, up].map((angles) => [Math.min(...angles), Math.max(...angles)]);
              }};
              const ends = viewer.bounds(pb.state.sequence.value), pick = [0, 1];
              const corners = pick.flatMap((i) => pick.flatMap((j) => pick.map((k) => {{
                const at = viewer.world.localToWorld(
                  ends[0].clone().set(ends[i].x, ends[j].y, ends[k].z));
                return rig.group.worldToLocal(at).toArray();
              }})));
              const edges = pick.flatMap((u) => pick.map((v) => hs.onPanel('{panel}', u, v).at));
              const [model, board] = [seen(corners), seen(edges)];
              return pick.every((k) => model[k][0] < board[k][1] && board[k][0] < model[k][1]);
            }})()"""
        )
        return value

    # ── hands ────────────────────────────────────────────────────────────────────────────

    def move(self, hand: str, at: list[float], to: list[float] | None = None) -> None:
        """Hold a controller at a place, pointing to another one (ahead, if none is given)."""
        x, y, z = at
        self.act(self.posing(hand, json.dumps(at), json.dumps(to or [x, y, z - 1.0])))

    def posing(self, hand: str, at: str, to: str) -> str:
        """Return the statements that hold a controller at ``at``, pointing to ``to``."""
        return f"""
            const c = device.{"hands" if self.bare else "controllers"}.{hand};
            const [x, y, z] = {at}, [tx, ty, tz] = {to};
            c.position.set(x, y, z);
            const d = [tx - x, ty - y, tz - z], n = Math.hypot(...d);
            const yaw = Math.atan2(-d[0], -d[2]), pitch = Math.asin(d[1] / n);
            const [cy, sy] = [Math.cos(yaw / 2), Math.sin(yaw / 2)];
            const [cp, sp] = [Math.cos(pitch / 2), Math.sin(pitch / 2)];
            c.quaternion.set(cy * sp, sy * cp, -sy * sp, cy * cp)"""

    def trigger(self, value: float, hand: str = "right") -> None:
        self.act(self.pressing(value, hand))

    def pressing(self, value: float, hand: str = "right") -> str:
        """Return the expression that presses the trigger, or pinches."""
        if self.bare:
            return f"device.hands.{hand}.updatePinchValue({value})"
        return f"device.controllers.{hand}.updateButtonValue('trigger', {value})"

    def lay_down_controllers(self) -> None:
        """Go on with bare hands."""
        self.bare = True
        self.ask("(device.primaryInputMode = 'hand')")
        self.until("hs.headset.cockpit.pointers.of('right')?.kind.name === 'hand'")

    def button(self, name: str, hand: str = "right") -> None:
        """Press and let go."""
        for value in (1, 0):
            self.act(f"device.controllers.{hand}.updateButtonValue('{name}', {value})")

    def lean(self, x: float, y: float, hand: str = "right", pad: str = "thumbstick") -> None:
        self.act(f"device.controllers.{hand}.updateAxes('{pad}', {x}, {y})")

    def flick(self, x: float, y: float, hand: str = "right", pad: str = "thumbstick") -> None:
        """Push for a single picture: held longer, as by a slow machine, it would run."""
        self.for_a_picture(
            f"device.controllers.{hand}.updateAxes('{pad}', {x}, {y})",
            f"device.controllers.{hand}.updateAxes('{pad}', 0, 0)",
        )

    def push(self, x: float, y: float, pad: str, hand: str = "right") -> None:
        """Lean a stick for a single picture; a touchpad is pressed there as well."""
        controller = f"device.controllers.{hand}"
        begin, end = (f"{controller}.updateAxes('{pad}', {a}, {b})" for a, b in ((x, y), (0, 0)))
        if pad == "touchpad":
            begin += f"; {controller}.updateButtonValue('{pad}', 1)"
            end += f"; {controller}.updateButtonValue('{pad}', 0)"
        self.for_a_picture(begin, end)

    def for_a_picture(self, begin: str, end: str) -> None:
        """Run the statements ``begin``, and ``end`` right behind the next picture."""
        self.act(
            f"""{begin};
            while (hs.frames() === seen) await new Promise((done) => setTimeout(done));
            {end}""",
            3,
        )

    def hand_to(self, hand: str, point: list[float]) -> None:
        """Bring the place where a bare hand pinches to a point of the headset's space."""
        self.frames()
        for _ in range(3):
            self.act(
                f"""const tip = hs.headset.cockpit.painter.tip.clone();
                hs.headset.cockpit.rig.group.worldToLocal(tip);
                const [x, y, z] = {json.dumps(point)}, at = device.hands.{hand}.position;
                at.set(at.x + x - tip.x, at.y + y - tip.y, at.z + z - tip.z)"""
            )

    # ── what people do ───────────────────────────────────────────────────────────────────

    def set_radius(self, metres: float) -> None:
        self.act(f"pb.state.brush.value = {{ ...pb.state.brush.value, radius: {metres} }}")

    def reach(self, point: list[float], hand: str = "right") -> None:
        """Bring the ball's middle to a point of the recording (source coordinates)."""
        at = f"(([x, y, z]) => [x, y, z + hs.tipAhead()])(hs.place({json.dumps(point)}))"
        self.act(self.posing(hand, at, "[x, y, z - 1]"))

    def paint(self, points: list[list[float]], *, release: bool = True) -> None:
        self.reach(points[0])
        self.trigger(1)
        for point in points[1:]:
            self.reach(point)
        if release:
            self.trigger(0)

    def call(self, panel: str, hand: str = "right") -> None:
        """Rest a ray on a panel's handle, if it is folded, until it has unfolded."""
        if self.ask(f"hs.open('{panel}')"):
            return
        self.until(f"hs.areas('{panel}').length > 0")
        area = self.ask(f"hs.areas('{panel}')[0]")
        self.point(panel, area["x"] + area["w"] / 2, area["y"] + area["h"] / 2, hand)
        self.until(f"hs.open('{panel}') && hs.areas('{panel}').length > 0")

    def click(self, panel: str, name: str, hand: str = "right") -> None:
        """Point at something on a panel by its name, and press.

        A panel follows the head and the hand, so it may move while the ray is on its way: point
        again until the ray meets the control.
        """
        met = f"hs.pointedAt('{panel}') === {json.dumps(name)}"
        for _ in range(POINTING_TRIES):
            self.call(panel, hand)
            there = f"hs.areas('{panel}').some((area) => area.name === {json.dumps(name)})"
            self.until(f"!hs.headset.cockpit.panels.{panel}.dirty && {there}")
            self.point_at(panel, name, 0.5, hand)
            if self.ask(met):
                break
        self.trigger(1, hand)
        self.trigger(0, hand)

    def slide(self, panel: str, name: str, start: float, stop: float | None = None) -> None:
        """Press at a share of something's width, and drag to another one."""
        self.point_at(panel, name, start)
        self.trigger(1)
        if stop is not None:
            self.point_at(panel, name, stop)
        self.trigger(0)

    def point_at(self, panel: str, name: str, share: float, hand: str = "right") -> None:
        """Point at a share of the width of what has a name on a panel."""
        self.call(panel, hand)
        areas = self.ask(f"hs.areas('{panel}')")
        area = next(area for area in areas if area["name"] == name)
        self.point(panel, area["x"] + area["w"] * share, area["y"] + area["h"] / 2, hand)

    def point(self, panel: str, u: float, v: float, hand: str = "right") -> None:
        place = f"const place = hs.onPanel('{panel}', {u}, {v});"
        self.act(place + self.posing(hand, "place.out", "place.at"))

    def flick_to_frame(self, frame: int) -> None:
        self.ask(f"pb.engine.playback.seek({frame})")
        self.until(f"pb.shown().frame === {frame} && pb.shown().points === pb.shown().total")

    def pulses(self) -> list[dict[str, Any]]:
        """What the hands felt since this was last asked."""
        felt: list[dict[str, Any]] = self.ask("window.pulses.splice(0)")
        return felt


Wear = Callable[..., Headset]
"""Puts a device on, one that is given or a Quest 3, and enters the recording."""


def wear(
    browser: Browser,
    url: str,
    device: str = QUEST,
    size: tuple[int, int] = SIZE,
    haptics: str = "Quest Browser",
    *,
    drawn: bool = False,
    newcomer: bool = False,
) -> Headset:
    """A headset on a page of its own; ``drawn``: its pictures are (see ``launch``).

    ``newcomer``: a person who has not been led through the first minute.
    """
    scripts = [runtime(device, haptics), TOUR_LEFT]
    if not drawn:
        scripts.append(UNDRAWN)
    if not newcomer:
        scripts.append(GUIDED)
    return Headset(blank_page(browser, url), url, scripts, size)
