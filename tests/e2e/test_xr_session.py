"""In the headset: how a session begins, what it asks for, and what goes on while one is away."""

from __future__ import annotations

from io import BytesIO

import numpy as np
from PIL import Image
from playwright.sync_api import Browser

from tests.e2e.headset import Headset, Wear, wear
from tests.e2e.recording import PERSON, PIN, SEQUENCE, Truth, painted
from tests.e2e.server import LiveServer

RIG = "hs.headset.cockpit.rig"
COCKPIT = "hs.headset.cockpit"


def enter_anew(headset: Headset, before: str) -> None:
    """Leave, change what the browser does, and enter again."""
    headset.ask("void hs.headset.exit()")
    headset.until("pb.state.xr.value.session === 'none'")
    headset.ask(before)
    headset.ask("void hs.headset.enter()")
    headset.until("hs.headset.cockpit && hs.frames() > 2")


def test_a_session_begins_without_a_rate_asks_for_wanted_hands_and_reverses_depth(
    put_on: Wear,
) -> None:
    headset = put_on()
    # A layers API that is there and cannot be used is found out once.
    enter_anew(
        headset,
        "(window.XRWebGLBinding.prototype.createProjectionLayer ="
        " () => { throw new DOMException('not supported', 'NotSupportedError'); },"
        " XRSession.prototype.updateTargetFrameRate = () => new Promise(() => {}),"
        " window.asked = [], window.request = navigator.xr.requestSession.bind(navigator.xr),"
        " navigator.xr.requestSession = (mode, init) =>"
        " (window.asked.push(init.optionalFeatures), window.request(mode, init)), null)",
    )
    assert {"hand-tracking", "layers"} <= set(headset.ask("window.asked[0]"))
    assert headset.ask("localStorage.getItem('pointbrush.layers')") == "unusable"
    headset.click("palette", "Comfort")
    headset.click("palette", "Bare hands")
    enter_anew(headset, "null")
    assert "hand-tracking" not in headset.ask("window.asked[1]")
    assert "local-floor" in headset.ask("window.asked[1]")
    assert "layers" not in headset.ask("window.asked[1]")

    headset.ask("(pb.engine.viewer.reversible = true, pb.setDrawing(true), null)")
    near, far = "session.renderState.depthNear", "session.renderState.depthFar"
    session = "const session = pb.engine.viewer.renderer.xr.getSession();"
    headset.until(f"(() => {{ {session} return {near} > {far} && {far} <= 0.05; }})()")


def test_nothing_plays_on_unseen_and_a_pinch_that_opens_a_menu_paints_nothing(
    put_on: Wear, server: LiveServer, truth: Truth
) -> None:
    headset = put_on()
    headset.reach(truth(0, PERSON))

    def press_and_cover() -> None:
        """Press, and in the next picture open the system's menu."""
        headset.frames()
        headset.for_a_picture(
            headset.pressing(1), "device.updateVisibilityState('visible-blurred')"
        )
        headset.until(f"!{COCKPIT}.painter.painting")
        headset.trigger(0)
        headset.ask("device.updateVisibilityState('visible')")
        headset.settled()

    # A notice of the system over a trigger takes nothing away.
    press_and_cover()
    count = painted(server, 0)
    assert count > 5
    # A pinch may have been the system's own gesture: it paints nothing, and that is said.
    headset.lay_down_controllers()
    x, y, z = truth(0, PIN)
    headset.hand_to("right", headset.ask(f"hs.place({[x, y, z]})"))
    press_and_cover()
    headset.until(f"{COCKPIT}.hud.sign.text.startsWith('Not painted')")
    assert painted(server, 0) == count
    headset.ask("pb.engine.playback.play()")
    headset.until("pb.state.playing.value")
    headset.ask("device.updateVisibilityState('hidden')")
    headset.until("!pb.state.playing.value")
    headset.ask("device.updateVisibilityState('visible')")
    headset.frames()
    assert not headset.ask("pb.state.playing.value")


def test_turning_evenly_ends_the_stroke_and_dragging_the_room_narrows_the_view(
    put_on: Wear, server: LiveServer, truth: Truth
) -> None:
    headset = put_on()
    for pressed in ("Comfort", "Turn 30°", "Turn 45°", "Turn 90°"):
        headset.click("palette", pressed)
    headset.paint([truth(0, PERSON)], release=False)
    headset.until(f"{COCKPIT}.painter.painting")
    headset.lean(1, 0, "left")
    headset.until(f"!{COCKPIT}.painter.painting")
    headset.lean(0, 0, "left")
    headset.trigger(0)
    headset.settled()
    vignette = f"{COCKPIT}.locomotion.vignette.visible"
    headset.until(f"!{vignette}")
    headset.ask("device.controllers.left.updateButtonValue('squeeze', 1)")
    headset.until(vignette)
    headset.ask("device.controllers.left.updateButtonValue('squeeze', 0)")
    headset.until(f"!{vignette}")


def test_doll_then_reset_leaves_one_where_one_stood(put_on: Wear) -> None:
    headset = put_on()
    headset.move("left", [-0.2, 1.2, -0.3], [-0.2, 1.0, -1.3])
    headset.lean(0, -1, "left")
    headset.until(f"{COCKPIT}.locomotion.ring.visible")
    headset.lean(0, 0, "left")
    headset.until(f"!{COCKPIT}.locomotion.ring.visible")
    before = headset.ask(f"{RIG}.head.toArray()")
    headset.click("palette", "View")
    headset.click("palette", "Doll")
    headset.until("pb.engine.viewer.world.scale.x < 1")
    headset.call("timeline")
    headset.frames()
    assert not headset.hides_model("timeline")
    headset.click("palette", "Reset")
    headset.until("pb.engine.viewer.world.scale.x === 1")
    after = headset.ask(f"{RIG}.head.toArray()")
    assert max(abs(a - b) for a, b in zip(before, after, strict=True)) < 0.02


def test_a_ray_is_two_pixels_wide_at_least(browser: Browser, server: LiveServer) -> None:
    server.create_label(SEQUENCE, "person", "#ff5d5d")
    headset = wear(browser, server.page_url, size=(1000, 500), drawn=True)
    headset.ready()
    headset.enter()
    headset.call("timeline")
    at = headset.ask("hs.onPanel('timeline', 0.3, 0.4)")["at"]
    headset.move("right", [0.35, 1.35, -0.35], at)
    # Nothing else is drawn, in either eye.
    headset.ask(
        """(() => {
          const { viewer } = pb.engine;
          const { ray, on } = hs.headset.cockpit.pointers.bodies
            .find(({ pointer }) => pointer.side === 'right');
          viewer.ticks.add(() => viewer.scene.traverse(({ material }) => {
            if (material) material.colorWrite = material === ray.line.mesh.material;
          }));
          pb.setDrawing(true);
          return on !== null;
        })()"""
    )
    headset.frames(3)
    shown = Image.open(BytesIO(headset.page.screenshot())).convert("L")
    headset.close()
    assert headset.complaints == []
    bright = np.asarray(shown, dtype=float) > 60
    # Across what is rather level it is measured in columns.
    widths = bright[:, :500].sum(axis=0)
    columns = widths[widths > 0]
    assert len(columns) > 20
    assert np.median(columns) >= 2
