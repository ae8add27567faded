"""A team's walk: a queue, work by the keyboard alone, reviews, agreement, versions, an export."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import closing
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
import pytest
from playwright.sync_api import Browser, Locator

from pointbrush.client import Client
from pointbrush.sequences.storage.manifest import rename_sequence, update_manifest
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.e2e.conftest import DATA
from tests.e2e.desk import Desk, launch
from tests.e2e.recording import PERSON, SEQUENCE, Truth
from tests.e2e.server import LiveServer
from tests.e2e.test_accessibility import faults
from tests.waiting import eventually

FLOWN = "(([x, y], v) => Math.hypot(x - v.clientWidth / 2, y - v.clientHeight / 2) < 20)"
NAMES = {SEQUENCE: "Juggling", "hall": "Hall", "yard": "Yard"}


@pytest.fixture
def server(template: Path, tmp_path: Path) -> Iterator[LiveServer]:
    """A server with three recordings of the same points."""
    workspace = tmp_path / "workspace"
    shutil.copytree(template, workspace)
    for id_ in NAMES.keys() - {SEQUENCE}:
        folder = workspace / "sequences" / id_
        shutil.copytree(workspace / "sequences" / SEQUENCE, folder)
        rename_sequence(folder, id_)
        update_manifest(folder, name=NAMES[id_])
    live = LiveServer(workspace)
    live.start()
    yield live
    live.stop()


def test_a_lead_gives_work_compares_it_returns_it_and_exports_it(
    browser: Browser, server: LiveServer, truth: Truth
) -> None:
    with closing(Workspace(Settings(workspace=server.workspace))) as opened:
        tokens = {name: opened.labels.tokens.add("annotator", name) for name in ("ada", "bob")}
    lead, ada = launch(browser, server.page_url), None
    try:
        project(lead, server)
        queue(lead, server)
        ada = launch(browser, f"{server.url}/?token={tokens['ada']}")
        with Client(server.url, tokens["bob"]) as bob:
            apart(ada, bob)
        returned(server, lead, ada, truth(0, PERSON))
        agreed(server, lead)
        versions(lead, server)
        assert lead.complaints == ada.complaints == []
    finally:
        for desk in filter(None, (lead, ada)):
            desk.close()


def project(lead: Desk, server: LiveServer) -> None:
    """Make a project on the start page, of three recordings."""
    lead.until("window.__pointbrush && pb.state.sequences.value?.length === 3")
    lead.page.get_by_role("button", name="New project").click()
    lead.page.get_by_label("Name", exact=True).fill("Night")
    lead.press("Enter")
    lead.page.get_by_role("region", name="Night").wait_for()
    for id_ in NAMES:
        server.create_label(id_, "person", "#ff5d5d")
    server.request("PATCH", "projects/night", json={"recordings": list(NAMES)})
    people(lead, server)


def people(lead: Desk, server: LiveServer) -> None:
    """Warn about an unknown name, create its account, let its link in, and revoke it."""
    page = lead.page
    night = page.get_by_role("region", name="Night")
    night.get_by_role("button", name="Settings").click()
    dialog = page.get_by_role("dialog", name="Settings of the project")
    dialog.get_by_label("Account", exact=True).fill("ada")
    page.locator("#settings-people option").nth(1).wait_for(state="attached")
    assert dialog.get_by_role("button", name="Create account").count() == 1
    dialog.get_by_label("Account", exact=True).fill("grace")
    dialog.get_by_label("Role of the new person").select_option("reviewer")
    unknown = dialog.get_by_text("No account with access is called “grace”")
    unknown.get_by_role("button", name="Create account").click()
    entry = dialog.get_by_role("listitem").filter(has_text="grace")
    entry.get_by_text("reviewer · 1 token").wait_for()
    link = dialog.get_by_role("code").first.inner_text()
    unknown.wait_for(state="detached")
    lead.screenshot("team-accounts")
    assert faults(page, "accounts", "dialog.settings") == []
    with Client(server.url, link.partition("token=")[2]) as grace:
        assert grace.call("GET", "/session").json() == {"author": "grace", "role": "reviewer"}
    entry.get_by_role("button", name="Revoke all tokens of grace").click()
    entry.get_by_role("button", name="Revoke", exact=True).click()
    entry.get_by_text("no access").wait_for()
    page.get_by_role("button", name="Close the settings").click()


def queue(lead: Desk, server: LiveServer) -> None:
    """Make four tasks: one recording for two people, the others for one."""
    lead.page.get_by_role("button", name="Juggling").first.click()
    lead.ready()
    lead.page.get_by_role("button", name="Work").click()
    panel = work_of(lead)
    panel.get_by_role("heading", name="Night").wait_for()
    panel.get_by_role("tab", name="Tasks").click()
    panel.get_by_text("Make tasks").first.click()
    panel.get_by_label("Annotators per task").fill("2")
    panel.get_by_role("button", name="Make tasks").click()
    eventually(lambda: len(states(server)) == 2)
    body = {"recordings": ["hall", "yard"]}
    server.request("POST", "projects/night/tasks", json=body)


def apart(ada: Desk, bob: Client) -> None:
    """Two people label the same, and see nothing of each other; Ada uses the keyboard alone."""
    theirs = bob.projects["night"]
    ada.until("window.__pointbrush && pb.state.sequences.value?.length === 3")
    ada.page.get_by_role("region", name="Night").wait_for()
    go_by_keys(ada, "Next task")
    ada.ready()
    task = theirs.next_task()
    assert task is not None
    assert task.sequence != ada.ask("pb.state.sequence.value.id")
    paint(bob, task.sequence, half=True)
    theirs.put_task(task.number, state="done")
    panel = work_of(ada)
    panel.get_by_role("region", name="My task").get_by_text("Juggling").wait_for()
    assert panel.get_by_text("bob").count() == 0
    assert panel.get_by_role("tab", name="Agreement").count() == 0
    # A task without a change is handed in only after a question.
    ada.press("Shift+N")
    question = ada.page.get_by_role("dialog", name="Hand in without changes?")
    question.wait_for()
    ada.screenshot("team-question")
    assert faults(ada.page, "question", "dialog") == []
    ada.press("Enter")
    question.wait_for(state="detached")
    assert ada.ask("pb.state.sequence.value.id") != "hall"
    hand_in_unchanged(ada)
    ada.until("pb.state.sequence.value?.id === 'hall'")
    ada.ready()


def hand_in_unchanged(ada: Desk) -> None:
    """Hand the task in though nothing was changed."""
    ada.press("Shift+N")
    ada.page.get_by_role("dialog", name="Hand in without changes?").wait_for()
    ada.press("Tab")
    ada.press("Enter")


def go_by_keys(desk: Desk, name: str) -> None:
    """Press Tab until a button has the focus, then Enter."""
    wanted = f"document.activeElement?.textContent === '{name}'"
    eventually(lambda: desk.press("Tab") or desk.ask(wanted))
    desk.press("Enter")


def command(desk: Desk, words: str) -> None:
    """Run a command that is found by its words."""
    desk.press("Control+k")
    desk.page.get_by_label("Search commands").fill(words)
    desk.press("Enter")


def paint(client: Client, sequence: str, *, half: bool = False) -> None:
    """Label the person in frame 0, or what of them comes first."""
    with np.load(DATA / "0000.npz") as arrays:
        mine = np.flatnonzero(arrays["truth"] == PERSON)
        values = np.zeros(len(arrays["truth"]), np.uint16)
    values[mine[: len(mine) // 2] if half else mine] = 1
    client[sequence].frames[0].annotate(values)


def returned(server: LiveServer, lead: Desk, ada: Desk, place: list[float]) -> None:
    """Send a task back with a note and a place; Ada is led there, and hands it in again."""
    own = work_of(ada).get_by_role("region", name="My task")
    own.get_by_text("Hall").first.wait_for()
    paint_by_keys(ada)
    ada.press("Shift+N")
    eventually(lambda: states(server)["hall"] == "done")
    panel = work_of(lead)
    eventually(lambda: again(lead, "Hall, frames 0–5"))
    panel.get_by_role("button", name="Hall, frames 0–5").click()
    lead.until("pb.state.sequence.value?.id === 'hall'")
    lead.ready()
    verdict = panel.get_by_role("form", name="Verdict")
    verdict.get_by_label("Note").fill("the hand is missing")
    verdict.get_by_role("button", name="Pin to a place").click()
    lead.page.mouse.click(*lead.place(place))
    verdict.get_by_role("button", name="Pinned").wait_for()
    lead.screenshot("team-lead")
    assert faults(lead.page, "tasks", "#work") == []
    verdict.get_by_role("button", name="Return").click()
    eventually(lambda: states(server)["hall"] == "returned")
    ada.until("pb.state.sequence.value?.id === 'yard'")
    ada.ready()
    hand_in_unchanged(ada)
    eventually(lambda: states(server)["yard"] == "done")
    own.get_by_text("the hand is missing").wait_for()
    ada.until("pb.state.sequence.value?.id === 'hall'")
    ada.page.locator(".work-mark").wait_for()
    ada.until(f"{FLOWN}(pb.project({place}), document.querySelector('#view'))")
    ada.screenshot("team-returned")
    paint_by_keys(ada)
    ada.press("Shift+N")
    eventually(lambda: states(server)["hall"] == "done")
    reviewed(server, lead)


def paint_by_keys(desk: Desk) -> None:
    """Paint what is in the middle of the picture."""
    desk.until("pb.state.activeLabel.value === 1")
    desk.press("b")
    desk.press("0")
    desk.settled()


def reviewed(server: LiveServer, lead: Desk) -> None:
    """Accept the next task by the keyboard alone."""
    lead.page.locator("#view").focus()
    command(lead, "review the next task")
    lead.until("document.querySelector('[aria-label=Verdict]') !== null")
    lead.ready()
    command(lead, "accept the task")
    eventually(lambda: "accepted" in states(server).values())


def agreed(server: LiveServer, lead: Desk) -> None:
    """Look at a place where two people differ, see both versions, and take one's."""
    panel = work_of(lead)
    server.request("POST", "projects/night/snapshots", json={"name": "Before"})
    panel.get_by_role("button", name="Juggling, frames 0–5").first.click()
    lead.until("pb.state.sequence.value?.id.startsWith('juggling-')")
    panel.get_by_role("tab", name="Agreement").click()
    panel.get_by_text("person: only bob has it").click()
    lead.until(f"pb.state.sequence.value?.id === '{SEQUENCE}'")
    lead.ready()
    lead.page.locator(".work-mark").wait_for()
    looks = panel.get_by_role("radiogroup", name="Show the labels of")
    looks.get_by_role("radio", name="bob").click()
    lead.until("pb.labels()[1] > 0")
    lead.screenshot("team-agreement")
    assert faults(lead.page, "agreement", "#work") == []
    looks.get_by_role("radio", name="Recording").click()
    lead.until("!(pb.labels()[1] > 0)")
    panel.get_by_role("button", name="Use bob’s").click()
    panel.get_by_role("button", name="Use bob’s", pressed=True).wait_for()
    assert (server.annotation(SEQUENCE, 0) == 1).any()


def versions(lead: Desk, server: LiveServer) -> None:
    """Name the labels, see how they differ from those before, and export them."""
    panel = work_of(lead)
    panel.get_by_role("tab", name="Versions").click()
    panel.get_by_label("Name of the snapshot").fill("After")
    panel.get_by_role("button", name="Make a snapshot").click()
    panel.get_by_role("button", name="After").wait_for()
    panel.get_by_role("button", name="Before").click()
    difference = panel.get_by_role("region", name="Difference")
    difference.get_by_role("button", name="0", exact=True).wait_for()
    lead.screenshot("team-versions")
    assert faults(lead.page, "versions", "#work") == []
    with lead.page.expect_download() as saved:
        panel.get_by_label("Export this recording from the snapshot").select_option("npz")
    archive = ZipFile(BytesIO(saved.value.path().read_bytes()))
    assert any(name.endswith(".npz") for name in archive.namelist())


def work_of(desk: Desk) -> Locator:
    return desk.page.get_by_role("complementary", name="Work")


def again(desk: Desk, entry: str) -> bool:
    """Whether an entry is there; the tasks of others are loaded when the panel is opened."""
    for _ in ("close", "open"):
        desk.page.get_by_role("button", name="Work", exact=True).click()
    return work_of(desk).get_by_role("button", name=entry).count() > 0


def states(server: LiveServer) -> dict[str, Any]:
    found = server.request("GET", "projects/night/tasks").json()
    return {each["sequence"]: each["state"] for each in found}
