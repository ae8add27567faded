"""At the desk: what it says without a headset, the ground tool, boxes and trails."""

from __future__ import annotations

import uuid
from collections.abc import Callable

import numpy as np

from tests.e2e.desk import Desk
from tests.e2e.recording import (
    PERSON,
    SEQUENCE,
    corners_of,
    heights,
    painted,
    put_dust,
    room_of,
    stands_as,
    tip_over,
)
from tests.e2e.server import LiveServer
from tests.waiting import eventually


def test_without_a_headset_the_desk_says_why_and_one_that_comes_is_offered(desk: Desk) -> None:
    assert desk.page.get_by_role("button", name="Enter VR").count() == 0
    desk.page.get_by_role("button", name="No headset").click()
    desk.page.get_by_text("Connect a headset, or open this page").first.wait_for()
    desk.ask(
        """(() => {
          navigator.xr.isSessionSupported = async (mode) => mode === 'immersive-vr';
          navigator.xr.dispatchEvent(new Event('devicechange'));
        })()"""
    )
    desk.page.get_by_role("button", name="Enter VR").wait_for()
    # A browser that knows nothing of WebXR.
    desk.page.add_init_script("delete Navigator.prototype.xr")
    desk.page.reload()
    desk.page.get_by_role("button", name="No headset").click()
    desk.page.get_by_text("This browser has no WebXR").first.wait_for()
    # That of a headset on plain HTTP is told unasked where to go, and by which address.
    desk.page.add_init_script(
        "Object.defineProperty(window, 'isSecureContext', { value: false });"
        "Object.defineProperty(navigator, 'userAgent', { value: 'Quest 3 OculusBrowser/37.0' });"
    )
    desk.page.reload()
    told = desk.page.get_by_role("alert")
    told.get_by_role("link", name="https://127.0.0.1").wait_for()
    code = told.get_by_role("img")
    code.evaluate("(image) => image.decode()")
    desk.screenshot("headset-on-http")
    told.get_by_role("button", name="Look around without entering").click()
    told.wait_for(state="detached")


def test_ground_is_one_click_and_boxes_are_drawn_at_the_desk_too(
    server: LiveServer, desk: Desk, truth: Callable[[int, int], list[float]]
) -> None:
    server.create_label(SEQUENCE, "floor", "#4cc38a")
    desk.until("pb.state.activeLabel.value === 1")
    desk.page.get_by_role("radio", name="Ground").click()
    desk.ask("(pb.state.brush.value = { ...pb.state.brush.value, radius: 0.08 })")
    points = server.points(SEQUENCE, 0)
    # A point of the floor before the people, in the middle of the picture.
    up = np.array(desk.ask("pb.engine.viewer.room.matrix.elements")).reshape(4, 4).T[1]
    floor = points[np.abs(points @ up[:3] + up[3]) < 0.02]
    place = floor[np.argmin(np.linalg.norm(floor[:, [0, 2]] - [0.0, 2.6], axis=1))]
    desk.paint([place.tolist()])
    desk.settled()
    label = server.annotation(SEQUENCE, 0)
    assert (label == 1).sum() > 300
    off = points[label == 1] - points[label == 1].mean(axis=0)
    spread = np.linalg.svd(off, compute_uv=False)
    assert spread[2] < 0.05 * spread[1]
    overlays = "window.__pointbrushHeadset.overlays()"
    assert desk.ask(f"{overlays}.boxes") == 0
    desk.page.get_by_role("button", name="Overlays").click()
    desk.page.get_by_role("checkbox", name="Boxes").check()
    desk.until(f"{overlays}.boxes === 1")
    stroke = {
        "id": str(uuid.uuid4()),
        "label": 1,
        "shape": "sphere",
        "radius": 0.1,
        "samples": [{"origin": truth(1, PERSON)}],
    }
    server.request("POST", f"sequences/{SEQUENCE}/frames/1/strokes", json=stroke)
    desk.press("ArrowRight")
    desk.until(f"{overlays}.trails === 2 && {overlays}.ghost > 300")
    set_the_floor(server, desk)


def set_the_floor(server: LiveServer, desk: Desk) -> None:
    """With the mouse, on a recording that stands crooked; then as it was."""
    found, crooked = tip_over(desk, server)
    desk.page.locator("button.sequence-button").click()
    desk.page.get_by_role("button", name="Set the floor…").click()
    hints = ["Set by one place", "Set by two places", "Set by three places"]
    for place, hint in zip(corners_of(crooked), hints, strict=True):
        desk.page.mouse.click(*desk.place(place))
        desk.page.get_by_text(hint).wait_for()
    assert np.abs(heights(server, crooked)).mean() < 0.02
    stands_as(desk, room_of(server))
    desk.page.get_by_role("button", name="Reset to import").click()
    stands_as(desk, found)
    assert np.allclose(room_of(server), found)
    desk.page.get_by_role("button", name="Done").click()
    desk.until("pb.state.tool.value === 'paint'")


def test_a_run_that_stopped_is_accepted_and_then_continued_at_the_desk(
    server: LiveServer, desk: Desk
) -> None:
    server.create_label(SEQUENCE, "dust", "#4cc38a")
    put_dust(server)
    desk.until("pb.state.timeline.value.rows.get(1)?.points[0] > 0")
    desk.page.get_by_role("button", name="Track…").click()
    desk.page.get_by_role("checkbox", name="Stop at doubtful frames").check()
    desk.page.get_by_role("button", name="Track 1 label").click()
    desk.page.get_by_text("Doubtful here: dust").first.wait_for()
    assert desk.ask("pb.state.frame.value") == 1
    desk.page.get_by_role("button", name="Continue to 5").wait_for()
    found = painted(server, 1)
    desk.press("Shift+Y")
    # A person has vouched for these points; the run goes on when it is told to.
    row = "pb.state.timeline.value.rows.get(1)"
    desk.until(f"{row}.painted[1] > 0")
    assert not desk.ask("pb.state.jobs.value.some((job) => job.state === 'running')")
    desk.press("Control+Enter")
    review = f"sequences/{SEQUENCE}/frames/1/review"
    eventually(lambda: server.request("GET", review).json()["state"] == "accepted")
    desk.page.get_by_role("button", name="Continue to 5").click()
    desk.until(f"{row}.points[2] > 0", 60)
    provenance = server.annotation(SEQUENCE, 1, "provenance")
    assert (provenance[server.annotation(SEQUENCE, 1) == 1] == 1).all()
    assert painted(server, 1) == found > 0
