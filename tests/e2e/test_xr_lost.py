"""In the headset: what gets lost, and what others change meanwhile, is told and stops nobody."""

from __future__ import annotations

import numpy as np

from tests.e2e.headset import Wear
from tests.e2e.recording import PERSON, SEQUENCE, Truth, painted
from tests.e2e.server import LiveServer


def test_what_changes_while_one_paints_is_told_and_stops_nobody(
    put_on: Wear, server: LiveServer, truth: Truth
) -> None:
    server.create_label(SEQUENCE, "other", "#5ea2ff")
    headset = put_on()
    x, y, z = truth(0, PERSON)
    headset.paint([[x, y, z]])
    headset.settled()
    first = painted(server, 0)
    # Undo in the middle of a stroke takes back what was before; the stroke goes on.
    headset.until("pb.state.undo.value !== null")
    headset.paint([[x, y + 0.3, z]], release=False)
    headset.button("b-button")
    headset.until("pb.state.redo.value !== null")
    headset.trigger(0)
    headset.settled()
    second = painted(server, 0)
    points = server.points(SEQUENCE, 0)[server.annotation(SEQUENCE, 0) == 1]
    assert first > 5
    assert second > 0
    radius = headset.ask("pb.state.brush.value.radius")
    assert np.abs(points - [x, y + 0.3, z]).max() < 2 * radius
    # Somebody deletes the label that is in use: another one is chosen, and the hand paints on.
    headset.paint([[x, y, z]], release=False)
    server.request("DELETE", f"sequences/{SEQUENCE}/labels/1")
    headset.until("pb.state.palette.value.length === 1")
    headset.trigger(0)
    headset.settled()
    headset.until("pb.state.activeLabel.value === 2")
    headset.paint([[x, y, z]])
    headset.settled()
    assert painted(server, 0, 2) > 5
    # Somebody deletes the recording: that is said, nothing is painted, and one can leave.
    headset.trigger(1)
    server.request("DELETE", f"sequences/{SEQUENCE}")
    headset.until("hs.headset.cockpit.hud.sign.text === 'No recording is open'")
    headset.trigger(0)
    said = headset.ask("pb.state.notices.value.length")
    headset.button("b-button")
    assert headset.ask("pb.state.notices.value.length") <= said
    headset.click("palette", "View")
    headset.until("hs.areas('palette').some((area) => area.name === 'Leave')")
    headset.point_at("palette", "Leave", 0.5)
    headset.ask("device.controllers.right.updateButtonValue('trigger', 1)")
    headset.until("pb.state.xr.value.session === 'none'")


def test_a_lost_controller_ends_its_stroke_and_comes_back(
    put_on: Wear, server: LiveServer, truth: Truth
) -> None:
    headset = put_on()
    # The emulation calls every position emulated.
    headset.ask(
        "void Object.defineProperty(XRPose.prototype, 'emulatedPosition', "
        "{ configurable: true, get: () => window.guesses === true })"
    )
    headset.paint([truth(0, PERSON)], release=False)
    headset.ask("(device.controllers.right.connected = false)")
    headset.until("hs.headset.cockpit.pointers.of('right') === null")
    said = "(hs.headset.cockpit.hud.sign.mesh.visible && hs.headset.cockpit.hud.sign.text)"
    headset.until(f"String({said}).startsWith('The right controller is disconnected')")
    headset.settled()
    assert painted(server, 0) > 5
    headset.ask("(device.controllers.right.connected = true)")
    headset.until("hs.headset.cockpit.pointers.of('right') !== null")
    headset.until(f"{said} === false", 15)
    headset.trigger(0)
    count = painted(server, 0)
    # Where the headset guesses that it is, it paints nothing; the notice tells the remedy as well.
    x, y, z = truth(0, PERSON)
    headset.ask("(window.guesses = true)")
    headset.paint([[x, y + 0.15, z]])
    headset.until(f"String({said}).startsWith('Not painted: out of view of the headset')")
    assert "Move it into view" in headset.ask(said).replace("\n", " ")
    headset.settled()
    assert painted(server, 0) == count
    headset.ask("(window.guesses = false)")
    headset.paint([[x, y + 0.15, z]])
    headset.settled()
    assert painted(server, 0) > count


def test_a_lost_session_is_told_and_can_be_entered_again(
    put_on: Wear, server: LiveServer, truth: Truth
) -> None:
    headset = put_on()
    headset.paint([truth(0, PERSON)], release=False)
    headset.ask("void pb.engine.viewer.renderer.xr.getSession().end()")
    headset.until("pb.state.xr.value.session === 'lost'")
    headset.settled()
    assert painted(server, 0) > 5
    headset.page.get_by_text("The headset session ended").wait_for()
    headset.enter()
    headset.until("pb.state.xr.value.session === 'running'")
    # A session never draws again once the graphics context is lost: it ends, and the next one does.
    context = "pb.engine.viewer.renderer.getContext()"
    headset.ask(f"void (window.lose = {context}.getExtension('WEBGL_lose_context')).loseContext()")
    headset.until("pb.state.xr.value.session === 'lost' && pb.state.pictureLost.value")
    headset.page.get_by_text("The graphics card stopped drawing. All strokes are kept").wait_for()
    headset.ask("void window.lose.restoreContext()")
    headset.until("!pb.state.pictureLost.value")
    headset.enter()
    headset.until("pb.state.xr.value.session === 'running' && pb.labels()[1] > 5")
    # The emulation asks the lost context for its clear colour.
    emulated = "Cannot read properties of null (reading '0')"
    headset.complaints[:] = [text for text in headset.complaints if text != emulated]


def test_a_lost_server_does_not_stop_the_painting(
    put_on: Wear, server: LiveServer, truth: Truth
) -> None:
    headset = put_on()
    server.kill()
    headset.until("pb.state.connection.value.state === 'offline'")
    headset.paint([truth(0, PERSON)])
    headset.until("pb.state.pending.value > 0 && pb.labels()[1] > 5")
    said = "hs.headset.cockpit.hud.sign.text"
    headset.until(f"{said}.startsWith('The server does not answer') && {said}.includes('waiting')")
    server.start()
    headset.until("pb.state.connection.value.state === 'online'")
    headset.until("!hs.headset.cockpit.hud.text.startsWith('The server')")
    headset.settled()
    assert painted(server, 0) > 5
    headset.complaints.clear()
