"""Several depth cameras in one recording: shown, hidden, coloured and painted."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser, expect

from tests.e2e.desk import Desk
from tests.e2e.headset import wear
from tests.e2e.server import LiveServer
from tests.e2e.stage import FRAME, PERSON, TRUTH, make_workspace
from tests.e2e.test_importing import choose
from tests.formats.test_joined_sensors import two_lidars
from tests.waiting import eventually

RADIUS = 0.3
FRONT = 0


@pytest.fixture(scope="session")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_workspace(tmp_path_factory)


def on_person() -> list[float]:
    """Return the point that the front camera sees in the middle of a person."""
    mine = FRAME.xyz[(TRUTH == PERSON) & (FRAME.sensor == FRONT)]
    nearest = mine[np.linalg.norm(mine - mine.mean(axis=0), axis=1).argmin()]
    return [float(value) for value in nearest]


def painted(server: LiveServer) -> set[int]:
    """Return the sensors with labelled points in frame 0."""
    return set(FRAME.sensor[server.annotation("stage", 0) == 1].tolist())


def test_at_the_desk_a_stroke_takes_the_points_of_all_shown_sensors(
    open_desk: Callable[..., Desk], server: LiveServer
) -> None:
    server.create_label("stage", "person", "#ff5d5d")
    desk = open_desk()
    page = desk.page
    images = "pb.engine.playback.frame.images.map(({ sensor }) => sensor)"
    assert desk.ask(images) == [0, 1, 2]
    # One surface for each camera.
    page.get_by_role("button", name="Overlays").click()
    page.get_by_role("radio", name="Surface", exact=True).click()
    desk.until("pb.engine.viewer.hasSurface")
    desk.press("Escape")
    page.get_by_role("button", name="Sensors", exact=True).click()
    sensors = page.get_by_role("dialog", name="Sensors")
    for sensor in FRAME.sensors:
        name = f"{sensor.name} depth camera"
        expect(sensors.get_by_role("checkbox", name=name)).to_be_checked()
    sensors.get_by_role("checkbox", name="Colour by sensor").check()
    desk.press("Escape")
    expect(page.get_by_role("combobox", name="Colour points by")).to_have_value("sensor")
    page.get_by_role("radio", name="Brush").click()
    desk.ask(f"(pb.state.brush.value = {{ ...pb.state.brush.value, radius: {RADIUS} }})")
    at = on_person()
    desk.paint([at])
    desk.settled()
    eventually(lambda: painted(server) == {0, 1, 2})
    desk.press("Control+z")
    eventually(lambda: painted(server) == set())
    page.get_by_role("button", name="Sensors", exact=True).click()
    sensors.get_by_role("checkbox", name="front").uncheck()
    desk.press("Escape")
    expect(page.get_by_text("front hidden: only points of the other sensors")).to_be_visible()
    desk.paint([at])
    desk.settled()
    eventually(lambda: painted(server) == {1, 2})
    page.get_by_role("button", name="Show all sensors").click()
    align(desk)


MOUNT = "JSON.stringify(pb.engine.playback.frame?.images[1]?.mount)"
EYE = "pb.engine.viewer.camera.position.toArray()"


def align(desk: Desk) -> None:
    """Align the sensors and undo it: the points move at once, labels and view stay."""
    page = desk.page
    labelled, before, eye = desk.labels()[1], desk.ask(MOUNT), desk.ask(EYE)
    page.get_by_role("button", name="Sensors", exact=True).click()
    sensors = page.get_by_role("dialog", name="Sensors")
    sensors.get_by_role("button", name="Align sensors").click()
    expect(page.get_by_text("Sensors aligned")).to_be_visible()
    expect(page.get_by_text(r"mm apart, now")).to_be_visible()
    desk.until(f"({MOUNT}) !== {json.dumps(before)} && pb.labels()[1] === {labelled}")
    assert desk.ask(EYE) == pytest.approx(eye)
    sensors.get_by_role("button", name="Undo").click()
    desk.until(f"({MOUNT}) === {json.dumps(before)} && pb.labels()[1] === {labelled}")


def test_the_lidars_of_a_bag_become_one_recording(
    open_desk: Callable[..., Desk], server: LiveServer, tmp_path: Path
) -> None:
    desk = open_desk()
    page = desk.page
    dialog = choose(desk, [two_lidars(tmp_path)])
    expect(dialog.get_by_label("Topic")).to_have_value("/front/points")
    dialog.get_by_label("All sensors in one recording").check()
    desk.until("pb.state.importing.value.busy === false")
    expect(dialog.get_by_text("front (5 frames), rear (4 frames)")).to_be_visible()
    expect(dialog.get_by_label("Topic")).to_have_count(0)
    dialog.get_by_label("Name").fill("Van")
    dialog.get_by_label("Name").press("Tab")
    dialog.get_by_role("button", name="Import", exact=True).click()
    expect(dialog).to_have_count(0)
    page.locator(".toast").get_by_role("button", name="Open").click()
    desk.until("pb.state.sequence.value?.name === 'Van'")
    page.get_by_role("button", name="Sensors", exact=True).click()
    for name in ("front", "rear"):
        expect(page.get_by_role("dialog", name="Sensors").get_by_text(name)).to_be_visible()


def test_in_the_headset_a_stroke_leaves_the_points_of_a_hidden_sensor(
    browser: Browser, server: LiveServer
) -> None:
    server.create_label("stage", "person", "#ff5d5d")
    headset = wear(browser, server.page_url)
    headset.ready()
    headset.until("pb.state.activeLabel.value === 1")
    headset.enter()
    headset.set_radius(RADIUS)
    for hidden in (False, True):
        headset.click("palette", "View")
        headset.click("palette", "Sensors")
        if hidden:
            headset.click("palette", "front")
        else:
            headset.click("palette", "Colour by sensor")
            assert headset.ask("pb.state.view.value.color") == "sensor"
        headset.click("palette", "Back")
        headset.paint([on_person()])
        headset.settled()
        expected = {1, 2} if hidden else {0, 1, 2}
        eventually(lambda expected=expected: painted(server) == expected)
        headset.until("pb.state.undo.value !== null")
        headset.click("palette", headset.ask("pb.state.undo.value"))
        eventually(lambda: painted(server) == set())
    headset.close()
    assert headset.complaints == []
