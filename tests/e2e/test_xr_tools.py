"""In the headset: the other tools of the palette, and how the recording is shown."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.e2e.headset import Headset
from tests.e2e.recording import PERSON, SEQUENCE, Truth
from tests.e2e.server import LiveServer


@pytest.fixture
def palette() -> dict[str, str]:
    return {"person": "#ff5d5d", "other": "#5ea2ff"}


def counts(server: LiveServer, layer: str = "label") -> dict[int, int]:
    values, numbers = np.unique(server.annotation(SEQUENCE, 0, layer), return_counts=True)
    return {
        int(value): int(number)
        for value, number in zip(values, numbers, strict=True)
        if int(value) > 0
    }


def in_rig(headset: Headset, points: NDArray[Any]) -> NDArray[np.float64]:
    """Points (N, 3) of the recording in the headset's own space."""
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    origin, *axes = (np.array(headset.ask(f"hs.place({corner})")) for corner in corners)
    turned: NDArray[np.float64] = points @ np.stack([axis - origin for axis in axes]) + origin
    return turned


def press(headset: Headset) -> None:
    headset.frames(2)
    headset.trigger(1)
    headset.frames(2)
    headset.trigger(0)
    headset.settled()


def test_fill_and_box_take_what_they_enclose(
    headset: Headset, server: LiveServer, truth: Truth
) -> None:
    headset.click("palette", "Tools")
    headset.click("palette", "Fill")
    headset.reach(truth(0, PERSON))
    press(headset)
    filled = counts(server)[1]
    assert filled > 100
    headset.button("b-button")
    headset.until("!(1 in pb.labels())")
    # A box between both hands, while both triggers are held.
    headset.click("palette", "Box")
    x, y, z = headset.ask(f"hs.place({truth(0, PERSON)})")
    one, other = [x - 0.3, y - 0.25, z - 0.3], [x + 0.3, y + 0.25, z + 0.3]
    ahead = headset.ask("hs.tipAhead()")
    headset.move("right", [one[0], one[1], one[2] + ahead])
    headset.trigger(1)
    headset.move("left", [other[0], other[1], other[2] + 0.04])
    headset.trigger(1, "left")
    headset.frames(2)
    headset.trigger(0)
    headset.trigger(0, "left")
    headset.settled()
    mine = server.annotation(SEQUENCE, 0) == 1
    places = in_rig(headset, server.points(SEQUENCE, 0))
    slack = 0.03
    inside = ((places > np.array(one) + slack) & (places < np.array(other) - slack)).all(axis=1)
    around = ((places > np.array(one) - slack) & (places < np.array(other) + slack)).all(axis=1)
    assert inside.sum() > 100
    assert mine[inside].all()
    assert not mine[~around].any()
    # The room did not move, although the other trigger was held.
    assert headset.ask("pb.engine.viewer.world.position.length()") == 0


def test_deletes_restores_and_paints_only_what_has_no_label(
    headset: Headset, server: LiveServer, truth: Truth
) -> None:
    headset.set_radius(0.1)
    headset.click("palette", "Tools")
    headset.click("palette", "Delete")
    headset.reach(truth(0, PERSON))
    press(headset)
    assert counts(server, "deleted")[1] > 20
    headset.until("pb.labels()[-1] > 20")
    headset.click("palette", "Restore")
    headset.reach(truth(0, PERSON))
    press(headset)
    assert counts(server, "deleted") == {}
    headset.click("palette", "Paint")
    headset.set_radius(0.06)
    headset.reach(truth(0, PERSON))
    press(headset)
    first = counts(server)[1]
    headset.click("palette", "Only unlabelled points")
    headset.ask("(pb.state.activeLabel.value = 2)")
    headset.set_radius(0.12)
    headset.reach(truth(0, PERSON))
    press(headset)
    both = counts(server)
    # Points that had a label keep it.
    assert both[1] == first
    assert both[2] > 20


def test_a_ray_goes_through_when_told_to(
    headset: Headset, server: LiveServer, truth: Truth
) -> None:
    headset.click("palette", "Tools")
    headset.click("palette", "Ray")
    target = headset.ask(f"hs.place({truth(0, PERSON)})")
    headset.move("right", [0.3, 1.4, -0.2], target)
    press(headset)
    surface = counts(server)[1]
    headset.click("palette", "Ray goes through")
    headset.move("right", [0.3, 1.4, -0.2], target)
    press(headset)
    places = in_rig(headset, server.points(SEQUENCE, 0))
    depth = places[server.annotation(SEQUENCE, 0) == 1][:, 2]
    assert counts(server)[1] > surface
    # The person, and the wall behind.
    assert np.ptp(depth) > 0.5


def test_how_the_recording_is_shown_and_where_one_stands(headset: Headset) -> None:
    rig = "hs.headset.cockpit.rig"
    headset.click("palette", "Solo")
    headset.until("pb.state.solo.value === 1")
    headset.click("palette", "Solo")
    headset.until("pb.state.solo.value === null")
    headset.click("palette", "View")
    headset.click("palette", "Labels over colour")
    headset.until("Math.abs(pb.state.view.value.labelBlend - 0.5) < 0.05")
    for name, setting in (("Point size", "pointSize"), ("Brightness", "brightness")):
        before = headset.ask(f"pb.state.view.value.{setting}")
        headset.slide("palette", name, 0.8)
        headset.until(f"pb.state.view.value.{setting} > {before}")
    headset.click("palette", "Doll")
    headset.until("Math.abs(pb.engine.viewer.world.scale.x - 0.1) < 1e-6")
    headset.click("palette", "Giant")
    headset.until("Math.abs(pb.engine.viewer.world.scale.x - 5) < 1e-6")
    headset.click("palette", "Reset")
    headset.until("pb.engine.viewer.world.scale.x === 1")
    headset.click("palette", "Comfort")
    # Sitting down: the eyes stay where those of standing people are.
    headset.click("palette", "Seated")
    headset.ask("device.position.set(0, 1.2, 0)")
    headset.click("palette", "Seated")
    headset.frames()
    assert abs(headset.ask(f"{rig}.head.y") - 1.2) < 0.01
    headset.click("palette", "Seated")
    headset.frames()
    assert abs(headset.ask(f"{rig}.head.y") - 1.6) < 0.01
    # Gliding, with a vignette while one is moved.
    headset.click("palette", "Glide")
    before = headset.ask(f"[{rig}.head.x, {rig}.head.z]")
    headset.lean(0, -1, "left")
    headset.until("hs.headset.cockpit.locomotion.vignette.visible")
    headset.lean(0, 0, "left")
    after = headset.ask(f"[{rig}.head.x, {rig}.head.z]")
    assert np.hypot(after[0] - before[0], after[1] - before[1]) > 0.02
    headset.until("!hs.headset.cockpit.locomotion.vignette.visible")
    # The timeline is carried by its bar, hidden, and called again where one looks.
    panels = "hs.headset.cockpit.panels"
    headset.point_at("timeline", "Move", 0.5)
    headset.trigger(1)
    headset.move("right", [0.3, 1.2, -0.2], [1.3, 1.0, -0.9])
    headset.trigger(0)
    assert headset.ask(f"{panels}.timeline.mesh.matrix.elements[12]") > 0.3
    headset.click("timeline", "Hide")
    headset.until(f"{panels}.timeline.folded")
    headset.click("palette", "Timeline")
    headset.until("hs.open('timeline')")
    assert abs(headset.ask(f"{panels}.timeline.mesh.matrix.elements[12]")) < 0.1
    # The palette is put away and called, and hangs before the timeline once its hand is gone.
    headset.click("palette", "Put away")
    headset.until(f"{panels}.palette.folded")
    headset.ask("(device.controllers.left.connected = false)")
    headset.call("timeline")
    headset.until(f"{panels}.hangs && {panels}.palette.mesh.visible && hs.open('timeline')")
    # Its handle is seen below the timeline, both at hand.
    down = f"""(([x, y, z], eyes = {rig}.headInRig) =>
      Math.atan2(eyes.y - y, Math.hypot(x - eyes.x, z - eyes.z)))"""
    handle = "hs.areas('palette')[0].y"
    headset.until(
        f"{down}(hs.onPanel('palette', 0.5, {handle}).at)"
        f" > {down}(hs.onPanel('timeline', 0.3, 1).at)"
    )
    headset.click("timeline", "Palette")
    headset.until(f"hs.open('palette') && {panels}.hangs && hs.open('timeline')")
    headset.click("palette", "Tools")
    headset.click("palette", "Erase")
    headset.until("pb.state.tool.value === 'erase'")
    headset.click("palette", "Timeline")
    headset.click("timeline", "loop")
    headset.until("pb.state.loop.value === false")
    headset.click("timeline", "1×")
    headset.until("pb.state.speed.value === 2")
