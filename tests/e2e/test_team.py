"""A lead's walk: a project, its queue, two people compared, one returned, versions, an export."""

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
from pointbrush.sequences.manifest import rename_sequence, update_manifest
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
            desk.context.close()


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


def queue(lead: Desk, server: LiveServer) -> None:
    """Make four tasks: one recording for two people, the others for one."""
    lead.page.get_by_role("button", name="Juggling").first.click()
    lead.ready()
    lead.page.get_by_role("button", name="Tasks").first.click()
    panel = tasks_of(lead)
    panel.get_by_text("Make tasks").first.click()
    panel.get_by_label("Annotators per task").fill("2")
    panel.get_by_role("button", name="Make tasks").click()
    eventually(lambda: len(states(server)) == 2)
    body = {"recordings": ["hall", "yard"]}
    server.request("POST", "projects/night/tasks", json=body)


def apart(ada: Desk, bob: Client) -> None:
    """Two people label the same, and see nothing of each other."""
    theirs = bob.projects["night"]
    ada.until("window.__pointbrush && pb.state.sequences.value?.length === 3")
    ada.page.get_by_role("region", name="Night").get_by_role("button", name="Next task").click()
    ada.ready()
    task = theirs.next_task()
    assert task is not None
    assert task.sequence != ada.ask("pb.state.sequence.value.id")
    paint(bob, task.sequence, half=True)
    theirs.put_task(task.number, state="done")
    panel = tasks_of(ada)
    panel.get_by_role("region", name="My task").get_by_text("Juggling").wait_for()
    assert panel.get_by_text("bob").count() == 0
    assert panel.get_by_role("button", name="Agreement").count() == 0
    ada.press("Shift+N")
    ada.until("pb.state.sequence.value?.id === 'hall'")
    ada.ready()


def paint(client: Client, sequence: str, *, half: bool = False) -> None:
    """Label the person in frame 0, or what of them comes first."""
    with np.load(DATA / "0000.npz") as arrays:
        mine = np.flatnonzero(arrays["truth"] == PERSON)
        values = np.zeros(len(arrays["truth"]), np.uint16)
    values[mine[: len(mine) // 2] if half else mine] = 1
    client[sequence].frames[0].annotate(values)


def returned(server: LiveServer, lead: Desk, ada: Desk, place: list[float]) -> None:
    """Send a task back with a note and a place; its person is led there, and hands it in again."""
    own = tasks_of(ada).get_by_role("region", name="My task")
    own.get_by_text("Hall").first.wait_for()
    ada.press("Shift+N")
    eventually(lambda: states(server)["hall"] == "done")
    panel = tasks_of(lead)
    eventually(lambda: again(panel, "Hall, frames 0–5"))
    panel.get_by_role("button", name="Hall, frames 0–5").click()
    lead.until("pb.state.sequence.value?.id === 'hall'")
    lead.ready()
    verdict = panel.get_by_role("form", name="Verdict")
    verdict.get_by_label("Note").fill("the hand is missing")
    verdict.get_by_role("button", name="Pin to a place").click()
    lead.page.mouse.click(*lead.place(place))
    verdict.get_by_role("button", name="Pinned").wait_for()
    lead.screenshot("team-lead")
    assert faults(lead.page, "tasks", "#team") == []
    verdict.get_by_role("button", name="Send back").click()
    eventually(lambda: states(server)["hall"] == "returned")
    ada.press("Shift+N")
    eventually(lambda: states(server)["yard"] == "done")
    own.get_by_text("the hand is missing").wait_for()
    own.get_by_role("button", name="Go to the place in frame 0").wait_for()
    ada.until("pb.state.sequence.value?.id === 'hall'")
    ada.page.locator(".review-mark").wait_for()
    ada.until(f"{FLOWN}(pb.project({place}), document.querySelector('#view'))")
    ada.screenshot("team-returned")
    ada.press("Shift+N")
    eventually(lambda: states(server)["hall"] == "done")
    panel.get_by_role("button", name="Next to review").click()
    verdict.get_by_role("button", name="Accept").click()
    eventually(lambda: "accepted" in states(server).values())


def agreed(server: LiveServer, lead: Desk) -> None:
    """Look at a place where two people differ, see both versions, and take one's."""
    panel = tasks_of(lead)
    server.request("POST", "projects/night/snapshots", json={"name": "Before"})
    panel.get_by_role("button", name="Juggling, frames 0–5").first.click()
    lead.until("pb.state.sequence.value?.id.startsWith('juggling-')")
    panel.get_by_role("button", name="Agreement").click()
    panel.get_by_text("person: only bob has it").click()
    lead.until(f"pb.state.sequence.value?.id === '{SEQUENCE}'")
    lead.ready()
    lead.page.locator(".review-mark").wait_for()
    looks = panel.get_by_role("radiogroup", name="Show the labels of")
    looks.get_by_role("radio", name="bob").click()
    lead.until("pb.labels()[1] > 0")
    lead.screenshot("team-agreement")
    assert faults(lead.page, "agreement", "#team") == []
    looks.get_by_role("radio", name="Recording").click()
    lead.until("!(pb.labels()[1] > 0)")
    panel.get_by_role("button", name="Use bob’s").click()
    panel.get_by_role("button", name="Use bob’s", pressed=True).wait_for()
    assert (server.annotation(SEQUENCE, 0) == 1).any()


def versions(lead: Desk, server: LiveServer) -> None:
    """Name the labels, see how they differ from those before, and export them."""
    panel = tasks_of(lead)
    panel.get_by_role("button", name="Versions").click()
    panel.get_by_label("Name of the snapshot").fill("After")
    panel.get_by_role("button", name="Make a snapshot").click()
    panel.get_by_role("button", name="After").wait_for()
    panel.get_by_role("button", name="Before").click()
    difference = panel.get_by_role("region", name="Difference")
    difference.get_by_role("button", name="Go to frame 0").wait_for()
    lead.screenshot("team-versions")
    assert faults(lead.page, "versions", "#team") == []
    with lead.page.expect_download() as saved:
        panel.get_by_label("Export this recording from the snapshot").select_option("npz")
    archive = ZipFile(BytesIO(saved.value.path().read_bytes()))
    assert any(name.endswith(".npz") for name in archive.namelist())


def tasks_of(desk: Desk) -> Locator:
    return desk.page.get_by_role("complementary", name="Tasks")


def again(panel: Locator, entry: str) -> bool:
    """Whether an entry is there; what others do is fetched when the tab is opened."""
    panel.get_by_role("button", name="Versions").click()
    panel.get_by_role("button", name="Tasks", exact=True).click()
    return panel.get_by_role("button", name=entry).count() > 0


def states(server: LiveServer) -> dict[str, Any]:
    found = server.request("GET", "projects/night/tasks").json()
    return {each["sequence"]: each["state"] for each in found}
