"""A lead's walk: a task that one person hands in, the lead returns with a place, and accepts."""

from __future__ import annotations

from contextlib import closing

from playwright.sync_api import Browser

from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.e2e.desk import Desk, launch
from tests.e2e.recording import PERSON, SEQUENCE, Truth
from tests.e2e.server import LiveServer
from tests.waiting import eventually


def test_a_returned_task_leads_its_person_to_the_place(
    browser: Browser, server: LiveServer, truth: Truth
) -> None:
    with closing(Workspace(Settings(workspace=server.workspace))) as opened:
        token = opened.labels.tokens.add("annotator", "ada")
    lead = launch(browser, server.page_url)
    ada = launch(browser, f"{server.url}/?token={token}")
    walk(server, lead, ada, truth(0, PERSON))
    assert lead.complaints == ada.complaints == []
    for desk in (lead, ada):
        desk.context.close()


def walk(server: LiveServer, lead: Desk, ada: Desk, place: list[float]) -> None:
    """Go from tasks that are made to one that is accepted; ``place`` is in frame 0."""
    tasks = {desk: desk.page.get_by_role("complementary", name="Tasks") for desk in (lead, ada)}
    lead.ready()
    lead.page.get_by_role("button", name="Tasks").first.click()
    tasks[lead].get_by_text("Make tasks").first.click()
    tasks[lead].get_by_label("Frames of a task").fill("1")
    tasks[lead].get_by_role("button", name="Make tasks").click()
    tasks[lead].get_by_text("Nobody yet").wait_for()

    ada.ready()
    ada.press("Shift+N")
    own = tasks[ada].get_by_role("region", name="My task")
    own.get_by_text("begun").wait_for()
    ada.settled()
    own.get_by_role("button", name="Hand in, next task").click()
    eventually(lambda: _states(server)[:2] == ["done", "taken"])
    ada.until("pb.state.frame.value === 1")

    tasks[lead].get_by_role("button", name="Next to review").click()
    verdict = tasks[lead].get_by_role("form", name="Verdict")
    verdict.get_by_label("Note").fill("the hand is missing")
    verdict.get_by_role("button", name="Pin to a place").click()
    lead.page.mouse.click(*lead.place(place))
    verdict.get_by_role("button", name="Pinned").wait_for()
    lead.screenshot("team-lead")
    verdict.get_by_role("button", name="Send back").click()
    eventually(lambda: _states(server)[0] == "returned")

    ada.press("Shift+N")
    own.get_by_text("the hand is missing").wait_for()
    own.get_by_role("button", name="Go to the place in frame 0").wait_for()
    ada.until("pb.state.frame.value === 0")
    ada.page.locator(".review-mark").wait_for()
    ada.screenshot("team-returned")
    ada.press("Shift+N")
    eventually(lambda: _states(server)[0] == "done")

    tasks[lead].get_by_role("button", name="Next to review").click()
    verdict.get_by_role("button", name="Accept").click()
    eventually(lambda: "accepted" in _states(server))


def _states(server: LiveServer) -> list[str]:
    found = server.request("GET", "projects/default/tasks").json()
    return [each["state"] for each in found if each["sequence"] == SEQUENCE]
