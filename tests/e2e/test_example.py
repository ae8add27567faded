"""Label by example at the desk: learn, look, answer a doubt, apply, take back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from playwright.sync_api import expect

from tests.e2e.conftest import DATA
from tests.e2e.desk import Desk
from tests.e2e.recording import SEQUENCE
from tests.e2e.server import LiveServer

PREDICTED = 65024
"""First of the ids that the page shows predictions by."""


def truth_of(frame: int, folder: Path = DATA) -> NDArray[np.uint16]:
    with np.load(folder / f"{frame:04}.npz") as arrays:
        return np.asarray(arrays["truth"], np.uint16)


def paint_a_little(server: LiveServer, classes: dict[str, NDArray[np.bool_]], share: float) -> None:
    """Give a share of each class's points of frame 0 its label."""
    rng = np.random.default_rng(0)
    values = np.zeros(len(next(iter(classes.values()))), np.uint16)
    for name, mine in classes.items():
        label = server.create_label(SEQUENCE, name, "")
        values[mine & (rng.random(len(mine)) < share)] = label
    server.put_annotation(SEQUENCE, 0, values)


def test_what_is_painted_teaches_and_the_rest_follows(server: LiveServer, desk: Desk) -> None:
    truth = truth_of(0)
    paint_a_little(server, {"people": truth > 0, "room": truth == 0}, 0.05)
    page = desk.page
    page.get_by_role("button", name="By example").click()
    page.get_by_role("button", name="Learn from what is painted").click()
    desk.until(f"Object.keys(pb.drawnLabels()).some((id) => id >= {PREDICTED} && id < 65280)")
    expect(page.get_by_text("in doubt")).to_be_visible()
    page.get_by_role("radio", name="Doubt").click()
    desk.until("Object.keys(pb.drawnLabels()).some((id) => id >= 65280 && id < 65344)")
    desk.press(";")
    expect(page.get_by_text("What is at the ring?")).to_be_visible()
    desk.screenshot("example-doubt")
    before = sum(desk.labels().get(label, 0) for label in (1, 2))
    desk.press("Enter")
    desk.until("pb.state.undo.value !== null && pb.state.pending.value === 0")
    page.get_by_role("button", name="Make labels of what is predicted").click()
    page.get_by_role("button", name="Apply", exact=True).click()
    desk.until("pb.labels(0)[0] === undefined || pb.labels(0)[0] === 0")
    after = server.annotation(SEQUENCE, 0)
    assert (after > 0).sum() > before
    right = (after == 1) == (truth > 0)
    assert right.mean() > 0.9
    desk.press("Control+z")
    desk.until("pb.labels(0)[0] > 0")
