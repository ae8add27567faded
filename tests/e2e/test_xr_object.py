"""One click, one object: in the headset."""

from __future__ import annotations

import numpy as np
import pytest

from tests.e2e.headset import QUEST, VIVE, Wear
from tests.e2e.recording import PERSON, PIN, SEQUENCE, Truth, painted
from tests.e2e.server import LiveServer
from tests.waiting import eventually

TICK = 15
"""Milliseconds of the pulse that tells of another level."""


DEVICES = [(QUEST, "thumbstick"), (VIVE, "touchpad")]


@pytest.mark.parametrize(("device", "pad"), DEVICES)
def test_the_ray_shows_the_stick_walks_the_trigger_takes(
    put_on: Wear, server: LiveServer, truth: Truth, device: str, pad: str
) -> None:
    headset = put_on(device)
    headset.until("pb.state.activeLabel.value === 1")
    headset.click("palette", "Tools")
    headset.click("palette", "Object")
    person, pin = truth(0, PERSON), truth(0, PIN)

    def aim(point: list[float]) -> None:
        x, y, z = headset.ask(f"hs.place({point})")
        headset.move("right", [x, y, z + 0.8], [x, y, z])

    aim(person)
    headset.until("pb.state.object.value?.levels > 1 && pb.state.object.value.ready")
    shown = headset.ask("pb.state.object.value")
    assert headset.labels().get(65534) == shown["points"]
    headset.trigger(1)
    headset.until("pb.state.object.value?.taken")
    headset.settled()
    assert painted(server, 0) == shown["points"]
    # The pad walks through the levels while the trigger is held, and changes no label.
    headset.pulses()
    step = -1 if shown["level"] > 0 else 1
    headset.push(0, -step, pad)
    headset.until(f"pb.state.object.value.level === {shown['level'] + step}")
    assert [p for p in headset.pulses() if p["milliseconds"] == TICK]
    eventually(lambda: painted(server, 0) != shown["points"])
    headset.settled()
    headset.push(0, step, pad)
    headset.until(f"pb.state.object.value.level === {shown['level']}")
    headset.trigger(0)
    eventually(lambda: painted(server, 0) == shown["points"])
    headset.settled()
    assert headset.ask("pb.state.activeLabel.value") == 1
    aim(pin)
    headset.trigger(1)
    headset.trigger(0)
    index = int(np.linalg.norm(server.points(SEQUENCE, 0) - pin, axis=1).argmin())
    eventually(lambda: server.annotation(SEQUENCE, 0)[index] == 1)
    headset.settled()
    headset.ask("(pb.state.tool.value = 'erase')")
    headset.frames()
    headset.trigger(1)
    headset.trigger(0)
    eventually(lambda: server.annotation(SEQUENCE, 0)[index] == 0)
    headset.settled()
    headset.ask("pb.engine.travel('undo')")
    headset.until("(pb.labels()[1] ?? 0) === 0")


@pytest.mark.parametrize(("device", "pad"), DEVICES)
def test_after_a_stroke_the_pad_means_what_it_meant_before(
    put_on: Wear, server: LiveServer, truth: Truth, device: str, pad: str
) -> None:
    server.create_label(SEQUENCE, "other", "#5ea2ff")
    headset = put_on(device)
    headset.until("pb.state.activeLabel.value === 1 && pb.state.palette.value.length === 2")
    if device == VIVE:
        headset.ask("(device.controllers.left.connected = false)")
        headset.until("hs.pointers().length === 1")
    x, y, z = truth(0, PERSON)
    path = [[x, y, z], [x, y + 0.1, z], [x, y + 0.2, z]]
    offered = "pb.state.object.value?.completes === true"

    def stroke() -> int:
        headset.flick_to_frame(0)
        headset.paint(path)
        headset.until(offered)
        headset.settled()
        return painted(server, 0)

    # Play plays, a push switches labels, left and right are frames: the array stays as it is.
    count = stroke()
    assert count > 0
    name = "Pad" if device == VIVE else "Stick"
    headset.until(
        f"hs.headset.cockpit.tipSign.sign.text.endsWith('Hold Trigger, {name} ↑: object')"
    )
    ring = "hs.headset.cockpit.ring"
    headset.lean(0, 0.9, pad=pad)
    headset.until(f"{ring}.mesh.visible && {ring}.sign.text === '↓ other'")
    if device == VIVE:
        headset.push(0, 0.9, pad)
    else:
        headset.lean(0, 0, pad=pad)
    headset.until("pb.state.activeLabel.value === 2")
    headset.push(0, -0.9, pad)
    headset.until("pb.state.activeLabel.value === 1")
    assert stroke() == count
    headset.push(0.9, 0, pad)
    headset.until("pb.state.frame.value === 1")
    headset.until(f"!({offered})")
    assert stroke() == count
    headset.button(pad)
    headset.until("pb.state.playing.value")
    headset.until(f"!({offered})")
    headset.button(pad)
    headset.until("!pb.state.playing.value")
    headset.settled()
    assert painted(server, 0) == count
    # An offer ends by itself; a push while the trigger is held takes the object.
    stroke()
    headset.until(f"!({offered})")
    headset.paint(path, release=False)
    headset.push(0, -0.9, pad)
    headset.until(offered)
    shown = headset.ask("pb.state.object.value.points")
    assert painted(server, 0) == count
    headset.until("hs.headset.cockpit.painter.completion.age[0] > 300")
    headset.trigger(0)
    eventually(lambda: painted(server, 0) >= shown > count)
