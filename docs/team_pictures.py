"""Take the pictures of a team's work anew, on generated traffic; ``docs/pictures.py`` runs it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import httpx
import numpy as np
from numpy.typing import NDArray
from playwright.sync_api import Browser

from docs.box_pictures import FRAMES, SEED, SIZE, TOKEN, serving
from pointbrush.client import Client
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from pointbrush_samples.traffic import TrueTraffic, traffic
from tests.e2e.desk import Desk, launch

NOTE = "the mirror of this car is missing"
SHOWN = 1500
"""Milliseconds until a flight has ended."""


def take(browser: Browser, folder: Path, save: Callable[[Desk, str], None]) -> None:
    """Look at a task that is reviewed, and at the places where two people differ."""
    made = traffic(SEED, FRAMES)
    workspace = folder / "team"
    with serving(workspace, made) as (api, page):
        address = page.partition("/?")[0]
        _work(api, address, workspace, made)
        desk = launch(browser, page, *SIZE, drawn=True)
        desk.ready()
        tasks(desk, save)
        agreement(desk, save)
        home(desk, save)
        desk.close()


def _work(api: httpx.Client, address: str, workspace: Path, made: TrueTraffic) -> None:
    """Have two people label the same: one misses a car, calls another otherwise, takes less."""
    ids = {}
    for number, truth in enumerate(sorted(made.boxes), start=1):
        kind = made.kinds[truth]
        body = {"name": f"{kind} {number}", "category": kind}
        ids[truth] = api.post("/labels", json=body).raise_for_status().json()["id"]
    lookup = np.zeros(max(ids) + 1, np.uint16)
    lookup[list(ids)] = list(ids.values())
    with closing(Workspace(Settings(workspace=workspace))) as opened:
        tokens = {name: opened.labels.tokens.add("annotator", name) for name in ("ada", "bob")}
    with Client(address, TOKEN) as lead:
        project = lead.projects["default"]
        project.add_tasks(["drive"], people=2)
        for name, token in tokens.items():
            with Client(address, token) as client:
                mine = client.projects["default"]
                task = mine.next_task()
                assert task is not None
                for frame, one in enumerate(made.frames):
                    right = lookup[one.instance]
                    values = right if name == "ada" else _otherwise(right, one.frame.xyz)
                    client[task.sequence].frames[frame].annotate(values)
                mine.put_task(task.number, state="done")
        project.add_tasks(["drive"], every=1)
        lead.projects.create("Car park")


def _otherwise(right: NDArray[np.uint16], xyz: NDArray[np.floating]) -> NDArray[np.uint16]:
    """Miss the second largest object, call the third by its name, take half of the fourth."""
    values = right.copy()
    numbers, counts = np.unique(right[right > 0], return_counts=True)
    by_size = numbers[counts.argsort()[::-1]].tolist()
    _, missed, renamed, half = by_size[:4]
    values[right == missed] = 0
    values[right == renamed] = missed
    mine = right == half
    values[mine & (xyz[:, 0] > np.median(xyz[mine, 0]))] = 0
    return values


def tasks(desk: Desk, save: Callable[[Desk, str], None]) -> None:
    """Write a note for one that is handed in."""
    desk.page.get_by_role("button", name="Work").click()
    panel = desk.page.get_by_role("complementary", name="Work")
    panel.get_by_role("button", name="Next to review").click()
    verdict = panel.get_by_role("form", name="Verdict")
    verdict.get_by_label("Note").fill(NOTE)
    desk.ready()
    desk.page.wait_for_timeout(SHOWN)
    save(desk, "desk-tasks")


def agreement(desk: Desk, save: Callable[[Desk, str], None]) -> None:
    """Look at the largest difference, with both versions in the cloud."""
    panel = desk.page.get_by_role("complementary", name="Work")
    panel.get_by_role("tab", name="Agreement").click()
    panel.locator(".entries .menu-item").first.click()
    desk.until("pb.state.sequence.value?.id === 'drive'")
    desk.ready()
    panel.get_by_role("radio", name="Both").click()
    desk.page.wait_for_timeout(SHOWN)
    save(desk, "desk-agreement")


def home(desk: Desk, save: Callable[[Desk, str], None]) -> None:
    """Look at all recordings, by project."""
    desk.ask("pb.engine.closeSequence()")
    desk.page.locator(".recording img").first.wait_for()
    desk.until("document.querySelector('.recording img').complete")
    save(desk, "desk-home")
