"""A display that is too slow gets fewer points, and all of them again when it has the time."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import Browser

from tests.e2e.desk import Desk
from tests.e2e.headset import Headset, wear
from tests.e2e.server import LiveServer

FEWER = "pb.shown().drawn < pb.shown().points"
ALL = "pb.shown().drawn === pb.shown().total"


@pytest.fixture
def headset(browser: Browser, server: LiveServer) -> Iterator[Headset]:
    """Inside the recording, drawn by a program that is far too slow for a headset."""
    worn = wear(browser, server.page_url, size=(480, 270), drawn=True)
    worn.ready()
    worn.enter()
    worn.ask("pb.setDrawing(true)")
    yield worn
    worn.close()
    assert worn.complaints == []


def test_a_headset_that_falls_behind_gets_fewer_points_and_recovers(headset: Headset) -> None:
    headset.until(FEWER)
    # What is not drawn is not asked for either, while it plays.
    headset.ask("pb.engine.playback.play()")
    headset.ask("pb.engine.playback.forget([...pb.engine.playback.store.all()])")
    headset.until("pb.shown().points < pb.shown().total")
    # A paused frame comes whole; how much of it is drawn is for the display to say.
    headset.ask("pb.engine.playback.pause()")
    headset.until("pb.shown().points === pb.shown().total")
    assert headset.ask(FEWER)
    # A display that is content with what it gets: everything comes back.
    headset.ask("(pb.engine.pacing.headsetMs[0] = 60000)")
    headset.until(ALL, patience=60)


def test_at_the_desk_a_moving_picture_is_coarser_and_one_at_rest_whole(
    open_desk: Callable[..., Desk],
) -> None:
    desk = open_desk(width=480, height=270, drawn=True)
    desk.ask("(pb.engine.pacing.headsetMs[0] = 1)")
    spin = "pb.engine.camera.turn(3, 0), pb.engine.viewer.invalidate()"
    desk.ask(f"(window.spin = setInterval(() => {{ {spin} }}, 20), 0)")
    desk.until(FEWER)
    desk.ask("(clearInterval(window.spin), 0)")
    desk.until(ALL)
