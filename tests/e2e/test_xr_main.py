"""The main job in an emulated Quest 3: paint, feel it, step through time, track, undo."""

from __future__ import annotations

import numpy as np

from tests.e2e.headset import PAINTING, TICK, Headset
from tests.e2e.recording import PERSON, PIN, SEQUENCE, Truth, painted
from tests.e2e.server import LiveServer
from tests.waiting import eventually

# ── painting ─────────────────────────────────────────────────────────────────────────────────


def test_paints_with_the_trigger_and_feels_what_the_server_counts(
    headset: Headset, server: LiveServer, truth: Truth
) -> None:
    x, y, z = truth(0, PERSON)
    headset.pulses()
    # What the ball holds is lit by the shader before anything is pressed.
    headset.reach([x, y, z])
    lit = headset.ask("hs.lit()")
    assert np.isclose(lit["radius"], headset.ask("pb.state.brush.value.radius"))
    assert np.allclose(lit["middle"], [x, y, z], atol=2e-3)
    headset.paint([[x, y, z], [x, y + 0.1, z]], release=False)
    # The page shows the paint before the server has the whole stroke.
    headset.until("(pb.labels()[1] ?? 0) > 20")
    headset.until(f"window.pulses.some((pulse) => pulse.milliseconds === {PAINTING})")
    assert painted(server, 0, 1) == 0
    headset.trigger(0)
    headset.settled()
    count = painted(server, 0, 1)
    assert count > 20
    headset.until(f"pb.labels()[1] === {count}")
    felt = [pulse for pulse in headset.pulses() if pulse["milliseconds"] == PAINTING]
    assert {pulse["hand"] for pulse in felt} == {"right"}
    assert all(0 < pulse["strength"] <= 1 for pulse in felt)
    # A stroke through the air touches nothing: nothing is felt.
    headset.move("right", [0.0, 2.6, 0.5])
    headset.trigger(1)
    headset.trigger(0)
    headset.settled()
    assert [p for p in headset.pulses() if p["milliseconds"] == PAINTING] == []
    assert painted(server, 0, 1) == count


def test_half_a_press_paints_with_half_the_ball_a_whole_one_exactly_what_is_inside(
    headset: Headset, server: LiveServer, truth: Truth
) -> None:
    center, radius = truth(0, PERSON), 0.12
    headset.set_radius(radius)
    headset.reach(center)
    headset.trigger(0.4)
    headset.frames(3)
    headset.trigger(0)
    headset.settled()
    half = painted(server, 0, 1)
    assert half > 5
    headset.paint([center])
    headset.settled()
    points = server.points(SEQUENCE, 0)
    inside = np.linalg.norm(points - np.asarray(center), axis=1) <= radius
    mine = server.annotation(SEQUENCE, 0) == 1
    assert mine.sum() > 2 * half
    # The hand's place is rounded by the emulated runtime: to well under a millimetre.
    assert abs(int(inside.sum()) - int(mine.sum())) <= 0.02 * inside.sum()
    assert (mine & inside).sum() >= 0.98 * inside.sum()


def test_a_ray_paints_what_is_far_away(headset: Headset, server: LiveServer, truth: Truth) -> None:
    headset.click("palette", "Tools")
    headset.click("palette", "Ray")
    target = headset.ask(f"hs.place({truth(0, PERSON)})")
    headset.move("right", [0.3, 1.4, -0.2], target)
    headset.trigger(1)
    headset.frames(2)
    headset.trigger(0)
    headset.settled()
    assert painted(server, 0, 1) > 4


def test_a_lasso_in_the_air_takes_what_lies_behind_it(
    headset: Headset, server: LiveServer, truth: Truth
) -> None:
    headset.click("palette", "Tools")
    headset.click("palette", "Lasso")
    head = [0.0, 1.6, 0.0]
    x, y, z = headset.ask(f"hs.place({truth(0, PERSON)})")
    ahead = headset.ask("hs.tipAhead()")
    first = True
    for dx, dy in ((-0.25, -0.25), (0.25, -0.25), (0.25, 0.25), (-0.25, 0.25)):
        corner = [(h + 0.4 * (t - h)) for h, t in zip(head, (x + dx, y + dy, z), strict=True)]
        headset.move("right", [corner[0], corner[1], corner[2] + ahead])
        if first:
            headset.trigger(1)
            first = False
    headset.trigger(0)
    headset.settled()
    assert painted(server, 0, 1) > 100


def test_eraser_undo_and_redo_are_buttons(
    headset: Headset, server: LiveServer, truth: Truth
) -> None:
    headset.paint([truth(0, PERSON)])
    headset.settled()
    count = painted(server, 0, 1)
    headset.until("pb.state.undo.value !== null")
    # The palette says what undo and redo would change, and does it.
    headset.click("palette", headset.ask("pb.state.undo.value"))
    headset.until("!(1 in pb.labels()) && pb.state.redo.value !== null")
    headset.click("palette", headset.ask("pb.state.redo.value"))
    headset.until(f"pb.labels()[1] === {count} && pb.state.undo.value !== null")
    headset.button("b-button")
    headset.until("!(1 in pb.labels())")
    headset.settled()
    assert painted(server, 0, 1) == 0
    headset.button("y-button", "left")
    headset.until(f"pb.labels()[1] === {count}")
    headset.button("a-button")
    headset.until("pb.state.tool.value === 'erase'")
    headset.paint([truth(0, PERSON)])
    headset.settled()
    assert painted(server, 0, 1) == 0
    # The hints at the controls: what was used is learnt, the next ones come in its place.
    for hand, side in (("left", -0.15), ("right", 0.15)):  # where hints show: in the picture
        headset.move(hand, [side, 1.4, -0.5])
    shown = {"Stick ← →: frames", "Stick pressed: play"}
    eventually(lambda: set(headset.ask("hs.tips('right')")) == shown)
    headset.flick(1, 0)
    shown ^= {"Stick ← →: frames", "Grip: move the room"}
    eventually(lambda: set(headset.ask("hs.tips('right')")) == shown)
    headset.until("hs.tips('left').join() === 'X: timeline'")


# ── time ─────────────────────────────────────────────────────────────────────────────────────


def test_the_thumbstick_steps_runs_and_plays_and_sizes_with_the_grip(headset: Headset) -> None:
    headset.pulses()
    headset.flick(1, 0)
    headset.until("pb.state.frame.value === 1 && pb.shown().frame === 1")
    assert len([pulse for pulse in headset.pulses() if pulse["milliseconds"] == TICK]) == 1
    headset.flick(-1, 0)
    headset.until("pb.state.frame.value === 0")
    headset.lean(1, 0)
    headset.until("pb.state.frame.value >= 4")
    headset.lean(0, 0)
    headset.button("thumbstick")
    headset.until("pb.state.playing.value")
    headset.button("thumbstick")
    headset.until("!pb.state.playing.value")
    before = headset.ask("pb.state.brush.value.radius")
    headset.ask("device.controllers.right.updateButtonValue('squeeze', 1)")
    headset.frames()
    headset.lean(1, 0)
    headset.ask("device.controllers.right.updateButtonValue('squeeze', 0)")
    headset.frames(4)
    # What is left of the push steps through no frames.
    frame = headset.ask("pb.state.frame.value")
    headset.lean(0, 0)
    assert headset.ask("pb.state.brush.value.radius") > before
    assert headset.ask("pb.state.frame.value") == frame


def test_scrubs_on_the_timeline_in_the_room(headset: Headset) -> None:
    headset.slide("timeline", "ruler", 0.05, 0.95)
    headset.until("pb.state.frame.value === 5 && pb.shown().frame === 5")


def test_the_first_minute_a_flying_pin_is_named_painted_tracked_and_felt_to_end(
    headset: Headset, server: LiveServer, truth: Truth
) -> None:
    headset.click("palette", "New")
    headset.click("palette", "pin 1")
    headset.until("pb.state.activeLabel.value === 2")
    headset.set_radius(0.28)
    headset.paint([truth(0, PIN)])
    headset.settled()
    headset.until("pb.state.timeline.value.rows.get(2)?.points[0] > 0")
    headset.pulses()
    headset.click("timeline", "To end")
    headset.until("pb.state.jobs.value.some((job) => job.state === 'done')")
    headset.frames()
    assert any(pulse["strength"] == 1 for pulse in headset.pulses())
    for frame in range(3):
        points = server.points(SEQUENCE, frame)[server.annotation(SEQUENCE, frame) == 2]
        away = np.linalg.norm(points - truth(frame, PIN), axis=1)
        assert len(points) > 20
        # A pin is half a metre long; this one is in the air.
        assert np.median(away) < 0.25


# ── labels ───────────────────────────────────────────────────────────────────────────────────


def test_makes_chooses_locks_and_picks_labels(
    headset: Headset, server: LiveServer, truth: Truth
) -> None:
    headset.paint([truth(0, PERSON)])
    headset.settled()
    headset.click("palette", "New")
    headset.click("palette", "pin 1")
    headset.until("pb.state.palette.value.length === 2 && pb.state.activeLabel.value === 2")
    labels = server.request("GET", f"sequences/{SEQUENCE}/labels").json()
    rows = labels["labels"] if isinstance(labels, dict) else labels
    assert rows[1]["name"] == "pin 1"
    assert rows[1]["category"] == "pin"
    assert rows[1]["color"] != rows[0]["color"]
    # Another name and colour; deleted when asked again, and brought back by undo.
    for pressed in ("Edit", "hand 1", "#2fd5e0"):
        headset.click("palette", pressed)

    def kept() -> list[tuple[str, str]]:
        rows = server.request("GET", f"sequences/{SEQUENCE}/labels").json()[1:]
        return [(row["name"], row["color"]) for row in rows]

    eventually(lambda: kept() == [("hand 1", "#2fd5e0")])
    headset.click("palette", "Delete")
    headset.click("palette", "Delete it")
    eventually(lambda: kept() == [])
    headset.until("pb.state.palette.value.length === 1 && pb.state.undo.value !== null")
    headset.click("palette", headset.ask("pb.state.undo.value"))
    eventually(lambda: kept() == [("hand 1", "#2fd5e0")])
    count = painted(server, 0, 1)
    headset.click("palette", "Pick")
    target = headset.ask(f"hs.place({truth(0, PERSON)})")
    # From within the painted ball: nothing else of the person is before it.
    headset.move("right", [target[0], target[1], target[2] + 0.06], target)
    # Pressed slowly: half of the way picks, and the rest of it does not paint.
    headset.trigger(0.4)
    headset.until("pb.state.activeLabel.value === 1 && pb.state.tool.value === 'paint'")
    headset.trigger(1)
    headset.move("right", [target[0], target[1] + 0.1, target[2]])
    headset.trigger(0)
    headset.settled()
    assert painted(server, 0, 1) == count
    # A locked label refuses, says so, and bumps.
    headset.click("palette", "Lock")
    headset.until("pb.state.palette.value[0].locked")
    before = painted(server, 0, 1)
    headset.pulses()
    x, y, z = truth(0, PERSON)
    headset.paint([[x, y + 0.15, z]])
    assert any(pulse["strength"] == 1 for pulse in headset.pulses())
    headset.settled()
    assert painted(server, 0, 1) == before
