"""In the headset: gamepads as browsers have them, and parts of the page that fail."""

from __future__ import annotations

import pytest

from tests.e2e.headset import HAPTICS, PAINTING, TICK, Wear
from tests.e2e.recording import PERSON, PIN, Truth, painted
from tests.e2e.server import LiveServer


@pytest.mark.parametrize("browser_name", sorted(set(HAPTICS) - {"Quest Browser"}))
def test_frames_and_strokes_whatever_pulses_a_browser_has(
    put_on: Wear, server: LiveServer, truth: Truth, browser_name: str
) -> None:
    headset = put_on(haptics=browser_name)
    headset.ask(
        "(window.sounds = 0, window.OscillatorNode = class extends window.OscillatorNode {"
        " constructor(...all) { super(...all); window.sounds += 1; } }, null)"
    )
    headset.flick(1, 0)
    headset.until("pb.state.frame.value === 1 && pb.shown().frame === 1")
    headset.flick(-1, 0)
    headset.until("pb.state.frame.value === 0 && pb.shown().frame === 0")
    headset.paint([truth(0, PERSON)])
    headset.settled()
    assert painted(server, 0) > 5
    lengths = [pulse["milliseconds"] for pulse in headset.pulses()]
    if browser_name == "Chromium":
        assert lengths.count(TICK) >= 2
        assert PAINTING in lengths
        assert headset.ask("window.sounds") == 0
    else:
        # What cannot be felt is heard, unless that is not wished, and the brush glows.
        headset.until("window.sounds >= 2")
        glows = "hs.headset.cockpit.painter.look.sphere.material.opacity > 1"
        headset.paint([truth(0, PIN)], release=False)
        headset.until(glows)
        headset.trigger(0)
        headset.settled()
        # Suspended by the browser, sound goes on with the next press.
        context = "hs.headset.cockpit.cues.sounds.context"
        headset.ask(f"void {context}.suspend()")
        headset.until(f"{context}.state === 'suspended'")
        headset.trigger(1)
        headset.trigger(0)
        headset.until(f"{context}.state === 'running'")
    headset.click("palette", "Comfort")
    headset.click("palette", "Sound without vibration")
    before = headset.ask("window.sounds")
    headset.flick(1, 0)
    headset.until(f"window.sounds > {before}")
    headset.click("palette", "Sound with each pulse")
    headset.until("hs.areas('palette').some((area) => area.name === 'No sound')")
    before = headset.ask("window.sounds")
    headset.flick(-1, 0)
    headset.until("pb.state.frame.value === 0")
    headset.frames()
    assert headset.ask("window.sounds") == before
    assert headset.ask("pb.state.notices.value.filter((n) => n.kind === 'error').length") == 0


def test_a_part_that_fails_in_every_picture_is_told_once_and_the_rest_goes_on(
    put_on: Wear, server: LiveServer, truth: Truth
) -> None:
    headset = put_on()
    headset.ask(
        "(hs.headset.cockpit.feelings.update = () => { throw new TypeError('broken part'); },"
        " pb.engine.viewer.ticks.add(() => { throw new RangeError('broken tick'); }), true)"
    )
    headset.frames(5)
    headset.paint([truth(0, PERSON)])
    headset.settled()
    assert painted(server, 0) > 5
    headset.click("palette", "Tools")
    headset.until("hs.areas('palette').some((area) => area.name === 'Fill')")
    told = "pb.state.notices.value.filter((n) => n.title === 'A part of the page failed')"
    assert headset.ask(f"{told}.length") == 2
    # The desk's loop goes on too.
    headset.ask("void hs.headset.exit()")
    headset.until("pb.state.xr.value.session === 'none'")
    headset.press("ArrowRight")
    headset.until("pb.shown().frame === 1")
    assert len([text for text in headset.complaints if "part of the page failed" in text]) == 2
    headset.complaints.clear()
