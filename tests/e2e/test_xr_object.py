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


@pytest.mark.parametrize(("device", "pad"), [(QUEST, "thumbstick"), (VIVE, "touchpad")])
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

    def push(y: float) -> None:
        if pad == "touchpad":
            headset.lean(0, y, pad=pad)
            headset.for_a_picture(
                "device.controllers.right.updateButtonValue('touchpad', 1)",
                "device.controllers.right.updateButtonValue('touchpad', 0)",
            )
            headset.lean(0, 0, pad=pad)
        else:
            headset.flick(0, y)

    aim(person)
    headset.until("pb.state.object.value?.levels > 1 && pb.state.object.value.ready")
    shown = headset.ask("pb.state.object.value")
    assert headset.labels().get(65534) == shown["points"]
    headset.pulses()
    step = -1 if shown["level"] > 0 else 1
    push(-step)
    headset.until(f"pb.state.object.value.level === {shown['level'] + step}")
    assert [p for p in headset.pulses() if p["milliseconds"] == TICK]
    push(step)
    headset.until(f"pb.state.object.value.level === {shown['level']}")
    headset.trigger(1)
    headset.trigger(0)
    headset.until("pb.state.object.value?.taken")
    headset.settled()
    first = painted(server, 0)
    assert first == shown["points"]
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


def test_a_press_of_the_stick_completes_a_stroke(
    put_on: Wear, server: LiveServer, truth: Truth
) -> None:
    headset = put_on()
    headset.until("pb.state.activeLabel.value === 1")
    x, y, z = truth(0, PERSON)
    headset.paint([[x, y, z], [x, y + 0.1, z], [x, y + 0.2, z]])
    headset.until("pb.state.object.value?.completes")
    headset.settled()
    stroke = painted(server, 0)
    assert stroke > 0
    playing = headset.ask("pb.state.playing.value")
    headset.button("thumbstick")
    headset.until("!pb.state.object.value?.completes")
    eventually(lambda: painted(server, 0) > stroke)
    assert headset.ask("pb.state.playing.value") == playing
