"""A parked street at the desk: frames over one another, painted in one pass."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import expect

from tests.e2e.desk import Desk
from tests.e2e.server import LiveServer
from tests.e2e.street import FIRST_CAR, FRAMES, SHOWN, make_workspace, seen
from tests.waiting import eventually


@pytest.fixture(scope="session")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_workspace(tmp_path_factory)


def settle(desk: Desk) -> None:
    """Wait until the camera has come to rest."""
    place = "pb.engine.camera.flying"
    desk.until(f"!{place}")


def test_a_lasso_round_a_parked_car_paints_it_in_every_frame(
    open_desk: Callable[..., Desk], server: LiveServer
) -> None:
    server.create_label("street", "car", "#ff5d5d")
    desk = open_desk()
    page = desk.page
    for _ in range(SHOWN):
        desk.press("ArrowRight")
    desk.until(f"pb.shown().frame === {SHOWN} && pb.shown().drawn === pb.shown().total")
    page.get_by_role("button", name="Frames", exact=True).click()
    page.get_by_role("button", name="All frames").click()
    desk.press("Escape")
    total = desk.ask("pb.shown().total")
    # A lidar has no depth images: there is no surface to choose, nor to draw.
    page.get_by_role("button", name="Overlays").click()
    page.get_by_text("Trails").wait_for()
    assert page.get_by_role("radiogroup", name="Depth images").count() == 0
    desk.press("Escape")
    assert desk.ask("pb.engine.playback.frame.images") == []
    assert desk.ask("pb.state.view.value.surface") == "auto"
    assert not desk.ask("pb.engine.viewer.hasSurface")
    desk.until(f"pb.engine.viewer.laid === {(FRAMES - 1) * total}")
    page.get_by_text("strokes paint all of them").wait_for()
    # From above the cars stand apart, and lie over one another: not smeared along the street.
    page.get_by_role("button", name="Top", exact=True).click()
    car = seen(SHOWN)[FIRST_CAR]
    settle(desk)
    desk.press("b")
    page.get_by_role("radio", name="Lasso").click()
    low, high = car.min(axis=0) - 0.15, car.max(axis=0) + 0.15
    corners = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]
    desk.paint([[*corner, float(high[2])] for corner in [*corners, corners[0]]])
    desk.settled()
    for frame in range(FRAMES):

        def painted(frame: int = frame) -> bool:
            labels = server.annotation("street", frame)
            return bool((labels[FIRST_CAR] == 1).mean() > 0.95)

        eventually(painted)
        assert (server.annotation("street", frame)[~FIRST_CAR] == 1).mean() < 0.05
    desk.screenshot("street-painted")
    edits = server.request("GET", "sequences/street/edits").json()
    assert [edit["kind"] for edit in edits].count("paint") == 1
    desk.press("Control+z")
    eventually(lambda: not any(server.annotation("street", i).any() for i in range(FRAMES)))
    eventually(lambda: not np.any([desk.labels(i).get(1, 0) for i in range(FRAMES)]))
    # The camera's picture over the cloud, which stays where it is.
    before = page.locator("#view").bounding_box()
    page.get_by_role("button", name="Show the picture of front large, over the cloud").click()
    large = page.get_by_role("region", name="Camera front, large")
    large.get_by_role("slider", name="Opacity").fill("0.5")
    opacity = large.locator("figure").evaluate("(e) => getComputedStyle(e).opacity")
    assert float(opacity) < 0.6
    wide = large.locator("img").bounding_box()
    assert wide is not None
    assert before is not None
    assert wide["width"] > 0.5 * before["width"]
    assert page.locator("#view").bounding_box() == before
    assert before["x"] == page.locator("#stage").bounding_box()["x"]  # type: ignore[index]
    large.get_by_role("button", name="Close the large picture").click()
    expect(large).to_have_count(0)


SHIFTED = """
  window.shifted = 0;
  // Panels take their places in the picture after the recording is known.
  let known = Infinity;
  const look = () => {
    if (window.__pointbrush?.state.sequence.value)
      requestAnimationFrame(() => (known = performance.now()));
    else requestAnimationFrame(look);
  };
  look();
  new PerformanceObserver((list) => {
    for (const { startTime, value } of list.getEntries()) if (startTime > known) shifted += value;
  }).observe({ type: 'layout-shift', buffered: true });
"""
"""Adds up what moves without anybody's doing once a recording is open, as browsers count it."""


def test_nothing_moves_when_pictures_of_cameras_come(open_desk: Callable[..., Desk]) -> None:
    desk = open_desk()
    desk.page.add_init_script(SHIFTED)
    desk.page.reload()
    desk.until("pb && document.querySelector('.cameras img')?.complete && pb.shown().frame === 0")
    desk.pictures()
    assert desk.ask("shifted") < 0.002
