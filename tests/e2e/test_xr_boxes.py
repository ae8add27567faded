"""Boxes in the headset: taken hold of by controllers and by hands."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser

from tests.e2e.headset import Headset, wear
from tests.e2e.server import LiveServer
from tests.e2e.street import FRAMES, make_workspace
from tests.e2e.test_boxes import SIZE, add_box, box_of, centre, paint_car
from tests.waiting import eventually


@pytest.fixture(scope="session")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_workspace(tmp_path_factory)


@pytest.fixture
def headset(browser: Browser, server: LiveServer) -> Iterator[Headset]:
    """Inside the street, whose first car has a box."""
    paint_car(server)
    add_box(server, range(FRAMES))
    worn = wear(browser, server.page_url)
    worn.ready()
    worn.enter()
    yield worn
    worn.close()
    assert worn.complaints == []


@pytest.mark.parametrize("bare", [False, True], ids=["controllers", "hands"])
def test_a_face_and_the_whole_box_follow_the_hand(
    headset: Headset, server: LiveServer, bare: bool
) -> None:
    headset.until("pb.state.activeLabel.value === 1")
    headset.click("palette", "Fit boxes")
    headset.click("palette", "Grab boxes")
    if bare:
        headset.lay_down_controllers()

    def bring(point: list[float]) -> None:
        if bare:
            headset.hand_to("right", headset.ask(f"hs.place({point})"))
        else:
            headset.reach(point)

    x, y, z = centre(0)
    bring([x - SIZE[0] / 2, y, z])
    headset.trigger(1)
    bring([x - SIZE[0] / 2 - 0.3, y, z])
    headset.trigger(0)
    eventually(lambda: box_of(server)["size"][0] > SIZE[0] + 0.2)
    box = box_of(server)
    assert box["size"] == pytest.approx([SIZE[0] + 0.3, *SIZE[1:]], abs=0.05)
    middle = [x + 0.5, y + 0.2, z]
    bring(middle)
    headset.trigger(1)
    bring([middle[0], middle[1] + 0.4, middle[2]])
    headset.trigger(0)
    eventually(lambda: box_of(server)["poses"]["0"]["centre"][1] > y + 0.2)
    moved = np.subtract(box_of(server)["poses"]["0"]["centre"], box["poses"]["0"]["centre"])
    assert moved == pytest.approx([0, 0.4, 0], abs=0.06)
    assert len(box_of(server)["poses"]) == FRAMES
    server.request("PATCH", f"sequences/street/boxes/{box['id']}", json={"heading_known": False})
    headset.click("palette", "Turn round")
    eventually(lambda: box_of(server)["heading_known"])
    turned = box_of(server)["poses"]
    assert all(abs(pose["quaternion"][2]) == pytest.approx(1, abs=1e-3) for pose in turned.values())
