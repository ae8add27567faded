"""The history on the desk: who changed what, and the way to its frame."""

from __future__ import annotations

from tests.e2e.desk import Desk
from tests.e2e.recording import Truth, name_person, paint_person, painted
from tests.e2e.server import LiveServer


def test_lists_edits_and_goes_to_their_frame(desk: Desk, server: LiveServer, truth: Truth) -> None:
    name_person(desk, server)
    desk.press("ArrowRight")
    desk.until("pb.shown().frame === 1 && pb.shown().points === pb.shown().total")
    paint_person(desk, truth, 1)
    desk.press("ArrowRight")
    desk.until("pb.state.frame.value === 2")

    desk.page.get_by_role("button", name="History of edits").click()
    panel = desk.page.get_by_role("dialog", name="History")
    stroke = panel.get_by_role("button").filter(has_text="frame 1")
    stroke.wait_for()
    assert "point" in stroke.inner_text()
    stroke.click()
    desk.until("pb.state.frame.value === 1")

    desk.press("Control+z")
    taken_back = panel.get_by_role("button").filter(has_text="undone")
    taken_back.first.wait_for()


def test_a_second_tab_of_one_browser_takes_back_the_strokes_of_the_first(
    desk: Desk, server: LiveServer, truth: Truth
) -> None:
    name_person(desk, server)
    paint_person(desk, truth)
    one = painted(server, 0)
    assert one > 0
    paint_person(desk, truth, above=0.3)
    assert painted(server, 0) > one
    desk.press("Control+z")
    desk.settled()
    assert painted(server, 0) == one

    # The printed URL again signs in anew.
    tab = Desk(desk.context.new_page(), server.page_url)
    tab.ready()
    tab.press("Control+z")
    tab.until("pb.labels()[1] === undefined")
    tab.settled()
    assert painted(server, 0) == 0
    assert tab.complaints == []


def test_undo_goes_on_after_a_restart_with_another_token(
    desk: Desk, server: LiveServer, truth: Truth
) -> None:
    name_person(desk, server)
    paint_person(desk, truth)
    assert painted(server, 0) > 0
    desk.page.close()
    server.stop()
    server.token = "the token of another start"
    server.start()

    again = Desk(desk.context.new_page(), server.page_url)
    again.ready()
    again.press("Control+z")
    again.until("pb.labels()[1] === undefined")
    again.settled()
    assert painted(server, 0) == 0
    assert again.complaints == []
