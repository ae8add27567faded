"""A recording that somebody deletes while it is open, and the way back."""

from __future__ import annotations

from tests.e2e.desk import Desk
from tests.e2e.recording import PERSON, SEQUENCE, Truth, name_person, painted
from tests.e2e.server import LiveServer


def test_a_deleted_recording_is_told_of_and_restored_on_the_page(
    desk: Desk, server: LiveServer, truth: Truth
) -> None:
    name_person(desk, server)
    desk.paint([truth(0, PERSON)])
    desk.settled()
    count = painted(server, 0)
    assert count > 0
    server.request("DELETE", f"sequences/{SEQUENCE}")
    desk.until("pb.state.sequence.value === null")
    assert "sequence=" not in desk.page.url
    desk.page.get_by_role("button", name="1 deleted recording").click()
    desk.page.get_by_role("button", name="Restore").click()
    desk.page.locator("button.recording", has_text="Juggling").click()
    desk.ready()
    desk.until(f"pb.labels()[1] === {count}")
