"""The history on the desk: who changed what, and the way to its frame."""

from __future__ import annotations

from tests.e2e.desk import Desk
from tests.e2e.recording import PERSON, Truth, name_person
from tests.e2e.server import LiveServer


def test_lists_edits_and_goes_to_their_frame(desk: Desk, server: LiveServer, truth: Truth) -> None:
    name_person(desk, server)
    desk.press("ArrowRight")
    desk.until("pb.shown().frame === 1 && pb.shown().points === pb.shown().total")
    x, y, z = truth(1, PERSON)
    desk.paint([[x, y, z], [x, y + 0.1, z]])
    desk.settled()
    desk.press("ArrowRight")
    desk.until("pb.state.frame.value === 2")

    desk.page.get_by_role("button", name="History: who changed what").click()
    panel = desk.page.get_by_role("dialog", name="History")
    stroke = panel.get_by_role("button").filter(has_text="frame 1")
    stroke.wait_for()
    assert "point" in stroke.inner_text()
    stroke.click()
    desk.until("pb.state.frame.value === 1")

    desk.press("Control+z")
    taken_back = panel.get_by_role("button").filter(has_text="taken back")
    taken_back.first.wait_for()
