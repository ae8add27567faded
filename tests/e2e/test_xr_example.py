"""Label by example in the headset: learn, look, answer a doubt, apply."""

from __future__ import annotations

import numpy as np

from tests.e2e.conftest import DATA
from tests.e2e.headset import Wear
from tests.e2e.recording import SEQUENCE
from tests.e2e.server import LiveServer
from tests.e2e.test_example import PREDICTED, paint_a_little

FRAMES = 6
"""Of the recording."""
MOST = 0.9
"""Share of a frame that is labelled when it is predicted, but for the place of no class."""


def most_labelled(server: LiveServer) -> float:
    """Return the share of labelled points in the frame that has most."""
    frames = (server.annotation(SEQUENCE, frame) for frame in range(FRAMES))
    return max(float((labels > 0).mean()) for labels in frames)


def test_the_palette_teaches_asks_and_applies(put_on: Wear, server: LiveServer) -> None:
    headset = put_on()
    with np.load(DATA / "0000.npz") as arrays:
        truth = arrays["truth"]
    paint_a_little(server, {"people": truth > 0, "room": truth == 0})
    headset.until("pb.state.palette.value.length === 3")
    headset.click("palette", "Teach")
    headset.click("palette", "Show the prediction")
    headset.click("palette", "Learn from painted points")
    headset.until(f"Object.keys(pb.drawnLabels()).some((id) => id >= {PREDICTED} && id < 65280)")
    headset.click("palette", "Next doubt")
    headset.until("pb.drawnLabels()[65344] > 0")
    assert most_labelled(server) < MOST
    with headset.page.expect_response("**/doubt/answers") as ignored:
        headset.click("palette", "Neither")
    assert ignored.value.status == 204
    # The answer leads on to the next doubt, which may be in another frame.
    headset.until("pb.drawnLabels()[65344] > 0")
    headset.click("palette", "room")
    headset.until("pb.state.undo.value !== null && pb.state.pending.value === 0")
    headset.click("palette", "Apply to this frame")
    headset.until("pb.state.jobs.value.some((job) => job.state === 'done')")
    assert most_labelled(server) > MOST
