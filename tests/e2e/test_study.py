"""Two participants of the ready study: one at the desk, one in an emulated headset."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
import pytest
from playwright.sync_api import Browser, expect

from tests.e2e.chromium import TOUR_LEFT, UNDRAWN
from tests.e2e.desk import Desk, blank_page, launch
from tests.e2e.headset import QUEST, Headset, runtime
from tests.e2e.server import LiveServer

TEMPLATES = Path(__file__).parents[2] / "server" / "pointbrush" / "work" / "studies" / "templates"
STUDY, RECORDING = "short", "study-table-top"
LABEL = "carton"


@pytest.fixture(scope="module")
def server(template: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveServer]:
    """One for both: the study is *Desk or headset* with one condition and two tasks for each."""
    workspace = tmp_path_factory.mktemp("study") / "workspace"
    shutil.copytree(template, workspace)
    live = LiveServer(workspace)
    live.start()
    text = (TEMPLATES / "desk-or-headset.yaml").read_text()
    text = text.replace("design: within", "design: between")
    begin, end = text.index("- name: jugglers"), text.index("questionnaires:")
    live.request("POST", "studies", json={"id": STUDY, "text": text[:begin] + text[end:]})
    yield live
    live.stop()


@pytest.fixture(scope="module")
def links(server: LiveServer) -> dict[str, str]:
    """The addresses of two participants, by the condition of each."""
    added = server.request("POST", f"studies/{STUDY}/participants", json={"count": 2}).json()
    return {each["conditions"][0]: each["link"] for each in added}


def target(server: LiveServer) -> list[float]:
    """A point of the first object to label, source coordinates."""
    palette = server.request("GET", f"sequences/{RECORDING}/labels").json()
    number = next(each["id"] for each in palette if each["name"] == LABEL)
    points = server.points(RECORDING, 0)[server.annotation(RECORDING, 0) == number]
    nearest = np.linalg.norm(points - points.mean(axis=0), axis=1).argmin()
    return [float(value) for value in points[nearest]]


def press(desk: Desk, name: str) -> None:
    desk.page.get_by_role("button", name=name, exact=True).click()


def read(desk: Desk, heading: str, button: str) -> None:
    """Read a card, and go on."""
    expect(desk.page.get_by_role("heading", name=heading, exact=True)).to_be_visible()
    press(desk, button)


def answer(desk: Desk, heading: str) -> None:
    """Answer all items of a questionnaire."""
    dialog = desk.page.get_by_role("dialog")
    expect(dialog.get_by_role("heading", name=heading, exact=True)).to_be_visible()
    for group in dialog.get_by_role("radiogroup").all():
        group.get_by_role("radio").last.click()
    press(desk, "Continue")


def answer_all(desk: Desk) -> None:
    answer(desk, "Workload of this way of working")
    answer(desk, "This way of working")
    answer(desk, "Both ways of working")
    expect(desk.page.get_by_role("heading", name="Thank you")).to_be_visible()


def shown(desk: Desk) -> None:
    """The recording of a task is on screen, and the page records."""
    desk.until("window.__pointbrush?.engine.link.observer && pb.state.tool.value === 'paint'")
    desk.pictures()


def replays(server: LiveServer, number: int) -> list[dict[str, Any]]:
    """Check that the log leads to the labels of the participant, bit for bit; return the log."""
    path = f"studies/{STUDY}/participants/{number}"
    answer = server.request("POST", f"{path}/replay").json()
    assert answer["equal"], answer["difference"]
    assert answer["edits"] >= 1
    log: list[dict[str, Any]] = server.request("GET", f"{path}/log?format=json").json()
    return log


def test_a_participant_at_the_desk(
    browser: Browser, server: LiveServer, links: dict[str, str]
) -> None:
    desk = Desk(blank_page(browser, server.url), links["desk"], (UNDRAWN, TOUR_LEFT))
    read(desk, "Before you begin", "I agree")
    read(desk, "Instructions", "Begin")
    read(desk, "practice", "Begin")
    shown(desk)
    expect(desk.page.get_by_role("button", name="Export")).to_have_count(0)
    press(desk, "Done")
    read(desk, "table-top", "Begin")
    shown(desk)
    desk.press("2")
    desk.press("1")
    x, y, z = target(server)
    desk.paint([[x, y, z], [x + 0.01, y, z]])
    desk.settled()
    painted = desk.labels()

    manager = launch(browser, server.page_url)
    press(manager, "Studies")
    press(manager, "Open")
    press(manager, "Pause the session of participant 1")
    expect(desk.page.get_by_role("heading", name="Paused")).to_be_visible()
    press(manager, "Continue the session of participant 1")
    expect(desk.page.get_by_role("heading", name="Paused")).to_have_count(0)
    row = manager.page.get_by_role("row").nth(1)
    expect(row).to_contain_text(re.compile(r"task table-top\D*[1-9]"))

    desk.page.reload()
    shown(desk)
    assert desk.labels() == painted
    press(desk, "Done")
    answer_all(desk)
    log = replays(server, 1)
    assert {"stroke", "label", "pose", "frame_time", "device", "phase"} <= {
        each["kind"] for each in log
    }
    expect(row).to_contain_text("done")
    watch(manager, painted)
    desk.close()
    assert desk.complaints == []
    assert manager.complaints == []


def watch(manager: Desk, painted: dict[int, int]) -> None:
    """Replay participant 1, and save pictures of it."""
    press(manager, "Replay participant 1")
    step = manager.page.get_by_role("combobox", name="Step")
    step.select_option(label="desk: table-top")
    time = manager.page.get_by_role("slider", name="Time")
    manager.until("pb.shown().total > 0")
    time.press("Home")
    manager.until("Object.keys(pb.labels()).length === 1")
    time.press("End")
    manager.until("pb.state.people.value[0]?.head")
    counts = ",".join(f"{label}:{count}" for label, count in sorted(painted.items()))
    manager.until(
        f"Object.entries(pb.labels()).map((each) => each.join(':')).join() === '{counts}'"
    )
    manager.page.get_by_role("group", name="Replay").get_by_label("Speed").select_option("16")
    with manager.page.expect_download() as download:
        press(manager, "Save the replay as pictures")
    with ZipFile(download.value.path()) as pictures:
        assert pictures.namelist()[0] == "00000.png"
        assert pictures.read("00000.png").startswith(b"\x89PNG")


def test_a_participant_in_a_headset(
    browser: Browser, server: LiveServer, links: dict[str, str]
) -> None:
    scripts = (runtime(QUEST), TOUR_LEFT, UNDRAWN)
    worn = Headset(blank_page(browser, server.url), links["headset"], scripts)
    read(worn, "Before you begin", "I agree")
    read(worn, "Instructions", "Begin")
    read(worn, "practice: put on the headset", "Enter VR")
    worn.click("added", "Begin")
    shown(worn)
    worn.click("added", "Done")
    worn.click("added", "Begin")
    shown(worn)
    worn.paint([target(server)])
    worn.until("pb.state.undo.value !== null")
    worn.settled()
    # Taken off and put on again, the task goes on.
    worn.ask("(void pb.engine.viewer.renderer.xr.getSession().end())")
    read(worn, "table-top: put on the headset", "Enter VR")
    worn.click("added", "Done")
    worn.until("hs.areas('added').some(({ name }) => name === 'Leave VR')")
    worn.point_at("added", "Leave VR", 0.5)
    # No picture follows the press that could be waited for.
    worn.ask(worn.pressing(1))
    worn.until("pb.state.xr.value.session === 'none'")
    answer_all(worn)
    poses = [each for each in replays(server, 2) if each["kind"] == "pose"]
    assert any(each["right"] for each in poses if "right" in each)
    worn.close()
    assert worn.complaints == []
