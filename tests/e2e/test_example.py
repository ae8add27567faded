"""Label by example at the desk: learn, look, answer a doubt, apply, take back."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from playwright.sync_api import expect

from tests.e2e.conftest import DATA
from tests.e2e.desk import Desk
from tests.e2e.recording import SEQUENCE
from tests.e2e.server import LiveServer

PREDICTED = 65024
"""First of the ids that the page shows predictions by."""


BALLS = 6
"""Strokes of a class."""


def paint_a_little(server: LiveServer, classes: dict[str, NDArray[np.bool_]]) -> None:
    """Paint some balls of frame 0 as each class, round places that are of it."""
    rng = np.random.default_rng(0)
    places = server.points(SEQUENCE, 0)
    for (name, mine), colour in zip(classes.items(), ("#ff5d5d", "#5d9dff"), strict=True):
        brush = {
            "shape": "sphere",
            "radius": 0.06,
            "label": server.create_label(SEQUENCE, name, colour),
            "only_unlabeled": True,
        }
        for at in places[rng.choice(np.flatnonzero(mine), BALLS)].tolist():
            stroke = brush | {"samples": [{"origin": at}]}
            server.request("POST", f"sequences/{SEQUENCE}/frames/0/strokes", json=stroke)


def asked_points(server: LiveServer) -> NDArray[np.int64]:
    """Return the points that are asked about first in frame 0."""
    (classifier,) = server.request("GET", "classifiers").json()
    path = f"sequences/{SEQUENCE}/doubt?classifier={classifier['id']}&frame=0&most=1"
    (place,) = server.request("GET", path).json()
    return np.concatenate([np.arange(first, first + length) for first, length in place["runs"]])


def assert_close_button_in_first_line(desk: Desk) -> None:
    bar, parts, close = desk.page.locator(".example-bar").evaluate(
        """(bar) => [bar, bar.querySelector('.example-row > :nth-child(2)'),
                     bar.querySelector('[aria-label^=Close]')]
          .map((each) => each.getBoundingClientRect().toJSON())"""
    )
    assert parts["right"] <= close["left"]
    assert close["right"] < bar["right"]
    assert close["top"] >= bar["top"]
    assert close["bottom"] < bar["top"] + 40


def test_what_is_painted_teaches_and_the_rest_follows(server: LiveServer, desk: Desk) -> None:
    with np.load(DATA / "0000.npz") as arrays:
        truth = arrays["truth"]
    paint_a_little(server, {"people": truth > 0, "room": truth == 0})
    page = desk.page
    page.get_by_role("button", name="By example").click()
    page.get_by_role("button", name="Learn from painted points").click()
    desk.until(f"Object.keys(pb.drawnLabels()).some((id) => id >= {PREDICTED} && id < 65280)")
    panel = page.get_by_role("complementary", name="By example")
    classes = panel.get_by_role("list", name="Classes").get_by_role("button")
    expect(classes).to_have_count(2)
    expect(classes.first).to_contain_text("people")
    colours = f"""[0, 3].map((step) => 4 * ({PREDICTED} + step))
        .map((at) => [...pb.engine.viewer.palette.data.slice(at, at + 3)])"""
    assert desk.ask(colours)[1] == [0xFF, 0x5D, 0x5D]
    classes.last.click()  # alone: the other class is grey
    desk.until(f"(([a, b]) => String(a) === String(b))({colours})")
    classes.last.click()
    desk.until(f"(([a, b]) => String(a) !== String(b))({colours})")
    panel.get_by_role("radio", name="This frame").click()
    page.get_by_role("button", name="Work", exact=True).click()
    page.get_by_role("complementary", name="Work").wait_for()
    expect(panel).to_be_hidden()
    for width in (1200, 1280):
        page.set_viewport_size({"width": width, "height": 720})
        assert_close_button_in_first_line(desk)
    page.get_by_role("button", name="Work", exact=True).click()
    desk.press(";")
    question = page.get_by_role("group", name="A place in doubt")
    expect(question).to_be_visible()
    asked = "pb.drawnLabels()[65344] ?? 0"
    points = desk.until(asked)
    expect(question).to_contain_text(f"({points} point")
    page.keyboard.down("`")
    desk.until("pb.engine.viewer.uniforms.mapping === 'natural'")
    page.keyboard.up("`")
    desk.until("pb.engine.viewer.uniforms.mapping === 'classes'")
    before = sum(desk.labels().get(label, 0) for label in (1, 2))
    with page.expect_response("**/doubt/answers") as ignored:
        desk.press("0")
    assert ignored.value.status == 204
    with page.expect_response("**/doubt/answers?classifier=*") as undone:
        page.get_by_role("button", name="Undo answer").click()
    assert undone.value.status == 204
    desk.until(f"{asked} === {points}")
    with page.expect_response("**/doubt/answers") as answered:
        desk.press("1" if (truth[asked_points(server)] > 0).mean() > 0.5 else "2")
    assert answered.value.json()["changed"] == points
    desk.until("pb.state.undo.value !== null")
    assert (server.annotation(SEQUENCE, 0) > 0).sum() == before + points
    page.get_by_role("button", name="Stop asking").click()
    page.get_by_role("button", name="Turn into labels…").click()
    page.get_by_role("slider", name="Minimum confidence").fill("0")
    expect(page.get_by_role("group", name="Changes")).to_contain_text("room")
    page.get_by_role("button", name="Label the points").click()
    desk.until("pb.labels(0)[0] === undefined || pb.labels(0)[0] === 0")
    after = server.annotation(SEQUENCE, 0)
    assert (after > 0).sum() > before
    assert (after[truth > 0] == 1).mean() > 0.7
    assert (after[truth == 0] == 2).mean() > 0.7
    desk.press("Control+z")
    desk.until("pb.labels(0)[0] > 0")
