"""Two participants of the ready study: one at the desk, one in an emulated headset."""

from __future__ import annotations

import re
import shutil
from collections import Counter
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
from tests.e2e.inputs import Input, eyes_alone
from tests.e2e.server import LiveServer
from tests.waiting import eventually

TEMPLATES = Path(__file__).parents[2] / "server" / "pointbrush" / "work" / "studies" / "templates"
STUDY, TOOLS, RECORDING = "short", "tools", "study-table-top"
WORN = """
- {name: hands, device: headset, input: hands}
- {name: look, device: headset, input: look-and-pinch}
"""
LABEL = "carton"


@pytest.fixture(scope="module")
def server(template: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveServer]:
    """One for all: a study of the package with more conditions, one for each participant."""
    workspace = tmp_path_factory.mktemp("study") / "workspace"
    shutil.copytree(template, workspace)
    live = LiveServer(workspace)
    live.start()
    live.request("POST", "studies", json={"id": STUDY, "text": short("desk-or-headset", WORN)})
    # A stroke or a click is enough.
    text = short("brush-or-object-tool").replace("target_iou: 0.9", "target_iou: 0.02")
    live.request("POST", "studies", json={"id": TOOLS, "text": text})
    yield live
    live.stop()


def short(template: str, conditions: str = "") -> str:
    """A study of the package with more conditions, one for each participant, and two tasks."""
    text = (TEMPLATES / f"{template}.yaml").read_text()
    text = text.replace("design: within", "design: between")
    text = text.replace("tasks:\n", f"{conditions}tasks:\n")
    begin, end = text.index("- name: jugglers"), text.index("questionnaires:")
    return text[:begin] + text[end:]


@pytest.fixture(scope="module")
def links(server: LiveServer) -> dict[str, str]:
    """The addresses of participants, by the condition of each."""
    added = [
        each
        for study, count in ((STUDY, 4), (TOOLS, 2))
        for each in server.request(
            "POST", f"studies/{study}/participants", json={"count": count}
        ).json()
    ]
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


def replays(server: LiveServer, number: int, study: str = STUDY) -> list[dict[str, Any]]:
    """Check that the log leads to the labels of the participant, bit for bit; return the log."""
    path = f"studies/{study}/participants/{number}"
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
    read(desk, "Practice", "Begin")
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
    listed = manager.page.get_by_role("listitem").filter(has_text="Desk or headset")
    listed.get_by_role("button", name="Open").click()
    press(manager, "Pause the session of participant 1")
    expect(desk.page.get_by_role("heading", name="Paused")).to_be_visible()
    press(manager, "Continue the session of participant 1")
    expect(desk.page.get_by_role("heading", name="Paused")).to_have_count(0)
    row = manager.page.get_by_role("row").nth(1)
    expect(row).to_contain_text(re.compile(r"task table-top\D*[1-9]"))

    press(manager, "Look at the recording of participant 1")
    manager.until(f"Object.values(pb.labels()).join() === '{','.join(map(str, painted.values()))}'")
    expect(manager.page.get_by_role("button", name="Paint")).to_have_count(0)
    press(manager, "Back to the study")

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
    read(worn, "Practice: put on the headset", "Enter VR")
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


@pytest.mark.parametrize(("number", "condition"), [(3, "hands"), (4, "look")])
def test_a_participant_without_controllers(
    browser: Browser, server: LiveServer, links: dict[str, str], number: int, condition: str
) -> None:
    scripts = (runtime(QUEST), TOUR_LEFT, UNDRAWN)
    worn = Headset(blank_page(browser, server.url), links[condition], scripts)
    read(worn, "Before you begin", "I agree")
    read(worn, "Instructions", "Begin")
    read(worn, "Practice: put on the headset", "Enter VR")
    worn.until("hs.headset.cockpit && hs.frames() > 2")
    if condition == "hands":
        worn.lay_down_controllers()
        worn.click("added", "Begin")
        shown(worn)
        worn.hand_to("right", worn.ask(f"hs.place({target(server)})"))
        worn.trigger(1)
        worn.trigger(0)
    else:
        eyes_alone(worn)
        look = Input(worn, "look", "transient-pointer", "right")
        look.look_at("added", "Begin")
        look.select(True)
        look.select(False)
        shown(worn)
        look.look(target(server))
        look.select(True)
        look.select(False)
    worn.until("pb.state.undo.value !== null")
    worn.settled()
    path = f"studies/{STUDY}/participants/{number}"
    eventually(lambda: server.request("POST", f"{path}/replay").json()["edits"] == 1)
    log = replays(server, number)
    limbs = ("head", "right") if condition == "hands" else ("head",)
    assert all(any(each.get(limb) for each in log) for limb in limbs)
    worn.close()
    assert worn.complaints == []


@pytest.mark.parametrize(("number", "tool"), [(1, "brush"), (2, "object")])
def test_a_participant_with_one_tool(
    browser: Browser, server: LiveServer, links: dict[str, str], number: int, tool: str
) -> None:
    desk = Desk(blank_page(browser, server.url), links[tool], (UNDRAWN, TOUR_LEFT))
    read(desk, "Before you begin", "I agree")
    read(desk, "Instructions", "Begin")
    read(desk, "Practice", "Begin")
    shown(desk)
    press(desk, "Done")
    read(desk, "table-top", "Begin")
    shown(desk)
    offered = {
        name: desk.page.get_by_role("radio", name=name, exact=True).count()
        for name in ("Brush", "Object")
    }
    assert offered == {"Brush": tool == "brush", "Object": tool == "object"}
    desk.press("1")
    x, y, z = target(server)
    desk.paint([[x, y, z]] if tool == "object" else [[x, y, z], [x + 0.02, y, z]])
    # The task ends once enough is labelled.
    dialog = desk.page.get_by_role("dialog")
    expect(dialog.get_by_role("heading", name="Workload of these tools")).to_be_visible()
    kinds = Counter(each["kind"] for each in replays(server, number, TOOLS))
    assert (kinds["stroke"] > 0, kinds["click"] > 0) == (True, tool == "object")
    desk.close()
    assert desk.complaints == []
