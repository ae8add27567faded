"""Outlines and views at the desk."""

from __future__ import annotations

from tests.e2e.desk import Desk
from tests.e2e.recording import PERSON, SEQUENCE, Truth, name_person, painted
from tests.e2e.server import LiveServer


def undo(desk: Desk) -> None:
    desk.press("Control+z")
    desk.until("!(1 in pb.labels())")
    desk.settled()


def test_outlines_in_a_plan_take_what_they_show(
    desk: Desk, server: LiveServer, truth: Truth
) -> None:
    name_person(desk, server)
    person = truth(0, PERSON)
    desk.press("t")
    desk.until("pb.engine.viewer.camera.orthographic")
    mouse = desk.page.mouse
    x, y = desk.place(person)
    desk.press("o")
    desk.press("o")
    mouse.move(x - 30, y - 30)
    mouse.down()
    mouse.move(x + 30, y + 30, steps=4)
    desk.until("(pb.labels()[1] ?? 0) > 200")
    shown = desk.labels()[1]
    mouse.up()
    desk.settled()
    assert abs(painted(server, 0) - shown) < 0.01 * shown
    undo(desk)
    desk.press("o")
    corners = [(x - 40, y - 30), (x + 30, y - 30), (x + 45, y), (x + 30, y + 30), (x - 40, y + 30)]
    for corner in corners:
        mouse.click(*corner)
    mouse.move(x, y + 40)
    desk.press("Backspace")
    desk.press("Enter")
    desk.settled()
    desk.until("(pb.labels()[1] ?? 0) > 200")
    assert painted(server, 0) == desk.labels()[1]
    middle = server.points(SEQUENCE, 0)[server.annotation(SEQUENCE, 0) == 1].mean(0).tolist()
    desk.press("f")
    wide, high = desk.ask("[view.clientWidth, view.clientHeight]")
    at = f"pb.project({middle})"
    desk.until(f"Math.hypot({at}[0] - {wide / 2}, {at}[1] - {high / 2}) < 2")
    desk.press("p")
    desk.until("!pb.engine.viewer.camera.orthographic")
    desk.page.get_by_role("button", name="Views to come back to").click()
    desk.page.get_by_role("button", name="Keep this view").click()
    before = desk.ask(f"pb.project({middle})")
    desk.press("Escape")
    desk.press("r")
    desk.until(f"Math.abs(pb.project({middle})[0] - {before[0]}) > 20")
    desk.page.get_by_role("button", name="Views to come back to").click()
    desk.page.get_by_role("button", name="Go to View 1").click()
    desk.until(f"Math.abs(pb.project({middle})[0] - {before[0]}) < 1")
