"""Boxes of objects at the desk: chosen, dragged in three views, copied, drawn, undone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Locator, expect

from tests.e2e.desk import Desk
from tests.e2e.server import LiveServer
from tests.e2e.street import CARS, FIRST_CAR, FRAMES, SENSOR_HEIGHT, make_workspace, seen
from tests.e2e.test_accessibility import faults
from tests.waiting import eventually

SIZE = [4.0, 1.8, 1.4]
"""Of each car of the street."""
CHOSEN = "pb.state.activeLabel.value"


@pytest.fixture(scope="session")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_workspace(tmp_path_factory)


def paint_car(server: LiveServer) -> None:
    """Label the first car in all frames."""
    server.request("POST", "sequences/street/labels", json={"name": "Car", "category": "car"})
    for frame in range(FRAMES):
        server.put_annotation("street", frame, FIRST_CAR.astype(np.uint16))


def centre(frame: int) -> list[float]:
    """Place of the first car in a frame."""
    return [float(CARS[0][0] - 0.8 * frame), float(CARS[0][1]), 0.9 - SENSOR_HEIGHT]


def add_box(server: LiveServer, frames: range) -> int:
    """Put a box round the first car; returns its id."""
    pose = {"quaternion": [0, 0, 0, 1], "provenance": "fitted", "confidence": 0.8}
    poses = {str(frame): {"centre": centre(frame), **pose} for frame in frames}
    body = {"label": 1, "size": SIZE, "poses": poses, "provenance": "fitted"}
    made = server.request("POST", "sequences/street/boxes", json=body).json()
    number: int = made["box"]["id"]
    return number


def box_of(server: LiveServer) -> dict[str, Any]:
    (box,) = server.request("GET", "sequences/street/boxes").json()["boxes"]
    found: dict[str, Any] = box
    return found


def drag(desk: Desk, handle: Locator, right: float, down: float) -> None:
    """Drag by so many pixels."""
    bounds = handle.bounding_box()
    assert bounds is not None
    x, y = bounds["x"] + bounds["width"] / 2, bounds["y"] + bounds["height"] / 2
    desk.page.mouse.move(x, y)
    desk.page.mouse.down()
    desk.page.mouse.move(x + right, y + down, steps=3)
    desk.page.mouse.up()


def test_a_face_dragged_in_the_top_view_counts_in_all_frames_and_is_undone(
    open_desk: Callable[..., Desk], server: LiveServer
) -> None:
    paint_car(server)
    add_box(server, range(FRAMES))
    desk = open_desk(width=1720, height=900)
    desk.press("Shift+B")
    desk.ask("(pb.state.activeLabel.value = 0)")
    desk.page.mouse.click(*desk.place(centre(0)))
    desk.until(f"{CHOSEN} === 1")
    views = desk.page.locator(".box-view")
    views.nth(2).wait_for()
    assert faults(desk.page, "a box beside pictures") == []
    drag(desk, desk.page.locator('.box-view.top [data-handle="1 0"]'), 30, 0)
    eventually(lambda: box_of(server)["size"][0] > SIZE[0] + 0.1)
    box = box_of(server)
    grown = box["size"][0] - SIZE[0]
    assert box["size"][1:] == SIZE[1:]
    for frame in range(FRAMES):
        x, y, z = box["poses"][str(frame)]["centre"]
        assert [x - grown / 2, y, z] == pytest.approx(centre(frame), abs=1e-6)
    drawn = [frame for frame, pose in box["poses"].items() if pose["provenance"] == "drawn"]
    assert drawn == ["0"]
    desk.press("Control+z")
    eventually(lambda: box_of(server)["size"] == SIZE)
    # The keys: a step ahead in this frame alone, as one edit.
    desk.press("w")
    desk.press("w")
    eventually(lambda: box_of(server)["poses"]["0"]["centre"][0] > centre(0)[0] + 0.03)
    assert box_of(server)["poses"]["1"]["centre"] == pytest.approx(centre(1))


def test_a_copy_stands_on_the_ground_and_what_is_between_two_drawn_ones_is_filled(
    open_desk: Callable[..., Desk], server: LiveServer
) -> None:
    paint_car(server)
    number = add_box(server, range(1))
    desk = open_desk(width=1720, height=900)
    desk.press("Shift+B")
    desk.until(f"{CHOSEN} === 1")
    desk.page.get_by_role("button", name="Copy to next").click()
    eventually(lambda: "1" in box_of(server)["poses"])
    # The sensor drove on by 0.8 m: the car stands where it stood.
    assert box_of(server)["poses"]["1"]["centre"] == pytest.approx(centre(1), abs=1e-4)
    ends = {str(frame): {"centre": centre(frame), "quaternion": [0, 0, 0, 1]} for frame in (0, 4)}
    change = {"poses": {**ends, "1": None}}
    server.request("PATCH", f"sequences/street/boxes/{number}", json=change)
    desk.page.get_by_text("Not in this frame").wait_for()
    desk.page.keyboard.press("Shift+L")
    eventually(lambda: len(box_of(server)["poses"]) == FRAMES)
    box = box_of(server)
    for frame in range(FRAMES):
        assert box["poses"][str(frame)]["centre"] == pytest.approx(centre(frame), abs=1e-4)
    assert box["poses"]["2"]["provenance"] == "fitted"


def test_a_click_draws_a_box_in_the_size_of_its_class(
    open_desk: Callable[..., Desk], server: LiveServer
) -> None:
    server.request("POST", "sequences/street/labels", json={"name": "Car", "category": "car"})
    desk = open_desk(width=1720, height=900)
    desk.press("Shift+B")
    desk.until(f"{CHOSEN} === 1")
    # Nothing is labelled: there is nothing to fit a box to.
    expect(desk.page.get_by_role("button", name="Fit", exact=True)).to_have_count(1)  # the view's
    expect(desk.page.get_by_role("button", name="Track and fit")).to_have_count(0)
    desk.page.get_by_role("button", name="Draw a box").click()
    desk.page.mouse.click(*desk.place(centre(0)))
    eventually(lambda: len(server.request("GET", "sequences/street/boxes").json()["boxes"]) == 1)
    box = box_of(server)
    assert box["size"] == pytest.approx([4.4, 1.85, 1.6])
    assert np.linalg.norm(np.subtract(box["poses"]["0"]["centre"], centre(0))) < 2.5
    assert len(seen(0)) > 0
    desk.page.set_viewport_size({"width": 1280, "height": 720})
    occluded = desk.page.get_by_label("Occluded")
    # "not set" and the arrow, neither of them cut.
    desk.until("document.documentElement.clientWidth === 1280")
    bounds = occluded.bounding_box()
    assert bounds is not None
    assert bounds["width"] > 80


def test_the_camera_shows_the_box(open_desk: Callable[..., Desk], server: LiveServer) -> None:
    paint_car(server)
    add_box(server, range(FRAMES))
    desk = open_desk(width=1720, height=900)
    desk.press("Shift+B")
    line = desk.page.locator(".camera-outlines > path.chosen")
    line.wait_for(state="attached")
    assert line.get_attribute("d")


def test_four_clicks_lead_from_an_object_to_its_exported_boxes(
    open_desk: Callable[..., Desk], server: LiveServer
) -> None:
    server.request("POST", "sequences/street/labels", json={"name": "Car", "category": "car"})
    desk = open_desk(width=1720, height=900)
    desk.press("j")
    desk.page.mouse.move(*desk.place(centre(0)))
    desk.until("pb.state.object.value?.ready")
    desk.page.mouse.click(*desk.place(centre(0)))
    desk.until("pb.state.undo.value !== null && pb.state.pending.value === 0")
    for role, name in (("radio", "Boxes"), ("button", "Track and fit")):
        desk.page.get_by_role(role, name=name).click()  # type: ignore[arg-type]
    eventually(lambda: len(server.request("GET", "sequences/street/boxes").json()["boxes"]) == 1)
    assert len(box_of(server)["poses"]) == FRAMES
    desk.page.get_by_role("button", name="Export").click()
    with desk.page.expect_download() as download:
        desk.page.locator(".export-format", has_text="KITTI tracking").click()
    assert download.value.suggested_filename.endswith(".zip")
