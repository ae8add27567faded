"""Take the pictures of a study anew, on the ready study; ``docs/pictures.py`` runs it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Browser

from docs import headset_pictures
from pointbrush.client import Client
from tests.e2e.chromium import TOUR_LEFT
from tests.e2e.desk import Desk, blank_page, launch
from tests.e2e.headset import QUEST, Headset, runtime
from tests.e2e.server import TOKEN, LiveServer
from tests.waiting import PATIENCE

SIZE = (1440, 810)
LABELS = ("carton", "bottle")
"""Objects that participant 1 paints."""
RECORDS = "window.__pointbrush?.engine.link.observer && pb.state.tool.value === 'paint'"
"""The page shows a task and records."""
BESIDE = """(([x, y, z]) => pb.look([x + 1.1, y + 0.6, z + 0.8], [x - 0.1, y - 0.4, z - 1.2]) ?? 1)(
  pb.state.people.value[0].head)"""
"""The view is beside the participant's."""
SHOWN = 1500
"""Milliseconds until a flight has ended."""


def press(desk: Desk, *names: str) -> None:
    for name in names:
        desk.page.get_by_role("button", name=name, exact=True).click(timeout=1e3 * PATIENCE)


def middles(server: LiveServer) -> list[list[float]]:
    """A point of each object to paint, source coordinates."""
    with Client(server.url, TOKEN) as client:
        recording = client["study-table-top"]
        xyz, truth = recording.frames[0].points()["xyz"], recording.frames[0].annotation()
        numbers = [next(e.id for e in recording.labels() if e.name == name) for name in LABELS]
    found = []
    for number in numbers:
        mine = xyz[truth == number]
        found.append(mine[np.linalg.norm(mine - mine.mean(axis=0), axis=1).argmin()].tolist())
    return found


def take(
    browser: Browser,
    folder: Path,
    save: Callable[[Desk, str], None],
    save_eyes: Callable[[Image.Image, str], None],
) -> None:
    """Lead a participant to the desk and one into a headset, watch both, and replay the first."""
    workspace = folder / "study"
    workspace.mkdir()
    server = LiveServer(workspace)
    server.start()
    try:
        with Client(server.url, TOKEN) as client:
            client.call("POST", "/studies", json={"template": "desk-or-headset"})
            people = "/studies/desk-or-headset/participants"
            desk_first, headset_first = client.call("POST", people, json={"count": 2}).json()
        desk = at_desk(browser, server, desk_first["link"], save)
        worn = in_headset(browser, server, headset_first["link"], save_eyes)
        watch(browser, server, save)
        desk.close()
        worn.close()
    finally:
        server.stop()


def at_desk(
    browser: Browser, server: LiveServer, link: str, save: Callable[[Desk, str], None]
) -> Desk:
    """Paint two objects in the first task."""
    desk = Desk(blank_page(browser, server.url), link, (TOUR_LEFT,), SIZE)
    press(desk, "I agree", "Begin", "Begin")
    desk.until(RECORDS)
    press(desk, "Done", "Begin")
    desk.until(f"{RECORDS} && pb.shown().drawn === pb.shown().total")
    desk.page.wait_for_timeout(SHOWN)
    for key, (x, y, z) in enumerate(middles(server), start=1):
        desk.press(str(key))
        desk.paint([[x, y, z - 0.04], [x, y, z], [x, y, z + 0.04], [x, y, z + 0.08]])
        desk.settled()
    save(desk, "study-task")
    return desk


def in_headset(
    browser: Browser,
    server: LiveServer,
    link: str,
    save_eyes: Callable[[Image.Image, str], None],
) -> Headset:
    """Stand before the first task with both hands in sight."""
    worn = Headset(
        blank_page(browser, server.url), link, (runtime(QUEST), TOUR_LEFT), headset_pictures.SIZE
    )
    press(worn, "I agree", "Begin", "Enter VR")
    worn.ask("pb.setDrawing(false)")
    worn.click("added", "Begin")
    worn.until(RECORDS)
    worn.click("added", "Done")
    worn.click("added", "Begin")
    worn.until(RECORDS)
    headset_pictures.hold(worn)
    save_eyes(headset_pictures.look(worn), "study-headset")
    return worn


def watch(browser: Browser, server: LiveServer, save: Callable[[Desk, str], None]) -> None:
    """Look at the participants, and replay the first one."""
    manager = launch(browser, server.page_url, *SIZE, drawn=True)
    press(manager, "Studies", "Open")
    manager.page.get_by_role("row").nth(2).wait_for()
    manager.page.mouse.move(0, 0)
    save(manager, "study-live")
    press(manager, "Replay participant 1")
    manager.page.get_by_role("combobox", name="Step").select_option(label="desk: table-top")
    manager.until("pb.shown().total > 0 && pb.state.people.value[0]?.head")
    manager.page.get_by_role("slider", name="Time").press("End")
    manager.until("Object.keys(pb.labels()).length > 2")
    manager.ask(BESIDE)
    manager.page.wait_for_timeout(SHOWN)
    save(manager, "study-replay")
    manager.close()
