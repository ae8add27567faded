"""A stroke ends with the frame, the view and the gesture that it began in."""

from __future__ import annotations

from typing import Any

from tests.e2e.desk import Desk
from tests.e2e.headset import Headset
from tests.e2e.recording import PERSON, SEQUENCE, Truth, name_person, painted
from tests.e2e.server import LiveServer


def test_escape_gives_a_stroke_or_lasso_up(desk: Desk, server: LiveServer, truth: Truth) -> None:
    name_person(desk, server)
    edits = len(server.request("GET", f"sequences/{SEQUENCE}/edits").json())
    x, y, z = truth(0, PERSON)
    for shape in ("b", "o"):
        desk.press(shape)
        desk.paint([[x, y, z], [x + 0.1, y, z], [x + 0.1, y + 0.2, z]], release=False)
        desk.press("Escape")
        desk.page.mouse.up()
        desk.settled()
        desk.pictures()
        assert desk.labels().get(1, 0) == 0
        assert len(server.request("GET", f"sequences/{SEQUENCE}/edits").json()) == edits


def test_a_step_ends_the_stroke_of_the_frame_before(
    desk: Desk, server: LiveServer, truth: Truth
) -> None:
    name_person(desk, server)
    x, y, z = truth(0, PERSON)
    desk.paint([[x, y, z]], release=False)
    desk.until("(pb.labels()[1] ?? 0) > 0")
    desk.press("ArrowRight")
    desk.until("pb.shown().frame === 1")
    desk.page.mouse.move(*desk.place([x, y + 0.15, z]), steps=4)
    desk.page.mouse.up()
    desk.settled()
    assert painted(server, 0) > 0
    assert painted(server, 1) == 0


def test_two_fingers_move_the_camera_and_paint_nothing(
    desk: Desk, server: LiveServer, truth: Truth
) -> None:
    name_person(desk, server)
    edits = len(server.request("GET", f"sequences/{SEQUENCE}/edits").json())
    x, y = desk.place(truth(0, PERSON))
    before = desk.ask(f"pb.project({truth(0, PERSON)})")
    session = desk.context.new_cdp_session(desk.page)

    def touch(kind: str, *places: tuple[float, float]) -> None:
        points: list[dict[str, Any]] = [
            {"x": px, "y": py, "id": i} for i, (px, py) in enumerate(places)
        ]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    touch("touchStart", (x, y))
    touch("touchMove", (x + 12, y))
    touch("touchStart", (x + 12, y), (x + 100, y))
    for step in range(1, 6):
        touch("touchMove", (x - 10 * step, y), (x + 100 + 20 * step, y))
    touch("touchEnd", (x - 50, y))
    touch("touchEnd")
    desk.settled()
    desk.pictures()
    assert desk.labels().get(1, 0) == 0
    assert len(server.request("GET", f"sequences/{SEQUENCE}/edits").json()) == edits
    assert desk.ask(f"pb.project({truth(0, PERSON)})") != before


def test_in_the_headset_a_step_ends_the_stroke_until_the_trigger_is_let_go(
    headset: Headset, server: LiveServer, truth: Truth
) -> None:
    x, y, z = truth(0, PERSON)
    headset.paint([[x, y, z]], release=False)
    headset.until("(pb.labels()[1] ?? 0) > 5")
    headset.flick_to_frame(1)
    headset.reach([x, y + 0.1, z])
    headset.frames(4)
    assert painted(server, 1, 1) == 0
    headset.trigger(0)
    headset.settled()
    assert painted(server, 0, 1) > 5
    assert painted(server, 1, 1) == 0
    headset.paint([truth(1, PERSON)])
    headset.settled()
    assert painted(server, 1, 1) > 5


def test_in_the_headset_a_turn_sweeps_no_ball(
    headset: Headset, server: LiveServer, truth: Truth
) -> None:
    x, y, z = truth(0, PERSON)
    headset.paint([[x, y, z]], release=False)
    headset.until("(pb.labels()[1] ?? 0) > 5")
    headset.flick(1.0, 0.0, hand="left")
    headset.frames(4)
    headset.trigger(0)
    headset.settled()
    points = server.points(SEQUENCE, 0)
    mine = points[server.annotation(SEQUENCE, 0) == 1]
    radius = headset.ask("pb.state.brush.value.radius")
    assert len(mine) > 5
    assert (((mine - [x, y, z]) ** 2).sum(axis=1) ** 0.5).max() < 1.5 * radius
