"""In the headset: every kind of input, alone, side by side, coming and going."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable

import pytest
from playwright.sync_api import Browser

from tests.e2e.headset import QUEST, VIVE, Headset, Wear, wear
from tests.e2e.inputs import Input, eyes_alone, inject
from tests.e2e.recording import PERSON, SEQUENCE, Truth, painted
from tests.e2e.server import LiveServer
from tests.waiting import eventually

PALETTE = "hs.headset.cockpit.panels.palette.mesh"
WORLD = "pb.engine.viewer.world"
SAID = "hs.headset.cockpit.hud.sign.text"
HANDOVER = "hs.headset.cockpit.pointers.handover"


def lay_down(headset: Headset, *sides: str) -> None:
    """Switch controllers off."""
    for side in sides:
        headset.ask(f"(device.controllers.{side}.connected = false)")
        headset.until(f"hs.pointers().every((one) => one.side !== '{side}')")


def roles(headset: Headset) -> dict[str, str]:
    """Role → the side and kind of what has it."""
    return {
        role: f"{one['side']} {one['kind']}"
        for one in headset.ask("hs.pointers()")
        for role in one["roles"]
    }


def test_what_has_no_place_paints_where_its_ray_hits_and_drags_at_that_depth(
    put_on: Wear, server: LiveServer, truth: Truth
) -> None:
    headset = put_on()
    eyes_alone(headset)
    # The palette's handle hangs beside the timeline's: eyes and a pinch call it and put it away.
    headset.until(f"{PALETTE}.visible")
    look = Input(headset, "away", "transient-pointer", "right")
    look.look_at("palette", "Put away")
    look.select(True)
    look.select(False)
    look.go()
    headset.until("!hs.open('palette')")
    x, y, z = truth(0, PERSON)
    before = 0
    for mode, up in (("transient-pointer", 0.0), ("screen", 0.15), ("gaze", 0.3)):
        source = Input(headset, mode, mode, "right" if mode == "transient-pointer" else "none")
        source.look([x, y + up, z])
        source.select(True)
        headset.until(f"(pb.labels()[1] ?? 0) > {before}")
        source.look([x, y + up + 0.05, z])
        headset.frames(3)
        source.select(False)
        source.go()
        headset.settled()
        count = painted(server, 0)
        assert count > before + 3, mode
        before = count
    assert roles(headset) == {}
    # A lasso is drawn in the air, and closed by the pinch that goes with its source.
    headset.ask("(pb.state.brush.value = { ...pb.state.brush.value, shape: 'lasso' })")
    look = Input(headset, "lasso", "transient-pointer", "right")
    look.look([x - 0.3, y - 0.4, z])
    look.select(True)
    for dx, dy in ((0.3, -0.4), (0.3, 0.1), (-0.3, 0.1)):
        look.look([x + dx, y + dy, z])
    headset.ask("(window.inputs.select('lasso', false), window.inputs.go('lasso'))")
    headset.frames(4)
    headset.settled()
    assert painted(server, 0) > before


def test_look_and_pinch_scrubs_moves_scales_and_undoes_nothing_by_itself(
    put_on: Wear, server: LiveServer, truth: Truth
) -> None:
    headset = put_on()
    eyes_alone(headset)
    look = Input(headset, "right", "transient-pointer", "right")
    look.look_at("timeline", "ruler", 0.05)
    look.select(True)
    look.look_at("timeline", "ruler", 0.95)
    look.select(False)
    look.go()
    headset.until("pb.state.frame.value === 5 && pb.shown().frame === 5")
    # Two pinches: the left one takes hold, the right one joins in; apart they scale the room.
    hands = {side: Input(headset, side, "transient-pointer", side) for side in ("left", "right")}
    for side, at in (("left", -0.1), ("right", 0.1)):
        hands[side].move([at, 2.5, -1.0], [at, 1.2, -0.4])
        hands[side].select(True)
    for side, at in (("left", -0.2), ("right", 0.2)):
        hands[side].move([at, 2.5, -1.0], [at, 1.2, -0.4])
    for source in hands.values():
        source.select(False)
        source.go()
    assert abs(headset.ask(f"{WORLD}.scale.x") - 2) < 0.1
    headset.settled()
    assert painted(server, 5) == 0


def test_who_comes_and_goes_never_leaves_one_without_a_brush(
    put_on: Wear, server: LiveServer, truth: Truth
) -> None:
    headset = put_on()
    inject(headset)
    both = {"brush": "right controller", "other": "left controller", "palette": "left controller"}
    assert roles(headset) == both
    # A hand beside the controller of its side takes nothing from it.
    bare = "device.hands.right.inputSource"
    headset.ask(f"window.inputs.come('bare', '', '', '', {bare})")
    assert roles(headset) == both
    x, y, z = truth(0, PERSON)
    headset.paint([[x, y, z]])
    headset.settled()
    first = painted(server, 0)
    assert first > 5
    headset.ask("window.inputs.go('bare')")
    headset.frames()
    assert roles(headset) == both
    # One controller alone paints, also the left one of somebody who is right-handed.
    lay_down(headset, "right")
    headset.until(f"{SAID}?.endsWith('The left controller paints now')")
    assert roles(headset) == {"brush": "left controller"}
    headset.reach([x, y + 0.2, z], "left")
    headset.trigger(1, "left")
    headset.trigger(0, "left")
    headset.settled()
    second = painted(server, 0)
    assert second > first
    # One that wakes with its trigger held paints once that was let go.
    headset.ask("device.controllers.right.updateButtonValue('trigger', 1)")
    headset.reach([x, y + 0.4, z])
    headset.ask("(device.controllers.right.connected = true)")
    headset.until("hs.pointers().length === 2")
    headset.frames(4)
    # … and so does one that was held while the system's menu was open.
    headset.trigger(0)
    headset.trigger(1)
    headset.until("hs.headset.cockpit.painter.painting")
    headset.ask("device.updateVisibilityState('visible-blurred')")
    headset.until("!hs.headset.cockpit.painter.painting")
    headset.ask("device.updateVisibilityState('visible')")
    headset.reach([x, y - 0.3, z])
    headset.frames(4)
    assert not headset.ask("hs.headset.cockpit.painter.painting")
    headset.trigger(0)
    headset.settled()
    edits = server.request("GET", f"sequences/{SEQUENCE}/edits").json()
    assert len(edits) <= 4
    # What nobody knows is told in words.
    headset.ask("window.inputs.come('cap', 'brain-waves', 'none', 'acme-cap')")
    headset.until(f"{SAID} === 'Unknown kind of input:\\nbrain-waves (acme-cap)'")


def test_a_bare_hand_does_what_a_controller_does(
    put_on: Wear, server: LiveServer, truth: Truth
) -> None:
    headset = put_on()
    headset.lay_down_controllers()
    # The palette stands over the left hand: the right forefinger presses it.
    finger = "hs.headset.cockpit.pointers.of('right').fingertip.clone()"

    def poke(panel: str, name: str) -> None:
        headset.call(panel)
        headset.until(f"hs.areas('{panel}').some((area) => area.name === '{name}')")
        area = next(a for a in headset.ask(f"hs.areas('{panel}')") if a["name"] == name)
        u, v = area["x"] + area["w"] / 2, area["y"] + area["h"] / 2
        for away in (0.15, 0.04, -0.01, 0.15):
            headset.frames()
            headset.ask(
                f"""(() => {{
                  const {{ at, out }} = hs.onPanel('{panel}', {u}, {v});
                  const tip = hs.headset.cockpit.rig.group.worldToLocal({finger}).toArray();
                  const {{ position }} = device.hands.right;
                  const to = at.map((a, i) => a + (out[i] - a) * {away} / 0.2 - tip[i]);
                  position.set(position.x + to[0], position.y + to[1], position.z + to[2]);
                }})()"""
            )
            headset.frames()

    headset.move("left", [-0.2, 1.2, -0.4])
    poke("palette", "Tools")
    poke("palette", "Erase")
    headset.until("pb.state.tool.value === 'erase'")
    poke("palette", "Paint")
    poke("palette", "Object")
    headset.until("pb.state.brush.value.shape === 'object'")
    # An object by a pinch, another level of it by the palette.
    x, y, z = headset.ask(f"hs.place({truth(0, PERSON)})")
    headset.move("right", [x, y, z + 0.8], [x, y, z])
    headset.until("pb.state.object.value?.levels > 1 && pb.state.object.value.ready")
    headset.trigger(1)
    headset.trigger(0)
    headset.until("pb.state.object.value?.taken")
    headset.settled()
    first = painted(server, 0)
    level = headset.ask("pb.state.object.value.level")
    poke("palette", "Smaller" if level > 0 else "Larger")
    headset.until(f"pb.state.object.value.level !== {level}")
    headset.settled()
    headset.until(f"(pb.labels()[1] ?? 0) !== {first}")
    headset.settled()
    eventually(lambda: painted(server, 0) not in (0, first))
    # Going there: asked for on the palette, aimed by the hand, gone to with a pinch.
    poke("palette", "View")
    poke("palette", "Go there")
    before = headset.ask("hs.headset.cockpit.rig.head.toArray()")
    headset.move("right", [0.4, 1.2, -0.2], [1.4, 1.0, -0.4])
    headset.trigger(1)
    headset.trigger(0)
    after = headset.ask("hs.headset.cockpit.rig.head.toArray()")
    assert abs(after[2] - before[2]) + abs(after[0] - before[0]) > 0.5
    # Two pinches scale the room: the left one takes hold, the right one joins in.
    for side, at in (("left", -0.1), ("right", 0.1)):
        headset.move(side, [at, 1.2, -0.3], [at, 2.2, -0.3])
        headset.trigger(1, side)
    for side, at in (("left", -0.2), ("right", 0.2)):
        headset.move(side, [at, 1.2, -0.3], [at, 2.2, -0.3])
    assert headset.ask(f"{WORLD}.scale.x") > 1.5
    for side in ("left", "right"):
        headset.trigger(0, side)
    # The right hand leaves the view: a pinch of the left one paints nothing, however long it lasts.
    headset.click("palette", "Tools")
    headset.click("palette", "Ball")
    count = painted(server, 0)
    headset.trigger(1, "left")
    headset.ask("(device.hands.right.connected = false)")
    headset.until(f"{HANDOVER}.absent[0] > 1.5")
    assert "brush" not in roles(headset)
    headset.trigger(0, "left")
    headset.until(f"{SAID} === 'The left hand paints now'")
    headset.ask("(device.hands.right.connected = true)")
    headset.until(f"{SAID} === 'The right hand paints again'")
    assert roles(headset)["brush"] == "right hand"
    headset.settled()
    assert painted(server, 0) == count


def give_joints(headset: Headset, hand: str) -> None:
    """Let a held controller have a hand's joints beside its gamepad, as SteamVR gives them."""
    controller = f"device.controllers.{hand}"
    headset.ask(f"({controller}.connected = false)")
    headset.until(f"hs.pointers().every((one) => one.side !== '{hand}')")
    headset.ask(
        f"Object.defineProperty({controller}.inputSource, 'hand',"
        f" {{ value: device.hands.{hand}.inputSource.hand }}) && null"
    )
    headset.ask(f"({controller}.connected = true)")
    headset.until(f"hs.pointers().some((one) => one.side === '{hand}')")


def press_pad(headset: Headset, x: float, y: float, hand: str = "right") -> None:
    headset.ask(f"device.controllers.{hand}.updateAxes('touchpad', {x}, {y})")
    headset.frames()
    press = f"device.controllers.{hand}.updateButtonValue('touchpad', %d)"
    headset.for_a_picture(press % 1, press % 0)


def test_a_held_wand_with_joints_keeps_its_pad_and_alone_switches_labels_on_it(
    put_on: Wear, server: LiveServer, truth: Truth
) -> None:
    server.create_label(SEQUENCE, "other", "#5ea2ff")
    headset = put_on(VIVE)
    for hand in ("left", "right"):
        give_joints(headset, hand)
    both = {"brush": "right controller", "other": "left controller", "palette": "left controller"}
    assert roles(headset) == both
    lay_down(headset, "left")
    active = "pb.state.activeLabel.value"
    first = headset.ask(active)
    radius = headset.ask("pb.state.brush.value.radius")
    headset.pulses()
    # Colours mark the pad; a thumb on it shows the ring, and the name of what a press takes.
    ring = "hs.headset.cockpit.ring"
    small = f"{ring}.mesh.visible && {ring}.mesh.scale.x < 1"
    headset.until(f"{small} && !{ring}.sign.mesh.visible")
    headset.lean(0, 0.8, pad="touchpad")
    headset.until(f"!({small}) && {ring}.sign.mesh.visible")
    assert headset.ask(f"{ring}.sign.text") == "↓ other"
    assert headset.ask(active) == first
    press_pad(headset, 0, 0.8)
    headset.until(f"{active} !== {first}")
    headset.lean(0, 0, pad="touchpad")
    headset.until(small)
    # The change is shown at the brush, and felt.
    headset.until("hs.headset.cockpit.tipSign.sign.text === 'other'")
    assert "right" in {pulse["hand"] for pulse in headset.pulses()}
    press_pad(headset, 0, -0.8)
    headset.until(f"{active} === {first}")
    press_pad(headset, 0.8, 0)
    headset.until("pb.state.frame.value === 1")
    assert headset.ask("pb.state.brush.value.radius") == radius
    # A thumb that slides while it presses steps one frame back and does nothing else.
    press = "device.controllers.right.updateButtonValue('touchpad', %d)"
    headset.ask("device.controllers.right.updateAxes('touchpad', -0.8, 0)")
    headset.ask(press % 1)
    headset.until("pb.state.frame.value === 0 && pb.shown().frame === 0")
    headset.ask("device.controllers.right.updateAxes('touchpad', 0, 0.9)")
    headset.frames()
    headset.ask(press % 0)
    headset.frames()
    assert headset.ask(active) == first
    # The grip's chords are eraser and undo.
    headset.paint([truth(0, PERSON)])
    headset.settled()
    assert painted(server, 0, first) > 5
    headset.ask("device.controllers.right.updateButtonValue('squeeze', 1)")
    headset.frames()
    press_pad(headset, -0.8, 0)
    headset.ask("device.controllers.right.updateButtonValue('squeeze', 0)")
    headset.settled()
    assert painted(server, 0) == 0


@pytest.mark.parametrize("device", [QUEST, VIVE])
def test_going_somewhere_changes_no_label_wherever_one_looks(
    put_on: Wear, server: LiveServer, device: str
) -> None:
    server.create_label(SEQUENCE, "other", "#5ea2ff")
    headset = put_on(device)
    headset.move("left", [-0.2, 1.2, -0.4])
    before = headset.ask("pb.state.activeLabel.value")
    # Sixteen poses of the head: level and down to 60°, ahead and towards the palette.
    for yaw, pitch in itertools.product((0, 15, 30, -20), (0, -20, -40, -60)):
        a, b = math.radians(yaw) / 2, math.radians(pitch) / 2
        turn = (math.cos(a) * math.sin(b), math.sin(a) * math.cos(b),
                -math.sin(a) * math.sin(b), math.cos(a) * math.cos(b))  # fmt: skip
        headset.ask(f"device.quaternion.set{turn}")
        headset.frames()
        if device == VIVE:
            press_pad(headset, 0, -0.9, "left")
        else:
            headset.flick(0, -1, "left")
            headset.flick(0, 1, "left")
        headset.frames()
        assert headset.ask("pb.state.activeLabel.value") == before, (yaw, pitch)


# ── the first minute ─────────────────────────────────────────────────────────────────────────

Paint = Callable[[list[float]], None]
Click = Callable[[str, str], None]


def by_hand(headset: Headset) -> tuple[Paint, Click]:
    def paint(point: list[float]) -> None:
        if headset.bare:
            headset.hand_to("right", headset.ask(f"hs.place({point})"))
            headset.trigger(1)
            headset.trigger(0)
        else:
            headset.paint([point])

    return paint, headset.click


def by_look(headset: Headset) -> tuple[Paint, Click]:
    """Each pinch is a source of its own, which comes and goes with it."""
    number = itertools.count()

    def pinch() -> Input:
        return Input(headset, f"pinch {next(number)}", "transient-pointer", "right")

    def press(look: Input) -> None:
        look.select(True)
        look.select(False)
        look.go()

    def paint(point: list[float]) -> None:
        look = pinch()
        look.look(point)
        press(look)

    def click(panel: str, name: str) -> None:
        if not headset.ask(f"hs.open('{panel}')"):
            handle = pinch()
            handle.call(panel)
            handle.go()
        headset.until(f"hs.areas('{panel}').some((area) => area.name === {json.dumps(name)})")
        look = pinch()
        look.look_at(panel, name)
        press(look)

    return paint, click


def begin(headset: Headset, name: str) -> None:
    """Enter as a person who was never led, with what a device has in hand."""
    headset.ready()
    headset.enter()
    if name == "vive":
        lay_down(headset, "left")
    if name == "hands":
        headset.lay_down_controllers()
    if name == "look":
        eyes_alone(headset)
    headset.until("hs.taught() === 'paint'")


# Words of the hints at the controls, by device; the others have panels alone.
HINTS = {
    "vive": ("Trigger: paint", "Pad ↑ ↓: labels", "Trigger + Pad ↑: object", "Pad pressed: play"),
    "quest": (
        "Trigger: paint",
        "Stick ↑ ↓: labels",
        "Trigger + Stick ↑: object",
        "Stick pressed: play",
    ),
    "hands": ("Pinch: paint",),
    "look": (),
}


@pytest.mark.parametrize("name", HINTS)
def test_the_first_minute_is_finished_by_doing_what_it_says(
    browser: Browser, server: LiveServer, truth: Truth, name: str
) -> None:
    for label in ("person", "other"):
        server.create_label(SEQUENCE, label, "#5ea2ff")
    device, pad = (VIVE, "touchpad") if name == "vive" else (QUEST, "thumbstick")
    headset = wear(browser, server.page_url, device, newcomer=True)
    begin(headset, name)
    paint, click = by_look(headset) if name == "look" else by_hand(headset)
    hints = iter(HINTS[name])
    x, y, z = truth(0, PERSON)

    def taught(lesson: str) -> None:
        headset.until(f"hs.taught() === '{lesson}'")
        if hint := next(hints, None):
            headset.move("right", [0.1, 1.4, -0.4], [0.3, 1.4, -2.0])
            headset.until(f"hs.tips('right').join() === {json.dumps(hint)}")

    taught("paint")
    paint([x, y, z])
    taught("label")
    held = name in ("vive", "quest")
    headset.push(0, 0.9, pad) if held else click("palette", "other")
    taught("object")
    if held:
        headset.paint([[x, y, z], [x, y + 0.1, z]], release=False)
        headset.push(0, -0.9, pad)
        headset.until("hs.headset.cockpit.painter.completion.age[0] > 300")
        headset.trigger(0)
    else:
        paint([x, y, z])
        headset.until("pb.state.object.value?.completes")
        click("palette", "Tools")
        click("palette", "Complete")
    taught("play")
    headset.button(pad) if held else click("timeline", "play")
    taught("panel")
    headset.ask("(pb.engine.playback.pause(), true)")
    headset.settled()
    headset.flick_to_frame(0)
    click("timeline", "To end")
    headset.until("hs.taught() === null && hs.headset.cockpit.panels.added === null")
    headset.until(
        "pb.state.notices.value.some(({ title }) => title === 'That was the first minute')"
    )
    assert json.loads(headset.ask("localStorage['pointbrush.headset']"))["guide"] is False
    headset.close()
    assert headset.complaints == []


def test_the_first_minute_is_skipped_and_called_again(browser: Browser, server: LiveServer) -> None:
    server.create_label(SEQUENCE, "person", "#5ea2ff")
    headset = wear(browser, server.page_url, VIVE, newcomer=True)
    begin(headset, "vive")
    headset.click("added", "Next")
    headset.until("hs.taught() === 'label'")
    headset.click("added", "Skip all")
    headset.until("hs.taught() === null && hs.headset.cockpit.panels.added === null")
    headset.page.reload()
    headset.ready()
    headset.enter()
    assert headset.ask("hs.taught()") is None
    headset.click("palette", "Comfort")
    headset.click("palette", "First minute")
    headset.until("hs.taught() === 'paint' && hs.areas('added').length > 0")
    headset.close()
    assert headset.complaints == []
