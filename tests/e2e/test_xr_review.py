"""In the headset: overlays, ground, doubt, new names, what is felt, tasks."""

from __future__ import annotations

import uuid
from contextlib import closing

import numpy as np
import pytest

from pointbrush.client import Client
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.e2e.headset import PAINTING, QUEST, VIVE, Headset, Wear
from tests.e2e.recording import (
    PERSON,
    SEQUENCE,
    Truth,
    corners_of,
    heights,
    painted,
    put_dust,
    room_of,
    stands_as,
    tip_over,
)
from tests.e2e.server import LiveServer
from tests.waiting import eventually


def paint_over_rest(
    server: LiveServer, frame: int, center: list[float], radius: float, label: int = 1
) -> None:
    """A ball of a label, painted by somebody else's program."""
    stroke = {
        "id": str(uuid.uuid4()),
        "label": label,
        "tool": "paint",
        "shape": "sphere",
        "radius": radius,
        "samples": [{"origin": center}],
    }
    server.request("POST", f"sequences/{SEQUENCE}/frames/{frame}/strokes", json=stroke)


# ── boxes, trails, ghost ─────────────────────────────────────────────────────────────────────


def test_boxes_trails_and_ghost_are_drawn_and_switched_in_the_palette(
    headset: Headset, server: LiveServer, truth: Truth
) -> None:
    for frame in range(3):
        paint_over_rest(server, frame, truth(frame, PERSON), 0.1)
        headset.flick_to_frame(frame)
    # Three frames with the label near the playhead: a dot for each, and where it was before.
    headset.until("hs.overlays().trails === 3 && hs.overlays().ghost > 20")
    ghost = headset.ask("hs.overlays().ghost")
    assert ghost == int((server.annotation(SEQUENCE, 1) == 1).sum())
    assert headset.ask("hs.overlays().boxes") == 0
    headset.click("palette", "View")
    headset.click("palette", "Label boxes")
    headset.until("hs.overlays().boxes === 1")
    # The box holds the label's points: its middle is theirs, to a hand's breadth.
    xyz = server.points(SEQUENCE, 2)[server.annotation(SEQUENCE, 2) == 1]
    middle = headset.ask(f"hs.place({((xyz.min(0) + xyz.max(0)) / 2).tolist()})")
    box = headset.ask(
        """(() => {
          let box = null;
          pb.engine.viewer.world.traverse((o) => { if (o.isInstancedMesh) box = o; });
          const { array } = box.instanceMatrix, sum = [0, 0, 0];
          for (let i = 0; i < box.count; i++)
            for (let k = 0; k < 3; k++) sum[k] += array[16 * i + 12 + k] / box.count;
          const at = hs.headset.cockpit.rig.head.clone().set(...sum);
          return hs.headset.cockpit.rig.group.worldToLocal(box.localToWorld(at)).toArray();
        })()"""
    )
    assert np.linalg.norm(np.subtract(box, middle)) < 0.1
    for name, what in (("Label boxes", "boxes"), ("Trails", "trails"), ("Ghost", "ghost")):
        headset.click("palette", name)
        headset.until(f"hs.overlays().{what} === 0")
    # What is hidden has neither box nor trail.
    headset.click("palette", "Label boxes")
    headset.until("hs.overlays().boxes === 1")
    headset.click("palette", "Labels")
    headset.click("palette", "Hide")
    headset.until("hs.overlays().boxes === 0")


# ── ground ───────────────────────────────────────────────────────────────────────────────────


def test_the_ground_under_the_ray_is_deleted_and_comes_back_and_can_be_set_as_floor(
    headset: Headset, server: LiveServer
) -> None:
    headset.click("palette", "Tools")
    headset.click("palette", "Delete")
    headset.click("palette", "Ground")
    headset.set_radius(0.08)
    points = server.points(SEQUENCE, 0)
    headset.move("right", [0.5, 1.3, -0.2], [0.6, 0.0, -0.9])
    headset.frames(4)
    headset.trigger(1)
    headset.trigger(0)
    headset.settled()
    gone = server.annotation(SEQUENCE, 0, "deleted").astype(bool)
    assert gone.sum() > 500
    # All that went lies in one plane, and it is the floor: its height in the room is zero.
    off = points[gone] - points[gone].mean(axis=0)
    spread = np.linalg.svd(off, compute_uv=False) / np.sqrt(gone.sum())
    assert spread[2] < 0.05 * spread[1]
    height = headset.ask(f"hs.place({points[gone].mean(axis=0).tolist()})[1]")
    assert abs(height) < 0.05
    # Off the ground: the preview under a still hand shows what a further press would delete.
    headset.move("right", [0.5, 1.3, -0.2], [0.5, 3.0, -0.2])
    headset.button("b-button")
    headset.until("!(-1 in pb.labels())")
    set_the_floor(headset, server)


def set_the_floor(headset: Headset, server: LiveServer) -> None:
    """Point at three places of the floor of a recording that stands crooked; then go back."""
    # What somebody else changed shows at once, without leaving the headset.
    found, floor = tip_over(headset, server)
    headset.click("palette", "View")
    headset.click("palette", "Floor")
    for place in corners_of(floor):
        x, y, z = headset.ask(f"hs.place({place})")
        headset.move("right", [x, y + 0.3, z], [x, y, z])
        headset.trigger(1)
        headset.trigger(0)
        headset.until("pb.state.notices.value.at(-1)?.title === 'Floor set'")
    # The last of three places asks for no more.
    headset.until("pb.state.notices.value.at(-1)?.detail === ''")
    assert np.abs(heights(server, floor)).mean() < 0.02
    stands_as(headset, room_of(server))
    # Nothing was painted, and the import's own floor can be had back.
    assert painted(server, 0) == 0
    headset.click("palette", "Reset to import")
    stands_as(headset, found)
    assert np.allclose(room_of(server), found)
    headset.click("palette", "Done")
    headset.until("pb.state.tool.value === 'paint'")


# ── doubt ────────────────────────────────────────────────────────────────────────────────────


def pretend_tracked(headset: Headset, frame: int, confidence: float) -> None:
    """The page believes that a frame was tracked: what a run would have written."""
    headset.ask(
        f"""(() => {{
          const table = pb.state.timeline.value, row = table.rows.get(1);
          row.points[{frame}] = 50; row.painted[{frame}] = 0;
          row.confidence[{frame}] = {confidence}; row.state[{frame}] = 2;
          pb.state.timeline.value = {{ rows: new Map(table.rows) }};
        }})()"""
    )


def cell(headset: Headset, frame: int) -> list[int]:
    """The colours, red green blue, that the first label's strip has in a frame, as a set."""
    colours: list[int] = headset.ask(
        f"""(() => {{
          const {{ timeline }} = hs.headset.cockpit.panels, {{ ui, span, strips }} = timeline;
          const wide = strips.w / span.length, tall = (strips.h - 1.9 * ui.em) / 6;
          const at = [strips.x + {frame} * wide + 0.3 * wide, strips.y + 1.9 * ui.em + 0.3 * tall];
          const size = [0.4 * wide, 0.5 * tall].map(Math.round);
          const {{ data }} = ui.pen.getImageData(...at.map(Math.round), ...size);
          const found = new Set();
          for (let i = 0; i < data.length; i += 4)
            found.add(data[i] * 65536 + data[i + 1] * 256 + data[i + 2]);
          return [...found];
        }})()"""
    )
    return colours


def test_a_doubtful_label_pulses_and_one_button_steps_through_the_doubt(
    headset: Headset, server: LiveServer, truth: Truth
) -> None:
    paint_over_rest(server, 0, truth(0, PERSON), 0.1)
    headset.until("pb.state.timeline.value.rows.get(1)?.points[0] > 0")
    assert headset.ask("hs.doubt().pulse") == 0
    for frame in (2, 4):
        pretend_tracked(headset, frame, 0.2)
    pretend_tracked(headset, 5, 0.95)
    for frame in (2, 4, 2):
        headset.button("thumbstick", "left")
        headset.until(f"pb.state.frame.value === {frame} && hs.doubt().unsure[0] === 1")
    headset.call("palette")
    headset.until("hs.doubt().pulse > 0.6 && hs.headset.cockpit.panels.palette.glow.mesh.visible")
    headset.until("hs.doubt().pulse < 0.4")
    headset.flick_to_frame(3)
    headset.until("hs.doubt().unsure.length === 0 && hs.doubt().pulse === 0")
    # In the room's timeline painted frames are the label's colour, tracked ones a paler one of it,
    # doubtful ones hatched, and empty ones neither.
    headset.call("timeline")
    eventually(lambda: 0xFF5D5D in cell(headset, 0))
    assert len(cell(headset, 2)) > 1
    assert len(cell(headset, 3)) == 1
    assert 0xFF5D5D not in cell(headset, 2) + cell(headset, 3) + cell(headset, 5)
    (tracked,), (empty,) = cell(headset, 5), cell(headset, 3)
    assert (tracked >> 16) - (tracked & 255) > (empty >> 16) - (empty & 255) + 40


def test_labels_and_range_are_chosen_and_what_is_found_shows_while_the_run_goes_on(
    headset: Headset, server: LiveServer, truth: Truth
) -> None:
    # Both can be followed surely: what is in doubt is told only when it has been looked at again.
    server.create_label(SEQUENCE, "ground", "#5ea2ff")
    xyz = server.points(SEQUENCE, 4).astype(np.float64)
    place = corners_of(xyz[np.abs(heights(server, xyz)) < 0.02])[0]
    paint_over_rest(server, 4, truth(4, PERSON), 0.12)
    paint_over_rest(server, 4, place, 0.3, label=2)
    headset.flick_to_frame(4)
    headset.until("pb.state.timeline.value.rows.get(2)?.points[4] > 0")
    headset.ask(
        """(() => {
          const { link } = pb.engine, heard = link.listener;
          window.found = [];
          link.listener = (message) => {
            if (message.t === 'labels' && message.update.provisional) {
              const runs = pb.state.jobs.value.some((job) => job.state === 'running');
              window.found.push([message.update.frame, runs]);
              window.again = () => heard(message);
            }
            heard(message);
          };
        })()"""
    )
    # All labels that are here, backward over a range that is drawn on the strips.
    headset.slide("timeline", "strips", 4.5 / 6, 1.5 / 6)
    headset.click("timeline", "Track person")
    headset.click("timeline", "Frames 1 – 4")
    headset.until("pb.state.jobs.value.some((job) => job.state === 'done')", 60)
    assert {frame for frame, runs in headset.ask("window.found") if runs} & {1, 2, 3}
    # Both went one frame back at least, and neither beyond the range nor the other way.
    assert painted(server, 3, 1) > 0
    assert painted(server, 3, 2) > 0
    edits = server.request("GET", f"sequences/{SEQUENCE}/edits").json()
    (run,) = [edit for edit in edits if edit["kind"] == "tracking"]
    assert {3} <= set(run["frames"]) <= {1, 2, 3}
    # What a run found and comes when it has ended is not shown over what people do then.
    headset.ask("window.again()")
    headset.button("b-button")
    frame = min(run["frames"])
    headset.until(f"!(1 in pb.labels({frame})) && !(2 in pb.labels({frame}))")


def stop_unsure(headset: Headset, server: LiveServer) -> None:
    """Track what nobody could: the run stops at the first frame, and one is taken there."""
    put_dust(server)
    headset.until("pb.state.timeline.value.rows.get(1)?.points[0] === 60")
    headset.click("timeline", "To end")
    headset.until("hs.doubt().halted !== null && pb.state.frame.value === 1", 60)
    assert headset.ask("hs.doubt().halted") == {"at": 1, "stop": 5, "labels": [1]}
    assert headset.ask("hs.doubt().unsure") == [1]
    # The run went no further than where it was unsure.
    headset.until("pb.state.timeline.value.rows.get(1).points[1] > 0")
    assert painted(server, 2) == 0


def test_a_run_stops_where_it_is_unsure_is_mended_by_a_stroke_and_goes_on(
    headset: Headset, server: LiveServer, truth: Truth
) -> None:
    stop_unsure(headset, server)
    headset.paint([truth(1, PERSON)])
    headset.settled()
    headset.until("hs.doubt().unsure.length === 0")
    headset.click("question", "Continue to 5")
    headset.until("pb.state.timeline.value.rows.get(1).points[2] > 0", 60)


def test_a_doubtful_frame_is_accepted_and_the_run_goes_on_when_asked(
    headset: Headset, server: LiveServer
) -> None:
    headset.click("palette", "View")
    headset.click("palette", "Doll")
    stop_unsure(headset, server)
    # The question is beside the whole model.
    headset.until("hs.open('question')")
    assert not headset.hides_model("question")
    found = painted(server, 1)
    headset.click("question", "Confirm")
    headset.until("hs.doubt().unsure.length === 0")
    # A person has vouched for these points: they count as painted.
    provenance = server.annotation(SEQUENCE, 1, "provenance")
    assert (provenance[server.annotation(SEQUENCE, 1) == 1] == 1).all()
    assert painted(server, 1) == found > 0
    headset.click("question", "Continue to 5")
    headset.until("pb.state.timeline.value.rows.get(1).points[2] > 0", 60)


# ── names ────────────────────────────────────────────────────────────────────────────────────


def test_a_label_is_named_with_the_headsets_keyboard(headset: Headset, server: LiveServer) -> None:
    headset.click("palette", "New")
    headset.click("palette", "Type a name")
    headset.page.locator("input[aria-label='Name of the new label']").wait_for(state="attached")
    headset.page.keyboard.type("café on the left")
    headset.page.keyboard.press("Enter")
    headset.until("pb.state.palette.value.some((label) => label.name === 'café on the left')")
    rows = server.request("GET", f"sequences/{SEQUENCE}/labels").json()
    assert rows[-1]["name"] == "café on the left"
    headset.until(f"pb.state.activeLabel.value === {rows[-1]['id']}")
    assert headset.page.locator("input[aria-label='Name of the new label']").count() == 0
    # Letting go without a word makes nothing.
    headset.click("palette", "New")
    headset.click("palette", "Type a name")
    headset.page.keyboard.press("Escape")
    headset.frames()
    assert len(server.request("GET", f"sequences/{SEQUENCE}/labels").json()) == len(rows)


# ── what is felt ─────────────────────────────────────────────────────────────────────────────


def felt(headset: Headset) -> list[float]:
    return [p["strength"] for p in headset.pulses() if p["milliseconds"] == PAINTING]


def test_only_what_changes_is_felt_and_a_lock_is_a_bump(
    headset: Headset, server: LiveServer, truth: Truth
) -> None:
    center = truth(0, PERSON)
    headset.pulses()
    headset.set_radius(0.02)
    headset.paint([center])
    headset.settled()
    headset.until(f"window.pulses.some((pulse) => pulse.milliseconds === {PAINTING})")
    few = max(felt(headset))
    headset.set_radius(0.15)
    headset.paint([center])
    headset.settled()
    headset.until(f"window.pulses.some((pulse) => pulse.milliseconds === {PAINTING})")
    # More points, a stronger pulse.
    assert max(felt(headset)) > few
    # Points that have the label already are touched, and nothing is felt.
    headset.paint([center])
    headset.settled()
    headset.frames()
    assert felt(headset) == []
    headset.click("palette", "Lock")
    headset.until("pb.state.palette.value[0].locked")
    headset.until("window.pulses.some((pulse) => pulse.strength === 1)")


# ── tasks ────────────────────────────────────────────────────────────────────────────────────


@pytest.mark.parametrize("one_wand", [False, True], ids=["quest", "one-wand"])
def test_tasks_are_taken_handed_in_accepted_and_returned_without_leaving(
    put_on: Wear, server: LiveServer, *, one_wand: bool
) -> None:
    with closing(Workspace(Settings(workspace=server.workspace))) as opened:
        token = opened.labels.tokens.add("annotator", "bob")
    server.request("POST", "projects/default/tasks", json={"recordings": [SEQUENCE], "every": 2})
    theirs: list[str] = []
    with Client(server.url, token) as bob:
        for _ in range(2):
            call = bob.call("POST", "/projects/default/tasks/next", json={"work": "label"})
            theirs.append(f"projects/default/tasks/{call.json()['number']}")
            bob.call("PATCH", f"/{theirs[-1]}", json={"state": "done"})
    headset = put_on(VIVE if one_wand else QUEST)
    if one_wand:
        headset.ask("(device.controllers.left.connected = false)")
        # Without a hand to hang from, the palette's handle comes to rest beside the timeline's.
        headset.until("hs.headset.cockpit.panels.spot.handless")
        headset.frames()
    headset.click("palette", "Work")
    headset.click("palette", "Next task")
    headset.click("palette", "Hand in")
    # Without a change the task is handed in after a question, which is asked in the headset.
    headset.click("palette", "Keep working")
    headset.click("palette", "Hand in")
    headset.click("palette", "Hand in anyway")
    # The rows below move when the server has answered.
    names = "hs.areas('palette').map(({ name }) => name)"
    headset.until(f"{names}.includes('Next task')")
    headset.click("palette", "Next to review")
    headset.click("palette", "Accept")
    headset.until(f"!{names}.includes('Accept')")
    headset.click("palette", "Next to review")
    headset.click("palette", "Return…")
    note = headset.page.locator("input[aria-label='Note for the correction']")
    note.wait_for(state="attached")
    headset.page.keyboard.type("The left pin")
    headset.page.keyboard.press("Enter")

    def states() -> list[str]:
        return [server.request("GET", task).json()["state"] for task in theirs]

    eventually(lambda: sorted(states()) == ["accepted", "returned"])
    returned = server.request("GET", theirs[states().index("returned")]).json()
    assert returned["note"] == "The left pin"
    tasks = server.request("GET", "projects/default/tasks").json()
    assert sorted(task["state"] for task in tasks) == ["accepted", "done", "returned"]
    headset.until(f"!{names}.includes('Accept')")
    headset.click("palette", "Export at the desk")
    headset.until("pb.state.notices.value.some(({ action }) => action?.label === 'Export')")
    assert headset.ask("pb.state.xr.value.session") == "running"
