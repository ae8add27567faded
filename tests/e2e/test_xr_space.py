"""In the headset: moving oneself and the recording, other controllers, hands, other people."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from playwright.sync_api import Browser

from tests.e2e.desk import Desk
from tests.e2e.headset import VIVE, Wear, wear
from tests.e2e.recording import PERSON, SEQUENCE, Truth, painted
from tests.e2e.server import LiveServer

RIG = "hs.headset.cockpit.rig"


def test_stands_on_the_floor_at_true_scale_before_the_scene(put_on: Wear, truth: Truth) -> None:
    headset = put_on()
    assert headset.ask("pb.engine.viewer.world.scale.x") == 1
    assert abs(headset.ask(f"{RIG}.head.y") - 1.6) < 1e-3
    x, _, z = headset.ask(f"hs.place({truth(0, PERSON)})")
    # Somebody to paint is ahead, and within a few steps.
    assert z < 0
    assert (x * x + z * z) ** 0.5 < 3
    # A floor and a horizon to keep one's balance by.
    assert headset.ask("pb.engine.viewer.backdrop.group.children.map((part) => part.visible)") == [
        True,
        True,
    ]
    # Where the panels stand, a capital letter is a degree tall at least, in each corner too; with
    # the arm stretched out the palette has grown.
    for hand in ([-0.2, 1.2, -0.35], [-0.3, 1.5, -0.65]):
        headset.move("left", hand)
        for panel in ("timeline", "palette"):
            for u, v in ((0.05, 0.05), (0.95, 0.05), (0.05, 0.95), (0.95, 0.95), (0.5, 0.5)):
                assert headset.ask(f"hs.capital('{panel}', {u}, {v})") >= 1, (panel, u, v)
    # Who walks is as far on in the recording as in the room.
    before = headset.ask(f"[{RIG}.head.x, {RIG}.head.z]")
    headset.ask("device.position.set(0.3, 1.5, -0.4)")
    headset.frames()
    after = headset.ask(f"[{RIG}.head.x, {RIG}.head.y, {RIG}.head.z]")
    walked = ((after[0] - before[0]) ** 2 + (after[2] - before[1]) ** 2) ** 0.5
    assert abs(walked - 0.5) < 1e-3
    assert abs(after[1] - 1.5) < 1e-3
    # The display runs at the best rate that is worth it, and points are budgeted for that.
    rate = headset.ask("pb.engine.viewer.renderer.xr.getSession().frameRate")
    assert rate == 90
    assert abs(headset.ask("pb.engine.pacing.headsetMs[0]") - 1000 / rate) < 1e-9
    session = "pb.engine.viewer.renderer.xr.getSession()"
    headset.ask(
        f"(Object.defineProperty({session}, 'frameRate', {{ value: 72 }}),"
        f" {session}.dispatchEvent(new Event('frameratechange')))"
    )
    assert abs(headset.ask("pb.engine.pacing.headsetMs[0]") - 1000 / 72) < 1e-9
    # Edges are antialiased, those of the view coarser; more or less of that is a choice.
    assert headset.ask(f"{session}.renderState.baseLayer.antialias")
    assert headset.ask("pb.engine.viewer.renderer.xr.getFoveation()") == 0.5
    headset.click("palette", "Comfort")
    headset.click("palette", "Edges softer")
    headset.until("pb.engine.viewer.renderer.xr.getFoveation() === 1")
    # The desk's page takes no time from the headset's pictures.
    assert not headset.page.locator("#toolbar").is_visible()


def test_teleports_by_the_arc_and_turns_in_steps(put_on: Wear) -> None:
    headset = put_on()
    before = headset.ask(f"[{RIG}.head.x, {RIG}.head.z]")
    headset.move("left", [-0.2, 1.2, -0.3], [-0.2, 1.0, -1.3])
    way = "hs.headset.cockpit.locomotion"
    headset.lean(0, -1, "left")
    headset.until(f"{way}.arc.mesh.visible && {way}.ring.visible")
    headset.lean(0, 0, "left")
    headset.until(f"!{way}.arc.mesh.visible && !{way}.ring.visible")
    # The picture was black for a moment, and is there again.
    headset.until(f"{way}.sinceJump[0] >= 100 && !{way}.vignette.visible")
    after = headset.ask(f"[{RIG}.head.x, {RIG}.head.z]")
    assert abs(after[1] - before[1]) > 0.5
    turned = headset.ask(f"{RIG}.group.rotation.y")
    headset.flick(1, 0, "left")
    assert abs(abs(headset.ask(f"{RIG}.group.rotation.y") - turned) - 0.5236) < 1e-3
    # One turns where one stands.
    assert abs(headset.ask(f"{RIG}.head.x") - after[0]) < 1e-3
    # By how much is a choice, and so is turning evenly.
    headset.click("palette", "Comfort")
    headset.click("palette", "Turn 30°")
    turned = headset.ask(f"{RIG}.group.rotation.y")
    headset.flick(1, 0, "left")
    assert abs(abs(headset.ask(f"{RIG}.group.rotation.y") - turned) - 0.7854) < 1e-3
    headset.click("palette", "Turn 45°")
    headset.click("palette", "Turn 90°")
    turned = headset.ask(f"{RIG}.group.rotation.y")
    headset.lean(1, 0, "left")
    headset.until("hs.headset.cockpit.locomotion.vignette.visible")
    headset.lean(0, 0, "left")
    assert abs(headset.ask(f"{RIG}.group.rotation.y") - turned) > 1e-3
    # Back to where one began: by the palette, and by the headset's own button.
    for recentre in ("palette", "headset"):
        if recentre == "palette":
            headset.click("palette", "View")
            headset.click("palette", "Recentre")
        else:
            headset.flick(0, -1, "left")
            headset.ask("device.recenter()")
        headset.frames(3)
        x, z = headset.ask(f"[{RIG}.head.x, {RIG}.head.z]")
        assert abs(x - before[0]) < 0.02, recentre
        assert abs(z - before[1]) < 0.02, recentre


def test_grips_drag_and_scale_the_room_and_the_brush_paints_where_it_is(
    put_on: Wear, server: LiveServer, truth: Truth
) -> None:
    headset = put_on()
    radius = headset.ask("pb.state.brush.value.radius")
    # One grip drags.
    headset.move("left", [-0.2, 1.2, -0.4])
    headset.move("right", [0.2, 1.2, -0.4])
    before = headset.ask(f"hs.place({truth(0, PERSON)})")
    headset.ask("device.controllers.left.updateButtonValue('squeeze', 1)")
    headset.frames()
    headset.move("left", [-0.2, 1.3, -0.2])
    headset.ask("device.controllers.left.updateButtonValue('squeeze', 0)")
    headset.frames()
    after = headset.ask(f"hs.place({truth(0, PERSON)})")
    assert np.allclose(np.subtract(after, before), [0, 0.1, 0.2], atol=1e-3)
    # Both scale.
    headset.move("left", [-0.2, 1.2, -0.4])
    for hand in ("left", "right"):
        headset.ask(f"device.controllers.{hand}.updateButtonValue('squeeze', 1)")
    headset.frames()
    headset.move("left", [-0.4, 1.2, -0.4])
    headset.move("right", [0.4, 1.2, -0.4])
    # … and turn it, by as much as the hands turned.
    headset.move("left", [-0.4, 1.2, -0.2])
    headset.move("right", [0.4, 1.2, -0.6])
    for hand in ("left", "right"):
        headset.ask(f"device.controllers.{hand}.updateButtonValue('squeeze', 0)")
    headset.frames()
    turned = headset.ask("2 * Math.asin(pb.engine.viewer.world.quaternion.y)")
    assert abs(turned - np.arctan2(0.4, 0.8)) < 0.02
    scale = headset.ask("pb.engine.viewer.world.scale.x")
    assert abs(scale - 2 * np.hypot(0.8, 0.4) / 0.8) < 0.1
    # The ball keeps its size in the hand: half as much of the recording.
    assert abs(headset.ask("pb.state.brush.value.radius") - radius / scale) < 1e-3
    headset.paint([truth(0, PERSON)])
    headset.settled()
    assert painted(server, 0) > 5
    headset.click("palette", "View")
    headset.click("palette", "Reset")
    headset.until("pb.engine.viewer.world.scale.x === 1")
    assert abs(headset.ask("pb.state.brush.value.radius") - radius) < 1e-3


def test_a_touchpad_has_four_quadrants(put_on: Wear, server: LiveServer, truth: Truth) -> None:
    server.create_label(SEQUENCE, "other", "#5ea2ff")
    headset = put_on(VIVE)
    headset.until("hs.headset.cockpit.pointers.of('right')?.device.id === 'vive'")

    def quadrant(x: float, y: float, hand: str = "right") -> None:
        headset.ask(f"device.controllers.{hand}.updateAxes('touchpad', {x}, {y})")
        headset.frames()
        press = f"device.controllers.{hand}.updateButtonValue('touchpad', %d)"
        headset.for_a_picture(press % 1, press % 0)

    quadrant(0.8, 0)
    headset.until("pb.state.frame.value === 1")
    quadrant(-0.8, 0)
    headset.until("pb.state.frame.value === 0")
    quadrant(0, 0.8)
    headset.until("pb.state.activeLabel.value === 2")
    quadrant(0, -0.8)
    headset.until("pb.state.activeLabel.value === 1")
    quadrant(0, 0)
    headset.until("pb.state.playing.value")
    quadrant(0, 0)
    headset.until("!pb.state.playing.value")
    # The other hand's pad goes and turns.
    turned = headset.ask(f"{RIG}.group.rotation.y")
    quadrant(0.8, 0, "left")
    assert abs(abs(headset.ask(f"{RIG}.group.rotation.y") - turned) - 0.5236) < 1e-3
    place = headset.ask(f"{RIG}.head.z")
    headset.move("left", [-0.2, 1.2, -0.3], [-0.2, 1.0, -1.3])
    quadrant(0, -0.8, "left")
    assert abs(headset.ask(f"{RIG}.head.z") - place) > 0.5
    # A hand that points at a panel needs no words; past it, they are there.
    headset.move("left", [-0.2, 1.2, -0.3], [-0.2, 2.2, -0.3])
    headset.until("hs.tips('left').join() === 'Grip + Pad ↑: timeline'")
    headset.flick_to_frame(0)
    headset.paint([truth(0, PERSON)])
    headset.settled()
    assert painted(server, 0) > 5

    # With the grip held the pad is the buttons that the wand has not, and the room stays.
    def gripped(x: float, y: float, hand: str = "right") -> None:
        headset.ask(f"device.controllers.{hand}.updateButtonValue('squeeze', 1)")
        headset.frames()
        quadrant(x, y, hand)
        headset.move(hand, [0.1, 1.4, -0.3])
        headset.ask(f"device.controllers.{hand}.updateButtonValue('squeeze', 0)")
        headset.frames()

    gripped(0, -0.8)
    headset.until("pb.state.tool.value === 'erase'")
    gripped(0, -0.8)
    headset.until("pb.state.tool.value === 'paint'")
    gripped(-0.8, 0)
    headset.settled()
    assert painted(server, 0) == 0
    gripped(-0.8, 0, "left")
    headset.settled()
    assert painted(server, 0) > 5
    assert headset.ask("pb.engine.viewer.world.position.length()") == 0
    # To the right the brush grows, and back it shrinks.
    radius = headset.ask("pb.state.brush.value.radius")
    gripped(0.8, 0)
    assert headset.ask("pb.state.brush.value.radius") > radius
    gripped(0, 0.8)
    gripped(0, 0.8)
    assert headset.ask("pb.state.brush.value.radius") < radius


def test_a_pinch_paints_and_presses_all_that_a_trigger_does(
    put_on: Wear, server: LiveServer, truth: Truth
) -> None:
    server.create_label(SEQUENCE, "other", "#5ea2ff")
    headset = put_on()
    # Who lays the controllers down in the middle of a stroke keeps it.
    headset.paint([truth(0, PERSON)], release=False)
    headset.lay_down_controllers()
    headset.settled()
    first = painted(server, 0)
    assert first > 5
    headset.ask("device.controllers.right.updateButtonValue('trigger', 0)")
    # A label, a page, a tool, a slider and the time, each with a pinch.
    headset.click("palette", "other")
    headset.until("pb.state.activeLabel.value === 2")
    headset.click("palette", "View")
    headset.slide("palette", "Point size", 0.5, 0.8)
    headset.until("pb.state.view.value.pointSize > 1.5")
    headset.click("palette", "Label boxes")
    headset.until("pb.state.view.value.boxes")
    headset.click("palette", "Tools")
    headset.click("palette", "Erase")
    headset.until("pb.state.tool.value === 'erase'")
    headset.click("palette", "Paint")
    headset.slide("timeline", "ruler", 0.05, 0.95)
    headset.until("pb.state.frame.value === 5 && pb.shown().frame === 5")
    headset.slide("timeline", "ruler", 0.05)
    headset.until("pb.state.frame.value === 0 && pb.shown().frame === 0")
    assert painted(server, 0) == first
    x, y, z = truth(0, PERSON)
    headset.hand_to("right", headset.ask(f"hs.place({[x, y + 0.2, z]})"))
    headset.trigger(1)
    headset.frames(2)
    headset.trigger(0)
    headset.settled()
    assert painted(server, 0, 2) > 5
    # The trigger of the other hand takes hold of the room; so does its pinch.
    headset.move("left", [-0.3, 1.2, -0.3], [-0.3, 2.0, -0.3])
    headset.trigger(1, "left")
    headset.move("left", [-0.2, 1.2, -0.3], [-0.2, 2.0, -0.3])
    headset.trigger(0, "left")
    assert headset.ask("pb.engine.viewer.world.position.length()") > 0.05


def test_enters_with_the_real_room_in_sight(browser: Browser, server: LiveServer) -> None:
    headset = wear(browser, f"{server.page_url}&sequence={SEQUENCE}&frame=3")
    headset.ready()
    headset.ask("(pb.state.tool.value = 'navigate')")
    headset.page.get_by_role(
        "button", name="Enter with passthrough: the real room stays visible"
    ).click()
    headset.until("hs.headset.cockpit?.mode === 'immersive-ar' && hs.frames() > 2")
    # Who looked about at the desk walks here, and the trigger paints.
    assert headset.ask("pb.state.tool.value") == "paint"
    # … in the frame that the address names.
    assert headset.ask("pb.state.frame.value") == 3
    assert headset.ask("pb.engine.viewer.renderer.xr.getSession().environmentBlendMode") != ""
    # The sky must not hide the room.
    assert headset.ask("pb.engine.viewer.backdrop.group.children[0].visible") is False
    headset.close()
    assert headset.complaints == []


def test_left_handed_people_paint_with_the_left(
    put_on: Wear, server: LiveServer, truth: Truth
) -> None:
    headset = put_on()
    headset.click("palette", "Comfort")
    headset.click("palette", "Left-handed")
    headset.frames()
    headset.reach(truth(0, PERSON), "left")
    headset.trigger(1, "left")
    headset.trigger(0, "left")
    headset.settled()
    assert painted(server, 0) > 5


def test_people_see_each_other_and_the_desk_sees_what_the_headset_sees(
    put_on: Wear, open_desk: Callable[..., Desk], truth: Truth
) -> None:
    other = open_desk(width=700, height=500)
    headset = put_on()
    headset.move("right", [0.2, 1.3, -0.5])
    seen = '[{"name":true,"head":true,"hands":2,"brush":true}]'
    other.until(f"JSON.stringify(__pointbrushHeadset.people()) === '{seen}'")
    head = other.ask("pb.state.people.value.find((person) => person.head).head")
    mine = headset.ask(f"[{RIG}.head.x, {RIG}.head.y, {RIG}.head.z]")
    assert all(abs(a - b) < 0.05 for a, b in zip(head, mine, strict=False))
    # Who is at the desk has a name and a brush in the room.
    other.page.mouse.move(*other.place(truth(0, PERSON)))
    headset.until("hs.people().some((person) => person.name && person.brush && !person.head)")
    # The desk looks through the headset's eyes, also as it walks.
    other.page.locator("button.person").click()
    headset.ask("device.position.set(0.2, 1.4, 0.1)")
    headset.ask("device.quaternion.set(0, 0.2588, 0, 0.9659)")
    headset.frames()
    x, y, z = headset.ask(f"[{RIG}.head.x, {RIG}.head.y, {RIG}.head.z]")
    eye = "pb.engine.viewer.camera.position"
    other.until(f"Math.hypot({eye}.x - {x}, {eye}.y - {y}, {eye}.z - {z}) < 0.05")
    # … and looks where the headset looks.
    x, z = headset.ask(f"[{RIG}.ahead.x, {RIG}.ahead.z]")
    ahead = "pb.engine.viewer.camera.matrixWorld.elements"
    other.until(f"Math.hypot({ahead}[8] + {x}, {ahead}[10] + {z}) < 0.05")
    # The desk does not fly into the headset's place when that one leaves.
    headset.ask("void pb.engine.viewer.renderer.xr.getSession().end()")
    other.until("pb.state.people.value.every((person) => person.head === null)")
