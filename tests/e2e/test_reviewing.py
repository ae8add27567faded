"""The review at the desk: from one suspicious thing to the next, states with pinned notes."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.e2e.desk import Desk
from tests.e2e.recording import PERSON, SEQUENCE, Truth, painted, put_dust
from tests.e2e.server import LiveServer
from tests.waiting import eventually


def test_leads_from_finding_to_finding_and_pins_a_note(
    desk: Desk, server: LiveServer, truth: Truth
) -> None:
    pin = server.create_label(SEQUENCE, "pin", "#3fd0ff")
    middle = truth(1, PERSON)
    points = np.linalg.norm(server.points(SEQUENCE, 1) - middle, axis=1)
    speck = {"label": pin, "shape": "sphere", "radius": float(np.sort(points)[2]) + 1e-4}
    sample = {"origin": middle, "direction": [0, 0, 1], "t": 0}
    path = f"sequences/{SEQUENCE}/frames/1/strokes"
    server.request("POST", path, json={**speck, "samples": [sample]})
    server.create_label(SEQUENCE, "pin", "#ffd23f")

    page = desk.page
    # The key looks for findings, opens the review and goes to the first of them.
    desk.press("z")
    panel = page.get_by_role("complementary", name="Work")
    panel.get_by_text("has only 3 points").wait_for()
    for _ in range(3):
        if "has only" in panel.locator("[data-current]").inner_text():
            break
        desk.press("z")
    desk.until("pb.shown().frame === 1 && pb.state.activeLabel.value === 1")
    # The camera has flown: the place is in the middle of the picture.
    page.locator(".work-mark").wait_for()
    x, y = page.evaluate("[innerWidth, innerHeight]")

    def centred() -> bool:
        box = page.locator("#view").bounding_box()
        at = desk.place(middle)
        assert box is not None
        return (
            abs(at[0] - box["x"] - box["width"] / 2) < 0.05 * x
            and abs(at[1] - box["y"] - box["height"] / 2) < 0.05 * y
        )

    eventually(centred)
    desk.screenshot("review-findings")

    panel.get_by_role("button", name="Write a note…").click()
    note = panel.get_by_label("Note")
    assert "3 points" in note.input_value()
    note.fill("a slip of the brush")
    panel.get_by_role("button", name="Pinned: change the place").click()
    page.mouse.click(*desk.place(middle))
    panel.get_by_role("button", name="Needs correction").click()

    def rejected() -> Any:
        return server.request("GET", f"sequences/{SEQUENCE}/frames/1/review").json()

    found = eventually(lambda: (told := rejected())["state"] == "rejected" and told)
    assert found["note"] == "a slip of the brush"
    assert np.linalg.norm(np.subtract(found["place"], middle)) < 0.2
    panel.get_by_role("button", name="a slip of the brush").wait_for()
    desk.screenshot("review-states")

    panel.get_by_role("tab", name="Findings").click()
    # A finding about several labels does not change the label of the next stroke.
    panel.get_by_role("button", name="2 labels are called").click()
    panel.locator("[data-current]").get_by_text("2 labels are called").wait_for()
    assert desk.ask("pb.state.activeLabel.value") == pin
    panel.get_by_role("button", name="Confirm").click()
    panel.get_by_text("2 labels are called").wait_for(state="detached")
    checks = server.request("GET", f"sequences/{SEQUENCE}/checks").json()["findings"]
    assert [each["settled"] for each in checks if each["kind"] == "name"] == [True]

    panel.get_by_role("button", name="Close the panel").click()
    panel.wait_for(state="hidden")


def test_a_doubtful_frame_is_mended_and_accepted_by_keys_alone(
    desk: Desk, server: LiveServer
) -> None:
    server.create_label(SEQUENCE, "dust", "#e86fd0")
    put_dust(server)
    body = {"start": 0, "stop": 1, "labels": [1]}
    server.request("POST", f"sequences/{SEQUENCE}/tracking", json=body)
    desk.until("pb.state.timeline.value.rows.get(1)?.points[1] > 0", 60)
    doubtful = painted(server, 1)

    desk.page.locator("#view").focus()
    desk.press(".")
    desk.until("pb.shown().frame === 1 && pb.state.activeLabel.value === 1")
    desk.page.get_by_text("Doubtful here: dust").wait_for()
    # With the camera at the object, the middle of the picture is painted.
    desk.press("b")
    desk.press("0")
    desk.settled()
    desk.page.get_by_text("Doubtful here: dust").wait_for(state="detached")
    assert painted(server, 1) > doubtful
    desk.press("Control+Enter")
    path = f"sequences/{SEQUENCE}/frames/1/review"
    eventually(lambda: server.request("GET", path).json()["state"] == "accepted")
