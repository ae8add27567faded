"""Outlines and views at the desk."""

from __future__ import annotations

from tests.e2e.desk import Desk
from tests.e2e.recording import PERSON, SEQUENCE, Truth, heights, name_person, painted
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
    desk.until(
        f"Math.hypot({at}[0] - {wide / 2}, {at}[1] - {high / 2}) < 2 && !pb.engine.camera.flying"
    )
    desk.press("p")
    desk.until("!pb.engine.viewer.camera.orthographic && !pb.engine.camera.flying")
    desk.page.get_by_role("button", name="Saved views").click()
    desk.page.get_by_role("button", name="Save this view").click()
    before = desk.ask(f"pb.project({middle})")
    desk.press("Escape")
    desk.press("r")
    desk.until(f"Math.abs(pb.project({middle})[0] - {before[0]}) > 20")
    desk.page.get_by_role("button", name="Saved views").click()
    desk.page.get_by_role("button", name="Go to View 1").click()
    desk.until(f"Math.abs(pb.project({middle})[0] - {before[0]}) < 1")


def drag(desk: Desk, start: tuple[float, float], stop: tuple[float, float]) -> None:
    desk.page.mouse.move(*start)
    desk.page.mouse.down()
    desk.page.mouse.move(*stop, steps=4)
    desk.page.mouse.up()


def test_boxes_are_adjusted_and_a_slab_bounds_every_tool(
    desk: Desk, server: LiveServer, truth: Truth
) -> None:
    name_person(desk, server)
    person = truth(0, PERSON)
    desk.press("t")
    desk.until("pb.engine.viewer.camera.orthographic && !pb.engine.camera.flying")
    mouse = desk.page.mouse
    x, y = desk.place(person)
    desk.press("m")
    drag(desk, (x - 40, y - 40), (x + 40, y + 40))
    desk.until("(pb.labels()[1] ?? 0) > 200")
    whole = desk.labels()[1]
    # A face is pushed in and pulled out again; what the box would take is shown at once.
    drag(desk, (x + 40, y), (x - 36, y))
    desk.until(f"(pb.labels()[1] ?? 0) < {whole / 2}")
    drag(desk, (x - 36, y), (x + 40, y))
    desk.until(f"pb.labels()[1] > {0.9 * whole}")
    desk.press("Shift+G")
    desk.until("(pb.labels()[1] ?? 0) > 200")
    shown = desk.labels()[1]
    desk.press("Enter")
    desk.settled()
    assert abs(painted(server, 0) - shown) < 0.01 * shown, "but for points on a face"
    xyz = server.points(SEQUENCE, 0).astype(float)
    above = heights(server, xyz)
    taken = above[server.annotation(SEQUENCE, 0) == 1]
    assert 0 < taken.min() < 0.15, "the floor is left out, and nothing else"
    assert taken.max() > 1.4
    undo(desk)

    desk.page.get_by_role("button", name="Clip", exact=True).click()
    desk.page.get_by_role("radio", name="Level").click()
    desk.press("Escape")
    desk.press("o")
    wide, high = desk.ask("[view.clientWidth, view.clientHeight]")
    left, top = desk.ask("(({ x, y }) => [x, y])(view.getBoundingClientRect())")

    def lasso_everything() -> tuple[float, float]:
        """Lasso the whole picture; the lowest and highest point that the server gave the label."""
        before = server.annotation(SEQUENCE, 0) == 1
        corners = [(0.01, 0.3), (0.99, 0.3), (0.99, 0.95), (0.01, 0.95)]
        mouse.move(left + corners[0][0] * wide, top + corners[0][1] * high)
        mouse.down()
        for u, v in corners[1:]:
            mouse.move(left + u * wide, top + v * high, steps=3)
        desk.until(f"(pb.labels()[1] ?? 0) > {before.sum()}")
        shown = desk.labels()[1]
        mouse.up()
        desk.settled()
        now = server.annotation(SEQUENCE, 0) == 1
        assert abs(int(now.sum()) - shown) < 0.01 * shown
        fresh = above[now & ~before]
        return float(fresh.min()), float(fresh.max())

    low, high_up = lasso_everything()
    assert 0.05 < high_up - low < 1.0
    for _ in range(4):
        desk.press("PageUp")
    above_it, _ = lasso_everything()
    assert above_it >= high_up - 0.02, "four notches are the slab's thickness"
    desk.press("y")
    assert desk.page.get_by_text("strokes reach nothing else").count() == 0
