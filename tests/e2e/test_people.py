"""People without a click, and masks of pictures: at the desk and in the headset."""

from __future__ import annotations

import numpy as np
from playwright.sync_api import expect

from tests.e2e.desk import Desk
from tests.e2e.headset import Headset
from tests.e2e.recording import SEQUENCE
from tests.e2e.server import LiveServer

PREDICTED, PAINTED = 4, 1
"""Provenance of points."""
FOUND = 65473
"""Id of the first person's points in the preview."""


def labelled(server: LiveServer, frame: int) -> int:
    return int((server.annotation(SEQUENCE, frame) > 0).sum())


def test_people_are_found_tracked_and_exported_and_corrected_in_the_picture(
    desk: Desk, server: LiveServer
) -> None:
    page = desk.page
    desk.press("j")
    page.get_by_role("button", name="Find people").click()
    bar = page.get_by_role("status", name="Find people")
    bar.get_by_role("button", name="Accept").wait_for()
    previewed = desk.labels()
    assert previewed[FOUND] > 1000
    assert labelled(server, 0) == 0
    desk.screenshot("people-found")
    desk.press("Escape")
    desk.until(f"!({FOUND} in pb.labels())")
    expect(bar).to_have_count(0)
    # Four actions: find, accept, track, export.
    page.get_by_role("button", name="Find people").click()
    bar.get_by_role("button", name="Accept").wait_for()
    desk.press("Enter")
    bar.get_by_role("button", name="Track").click()
    export = bar.get_by_role("button", name="Export")
    desk.until("document.querySelector('[aria-label=\"Find people\"] [data-icon=export]') !== null")
    assert labelled(server, 0) == sum(previewed.values()) - previewed[0]
    assert set(server.annotation(SEQUENCE, 0, "provenance")) == {0, PREDICTED}
    last = desk.ask("pb.state.sequence.value.frames") - 1
    assert labelled(server, last) > 1000
    desk.screenshot("people-tracked")
    with page.expect_download() as download:
        export.click()
    assert download.value.suggested_filename.startswith(SEQUENCE)
    # The depth camera has no other picture: its own colours stand in.
    paint_in_picture(desk, server)


def paint_in_picture(desk: Desk, server: LiveServer) -> None:
    """Paint the first person's label into the picture, take it back, and choose another label."""
    page = desk.page
    desk.press("b")
    desk.until("pb.state.notices.value.length === 0")
    page.get_by_role("button", name="Pictures").click()
    page.get_by_role("button", name="Show the picture of depth large, over the cloud").click()
    large = page.get_by_role("region", name="Camera depth, large")
    large.get_by_role("button", name="Mask").click()
    large.locator("img.camera-mask").wait_for()
    large.get_by_role("radio", name="Box").click()
    before = server.annotation(SEQUENCE, 0)
    box = large.locator("canvas").first.bounding_box()
    assert box is not None
    corners = [(box["x"] + u * box["width"], box["y"] + v * box["height"]) for u, v in ((0.5, 0.32), (0.58, 0.48))]  # fmt: skip  # noqa: E501
    page.mouse.move(*corners[0])
    page.mouse.down()
    page.mouse.move(*corners[1], steps=3)
    desk.screenshot("picture-painting")
    page.mouse.up()
    label = desk.ask("pb.state.activeLabel.value")
    desk.until(f"(pb.labels()[{label}] ?? 0) > {int((before == label).sum())}")
    after = server.annotation(SEQUENCE, 0)
    assert (after[after != before] == label).all()
    assert (server.annotation(SEQUENCE, 0, "provenance")[after != before] == PAINTED).all()
    desk.screenshot("picture-painted")
    desk.press("Control+z")
    desk.until(f"(pb.labels()[{label}] ?? 0) === {int((before == label).sum())}")
    assert np.array_equal(server.annotation(SEQUENCE, 0), before)
    # A click on another person's mask chooses the label, and lights up the points.
    large.get_by_role("radio", name="Look").click()
    other = next(each for each in np.unique(before) if each not in (0, label))
    points = server.points(SEQUENCE, 0)[before == other]
    x, y, z = points[np.linalg.norm(points - np.median(points, axis=0), axis=1).argmin()].tolist()
    image = "pb.engine.playback.frame.images[0].lattice"
    (t, u), (p, q) = desk.ask(f"{image}.tangent"), desk.ask(f"{image}.pitch")
    size = desk.ask(f"[{image}.width, {image}.height]")
    across, down = (x / z - t) / p / size[0], (y / z - u) / q / size[1]
    page.mouse.click(box["x"] + across * box["width"], box["y"] + down * box["height"])
    desk.until(f"pb.state.activeLabel.value === {other} && pb.labels()[65534] > 0")
    desk.screenshot("picture-chosen")
    desk.until("!(65534 in pb.labels())")


def test_people_in_the_headset_take_four_actions(headset: Headset, server: LiveServer) -> None:
    headset.click("palette", "People")
    headset.until("hs.headset.cockpit.panels.question.mesh.visible")
    assert headset.labels()[FOUND] > 1000
    headset.move("right", [0.5, 1.2, -0.3], [3.0, 1.2, -3.0])
    headset.trigger(1)
    headset.trigger(0)
    headset.until("(pb.labels()[2] ?? 0) > 1000")
    assert set(server.annotation(SEQUENCE, 0, "provenance")) == {0, PREDICTED}
    headset.until("hs.areas('question').some(({ name }) => name === 'Track')")
    headset.click("question", "Track")
    headset.until("hs.areas('question').some(({ name }) => name === 'Export')")
    last = headset.ask("pb.state.sequence.value.frames") - 1
    assert labelled(server, last) > 1000
    with headset.page.expect_download() as download:
        headset.click("question", "Export")
    assert download.value.suggested_filename.startswith(SEQUENCE)
    headset.until("!hs.headset.cockpit.panels.question.mesh.visible")
