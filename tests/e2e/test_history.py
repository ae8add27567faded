"""The history on the desk: who changed what, and the way to its frame."""

from __future__ import annotations

from collections.abc import Callable

from tests.e2e.desk import Desk
from tests.e2e.server import LiveServer

SEQUENCE = "juggling"
PERSON = 7
Truth = Callable[[int, int], list[float]]


def test_lists_edits_and_goes_to_their_frame(desk: Desk, server: LiveServer, truth: Truth) -> None:
    label = server.create_label(SEQUENCE, "person", "#ff5d5d")
    desk.until(f"pb.state.activeLabel.value === {label}")
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
    desk.screenshot("history")
    stroke.click()
    desk.until("pb.state.frame.value === 1")

    desk.press("Control+z")
    taken_back = panel.get_by_role("button").filter(has_text="taken back")
    taken_back.first.wait_for()
