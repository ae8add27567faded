"""The main job in an emulated Quest 3: paint, feel it, step through time."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import Browser

from tests.e2e.headset import Headset, wear
from tests.e2e.server import LiveServer

SEQUENCE = "juggling"
PERSON = 7
Truth = Callable[[int, int], list[float]]


@pytest.fixture
def headset(browser: Browser, server: LiveServer) -> Iterator[Headset]:
    """Inside the recording, with one label."""
    server.create_label(SEQUENCE, "person", "#ff5d5d")
    worn = wear(browser, server.page_url)
    worn.ready()
    worn.until("pb.state.activeLabel.value === 1")
    worn.enter()
    yield worn
    worn.context.close()
    assert worn.complaints == []


def painted(server: LiveServer, frame: int, label: int) -> int:
    return int((server.annotation(SEQUENCE, frame) == label).sum())


def test_paints_with_the_trigger_and_feels_it(
    headset: Headset, server: LiveServer, truth: Truth
) -> None:
    x, y, z = truth(0, PERSON)
    headset.pulses()
    headset.paint([[x, y, z], [x, y + 0.1, z]], release=False)
    # The page shows the paint before the server has the whole stroke.
    headset.until("(pb.labels()[1] ?? 0) > 20")
    headset.until("window.pulses.some((pulse) => pulse.milliseconds === 25)")
    assert painted(server, 0, 1) == 0
    headset.trigger(0)
    headset.settled()
    count = painted(server, 0, 1)
    assert count > 20
    headset.until(f"pb.labels()[1] === {count}")
    felt = [pulse for pulse in headset.pulses() if pulse["milliseconds"] == 25]
    assert felt
    assert {pulse["hand"] for pulse in felt} == {"right"}
    assert all(0 < pulse["strength"] <= 1 for pulse in felt)
    # The database has the stroke as one edit.
    edits = server.request("GET", f"sequences/{SEQUENCE}/edits").json()
    assert len(edits["edits"] if isinstance(edits, dict) else edits) >= 1


def test_the_thumbstick_steps_runs_and_plays(headset: Headset) -> None:
    headset.pulses()
    headset.flick(1, 0)
    headset.until("pb.state.frame.value === 1 && pb.shown().frame === 1")
    ticks = [pulse for pulse in headset.pulses() if pulse["milliseconds"] == 6]
    assert len(ticks) == 1
    headset.flick(-1, 0)
    headset.until("pb.state.frame.value === 0")
    # Held, it runs.
    headset.lean(1, 0)
    headset.until("pb.state.frame.value >= 4")
    headset.lean(0, 0)
    headset.button("thumbstick")
    headset.until("pb.state.playing.value")
    headset.button("thumbstick")
    headset.until("!pb.state.playing.value")
