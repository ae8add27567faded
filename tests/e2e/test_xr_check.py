"""The page that checks a headset, walked with emulated devices; each report is a golden file.

``WRITE_GOLDEN=1`` in the environment writes the files anew after a deliberate change.
"""

from __future__ import annotations

import json
import math
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser

from pointbrush.names import SCRATCH
from tests.e2e.headset import QUEST, VIVE, Headset, wear
from tests.e2e.recording import PERSON, SEQUENCE, Truth
from tests.e2e.server import LiveServer
from tests.waiting import eventually

GOLDEN = Path(__file__).parents[1] / "golden"
# What differs from one run and machine to the next.
TIMES = ("made", "browser", "pictures")

OTHER = "pb.state.palette.value.find(({ id }) => id !== pb.state.activeLabel.value).name"

# Degrees to the side of straight ahead at which the panel hangs.
ASIDE = """(() => {
  const { panels, rig } = hs.headset.cockpit, { elements } = panels.added.mesh.matrix;
  const x = elements[12] - rig.headInRig.x, z = elements[14] - rig.headInRig.z;
  return (180 / Math.PI) * (Math.atan2(x, -z) - Math.atan2(rig.ahead.x, -rig.ahead.z));
})()"""

Walk = Callable[[Headset, list[float]], None]
Check = Callable[[str], Headset]


@pytest.fixture(scope="module")
def server(template: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveServer]:
    """One for all checks: the first makes the recording, the others find it."""
    workspace = tmp_path_factory.mktemp("checks") / "workspace"
    shutil.copytree(template, workspace)
    live = LiveServer(workspace)
    live.start()
    yield live
    live.stop()


@pytest.fixture
def check(browser: Browser, server: LiveServer) -> Iterator[Check]:
    """Opens the page that checks, and enters with a device."""
    worn: list[Headset] = []

    def enter(device: str) -> Headset:
        url = server.page_url.replace("/?", "/check-headset?")
        headset = wear(browser, url, device)
        worn.append(headset)
        headset.ready()
        # Drawing sets the depth range, among what is reported.
        headset.ask("pb.setDrawing(true)")
        headset.page.get_by_role("button", name="Enter to check").click()
        headset.until("hs.headset.cockpit && hs.frames() > 12")
        headset.ask("pb.setDrawing(false)")
        return headset

    yield enter
    for headset in worn:
        headset.close()
        assert headset.complaints == []


def stroke(headset: Headset, place: list[float]) -> None:
    """Change labels with one stroke, until the server has answered it."""
    undo = headset.ask("pb.state.undo.value")
    if headset.bare:
        headset.hand_to("right", headset.ask(f"hs.place({place})"))
        headset.trigger(1)
        headset.trigger(0)
    else:
        headset.paint([place])
    headset.until(f"pb.state.undo.value !== {json.dumps(undo)}")
    headset.settled()


def gripped(headset: Headset, x: float, y: float, pad: str, hand: str = "right") -> None:
    """Lean or press the pad with the grip held."""
    grip = f"device.controllers.{hand}.updateButtonValue('squeeze', {{}})"
    headset.ask(grip.format(1))
    headset.frames()
    headset.push(x, y, pad, hand)
    headset.ask(grip.format(0))
    headset.frames()


def quest(headset: Headset, place: list[float]) -> None:
    stroke(headset, place)
    headset.push(0, 1, "thumbstick")
    headset.button("a-button")
    stroke(headset, place)
    headset.button("b-button")
    headset.until("pb.state.redo.value !== null")
    headset.push(1, 0, "thumbstick")
    headset.lean(0, -1, "left")
    headset.lean(0, 0, "left")


def vive(headset: Headset, place: list[float]) -> None:
    stroke(headset, place)
    headset.push(0, 0.9, "touchpad")
    gripped(headset, 0, -0.9, "touchpad")
    stroke(headset, place)
    gripped(headset, -0.9, 0, "touchpad")
    headset.until("pb.state.redo.value !== null")
    headset.push(0.9, 0, "touchpad")
    headset.push(0, -0.9, "touchpad", "left")


def hands(headset: Headset, place: list[float]) -> None:
    stroke(headset, place)
    headset.click("palette", headset.ask(OTHER))
    headset.click("palette", "Tools")
    headset.click("palette", "Erase")
    stroke(headset, place)
    headset.click("palette", headset.ask("pb.state.undo.value"))
    headset.until("pb.state.redo.value !== null")
    headset.click("timeline", "forward")
    headset.click("palette", "View")
    headset.click("palette", "Go there")
    headset.move("right", [0.2, 1.2, -0.2], [0.3, 0.0, -1.0])
    headset.trigger(1)
    headset.trigger(0)


def report_of(headset: Headset) -> dict[str, Any]:
    headset.point_at("added", "Leave VR", 0.5)
    # No picture follows the press that could be waited for.
    headset.ask(headset.pressing(1))
    headset.until("pb.state.xr.value.session === 'none'")
    with headset.page.expect_download() as download:
        headset.page.get_by_role("button", name="Download the report").click()
    report: dict[str, Any] = json.loads(download.value.path().read_text())
    return report


@pytest.mark.parametrize(
    ("name", "device", "walk"),
    [("quest", QUEST, quest), ("vive", VIVE, vive), ("hands", QUEST, hands)],
    ids=["quest", "vive", "hands"],
)
def test_a_walk_ends_in_the_golden_report(
    check: Check, server: LiveServer, truth: Truth, name: str, device: str, walk: Walk
) -> None:
    headset = check(device)
    if name == "hands":
        headset.lay_down_controllers()
    headset.until("hs.areas('added').some(({ name }) => name === 'Pulse')")
    assert headset.ask("pb.state.sequence.value.id") == SCRATCH
    assert math.isclose(headset.ask(ASIDE), 0, abs_tol=2)
    headset.click("added", "Pulse")
    headset.click("added", "Felt it")
    headset.flick_to_frame(0)
    points = server.points(SCRATCH, 0)
    nearest = np.linalg.norm(points - truth(0, PERSON), axis=1).argmin()
    walk(headset, points[nearest].tolist())
    headset.until("hs.areas('added').some(({ name }) => name === 'Leave VR')")
    report = report_of(headset)
    golden = GOLDEN / f"headset-{name}.json"
    if os.environ.get("WRITE_GOLDEN"):
        golden.write_text(json.dumps(report, indent=2) + "\n")
    assert report["pictures"]["count"] == 120
    expected = json.loads(golden.read_text())
    assert {key: report[key] for key in report if key not in TIMES} == {
        key: expected[key] for key in expected if key not in TIMES
    }
    eventually(
        lambda: any(
            kept["report"] | {"made": ""} == report | {"made": ""}
            for kept in server.request("GET", "headset-reports").json()
        )
    )
    assert [each["id"] for each in server.request("GET", "sequences").json()] == [SEQUENCE]
    assert not server.annotation(SEQUENCE, 0).any()
