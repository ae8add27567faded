"""The main job at the desk: play, paint, share, undo, survive, track, export."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from playwright.sync_api import expect

from tests.e2e.conftest import DATA
from tests.e2e.desk import Desk
from tests.e2e.recording import (
    PERSON,
    SEQUENCE,
    Truth,
    name_person,
    paint_person,
    painted,
    shows_paint,
)
from tests.e2e.server import LiveServer
from tests.waiting import eventually

Open = Callable[..., Desk]


# ── time ─────────────────────────────────────────────────────────────────────────────────────


def test_plays_ends_without_loop_pauses_and_steps(desk: Desk) -> None:
    # Playing does not wait for points: none of a later frame is here yet.
    desk.press("l")
    desk.press("Space")
    desk.until("!pb.state.playing.value && pb.state.frame.value === 5")
    desk.until("pb.shown().frame === 5 && pb.shown().points === pb.shown().total")
    desk.press("l")
    desk.press("Space")
    desk.until("pb.state.playing.value && pb.state.frame.value < 5")
    before = desk.ask("pb.counters().pictures")
    desk.until(f"pb.counters().pictures > {before + 3}")
    desk.press("Space")
    desk.until("!pb.state.playing.value")
    paused = desk.ask("pb.state.frame.value")
    desk.press("ArrowRight")
    desk.until(f"pb.shown().frame === {(paused + 1) % 6}")
    desk.press("ArrowLeft")
    desk.until(f"pb.shown().frame === {paused}")
    desk.until("pb.shown().points === pb.shown().total")


def test_every_point_arrives_once_by_steps_and_on_the_timeline(
    desk: Desk, server: LiveServer
) -> None:
    points = server.request("GET", f"sequences/{SEQUENCE}").json()["points"]
    for frame in range(3):
        desk.until(f"pb.shown().frame === {frame} && pb.shown().points === {points[frame]}")
        assert sum(desk.labels(frame).values()) == points[frame]
        desk.press("ArrowRight")
    box = desk.page.locator("#timeline canvas").first.bounding_box()
    assert box is not None
    y = box["y"] + 10
    desk.page.mouse.move(box["x"] + box["width"] * 0.3, y)
    desk.page.mouse.down()
    desk.page.mouse.move(box["x"] + box["width"] * 0.95, y, steps=8)
    desk.page.mouse.up()
    desk.until("pb.state.frame.value === 5 && pb.shown().frame === 5")
    desk.until("pb.shown().points === pb.shown().total")


# ── painting ─────────────────────────────────────────────────────────────────────────────────


def test_paints_with_the_mouse(desk: Desk, server: LiveServer, truth: Truth) -> None:
    label = server.create_label(SEQUENCE, "person", "#ff5d5d")
    desk.until(f"pb.state.activeLabel.value === {label}")
    x, y, z = truth(0, PERSON)
    desk.paint([[x, y, z], [x, y + 0.12, z]], release=False)
    # The page shows the paint before the server has the whole stroke.
    desk.until(f"(pb.labels()[{label}] ?? 0) > 20")
    assert painted(server, 0, label) == 0
    desk.page.mouse.up()
    desk.settled()
    count = painted(server, 0, label)
    assert count > 20
    desk.until(f"pb.labels()[{label}] === {count} && pb.drawnLabels()[{label}] === {count}")
    desk.until(f"new Map(pb.state.counts.value).get({label}) === {count}")
    provenance = server.annotation(SEQUENCE, 0, "provenance")
    assert int((provenance == 1).sum()) == count


def test_another_window_sees_the_paint_and_the_palette(
    open_desk: Open, server: LiveServer, truth: Truth
) -> None:
    one, other = open_desk(), open_desk(width=900, height=600)
    one.press("n")
    other.until("pb.state.palette.value.length === 1")
    paint_person(one, truth)
    count = painted(server, 0, 1)
    assert count > 20
    other.until(f"pb.labels()[1] === {count}")
    other.until("pb.state.loaded.value.every((r) => r.complete && r.last - r.first === 5)")
    before = other.ask("pb.counters().bytes")
    server.request("PATCH", f"sequences/{SEQUENCE}/labels/1", json={"color": "#00ff00"})
    other.until("pb.state.palette.value[0].color === '#00ff00'")
    assert other.ask("pb.counters().bytes") == before, "recolouring must not send points"


def test_undo_and_redo(desk: Desk, server: LiveServer, truth: Truth) -> None:
    name_person(desk, server)
    paint_person(desk, truth)
    count = painted(server, 0, 1)
    desk.until("pb.state.undo.value !== null")
    desk.press("Control+z")
    desk.until("!(1 in pb.labels())")
    desk.settled()
    assert painted(server, 0, 1) == 0
    desk.press("Control+Shift+z")
    desk.until(f"pb.labels()[1] === {count}")
    desk.settled()
    assert painted(server, 0, 1) == count


def test_eraser_and_deleting_noise(desk: Desk, server: LiveServer, truth: Truth) -> None:
    name_person(desk, server)
    paint_person(desk, truth, length=0.2)
    before = painted(server, 0, 1)
    desk.press("c")
    desk.until("pb.state.tool.value === 'erase'")
    paint_person(desk, truth, length=0.0)
    assert 0 < painted(server, 0, 1) < before
    desk.press("x")
    desk.until("pb.state.tool.value === 'delete'")
    paint_person(desk, truth, length=0.0)
    deleted = int(server.annotation(SEQUENCE, 0, "deleted").sum())
    assert deleted > 5
    desk.until(f"pb.labels()[-1] === {deleted}")


def test_a_locked_label_keeps_its_points(desk: Desk, server: LiveServer, truth: Truth) -> None:
    for name, color in (("kept", "#ff5d5d"), ("new", "#2fd5e0")):
        server.create_label(SEQUENCE, name, color)
    desk.until("pb.state.palette.value.length === 2")
    desk.press("1")
    paint_person(desk, truth, length=0.0)
    kept = painted(server, 0, 1)
    server.request("PATCH", f"sequences/{SEQUENCE}/labels/1", json={"locked": True})
    desk.until("pb.state.palette.value[0].locked")
    desk.press("2")
    paint_person(desk, truth, length=0.2)
    assert painted(server, 0, 1) == kept
    assert painted(server, 0, 2) > 0
    desk.until(f"pb.labels()[1] === {kept}")


def test_fill_takes_the_region_under_the_cursor_and_a_lasso_what_is_inside(
    desk: Desk, server: LiveServer, truth: Truth
) -> None:
    name_person(desk, server)
    x, y, z = truth(0, PERSON)
    desk.press("k")
    desk.paint([[x, y, z]])
    desk.settled()
    shows_paint(desk, server, 50)
    desk.press("Control+z")
    desk.settled()
    assert painted(server, 0) == 0
    desk.press("o")
    r = 0.25
    desk.paint([[x - r, y - r, z], [x + r, y - r, z], [x + r, y + r, z], [x - r, y + r, z]])
    desk.settled()
    shows_paint(desk, server, 200)


# ── faults ───────────────────────────────────────────────────────────────────────────────────


def test_answered_strokes_survive_a_killed_server(
    server: LiveServer, open_desk: Open, truth: Truth
) -> None:
    desk = open_desk()
    name_person(desk, server)
    paint_person(desk, truth)
    server.kill()
    desk.until("pb.state.connection.value.state === 'offline'")
    server.start()
    assert painted(server, 0) > 20
    desk.until("pb.state.connection.value.state === 'online'")
    shows_paint(desk, server, 20)
    # The browser itself logs that it could not reach the server.
    desk.complaints.clear()


STROKE = """([brush, samples]) => {
  const stroke = window.__pointbrush.engine.beginStroke(brush);
  for (const [origin, direction] of samples) stroke.add({ origin, direction });
  stroke.end();
  return [stroke.id, stroke.preview.points];
}"""
"""Make a stroke; returns its id and the points that the page expects to change."""
NOTE_RESULTS = """() => {
  window.changed = {};
  window.__pointbrush.engine.strokes.results.add(({ id, final, changed }) => {
    if (final) window.changed[id] = changed;
  });
}"""


def random_stroke(
    random: np.random.Generator, xyz: NDArray[np.float64], tools: list[str]
) -> tuple[dict[str, Any], list[Any]]:
    """Return a brush of any shape that the page selects by itself, and rays at points (n, 3)."""
    tool = str(random.choice(tools))
    shape = str(random.choice(["ray", "ray", "sphere", "box", "lasso"]))
    target = xyz[random.integers(len(xyz))]
    places = target + random.normal(0, 0.1, (6, 3))
    brush = {
        "tool": tool,
        "label": int(random.integers(1, 4)) if tool == "paint" else 0,
        "shape": shape,
        "radius": float(random.uniform(0.01, 0.15)),
        "through": bool(random.random() < 0.2),
        "only_unlabeled": bool(random.random() < 0.3),
    }
    if shape == "box":
        brush |= {"center": target.tolist(), "size": random.uniform(0.05, 0.5, 3).tolist()}
    if shape == "lasso":
        # A pinhole camera at the sensor, which looks along z.
        u, v = target[:2] / target[2]
        corners = [(-0.1, -0.1), (0.12, -0.05), (0.1, 0.1), (-0.07, 0.13)]
        brush["polygon"] = [[float(u + a), float(v + b)] for a, b in corners]
        sign = float(np.sign(target[2]))
        brush["matrix"] = [sign, 0, 0, 0, 0, sign, 0, 0, 0, 0, sign, -0.1, 0, 0, sign, 0]
        return brush, []
    if shape == "box":
        return brush, []
    if shape == "sphere":
        return brush, [[place.tolist(), [0.0, 0.0, 1.0]] for place in places[:3]]
    ways = places / np.linalg.norm(places, axis=1)[:, None]
    return brush, [[[0.0, 0.0, 0.0], way.tolist()] for way in ways]


def test_what_a_stroke_shows_is_what_it_changes_also_offline(
    server: LiveServer, open_desk: Open
) -> None:
    desk = open_desk()
    for name in ("person", "pin", "wall"):
        server.create_label(SEQUENCE, name, "#ff5d5d")
    desk.until("pb.state.palette.value.length === 3")
    desk.page.evaluate(NOTE_RESULTS)
    xyz = server.points(SEQUENCE, 0).astype(np.float64)
    random = np.random.default_rng(61)
    shown: dict[str, int] = {}
    for _ in range(50):
        brush = random_stroke(random, xyz, ["paint", "paint", "erase", "delete", "restore"])
        stroke, points = desk.page.evaluate(STROKE, list(brush))
        shown[stroke] = points
        desk.until(f"window.changed['{stroke}'] !== undefined")
        desk.settled()
    server.kill()
    desk.until("pb.state.connection.value.state === 'offline'")
    for _ in range(50):
        # The page does not know which label a deleted point has, so that it restores none here.
        brush = random_stroke(random, xyz, ["paint", "paint", "erase", "delete"])
        stroke, points = desk.page.evaluate(STROKE, list(brush))
        shown[stroke] = points
    labels = desk.labels()
    assert desk.ask("pb.state.pending.value") == 50
    server.start()
    desk.until("pb.state.connection.value.state === 'online'")
    desk.settled()
    assert desk.ask("window.changed") == shown
    assert sum(points > 0 for points in shown.values()) > 50
    deleted = server.annotation(SEQUENCE, 0, "deleted")
    for label in range(4):
        kept = int(((server.annotation(SEQUENCE, 0) == label) & (deleted == 0)).sum())
        assert kept == labels.get(label, 0)
    edits = server.request("GET", f"sequences/{SEQUENCE}/edits?limit=1000").json()
    assert len({edit["id"] for edit in edits}) == len(edits)
    assert desk.ask("pb.state.notices.value.map((notice) => notice.title)") == []
    desk.complaints.clear()


KEPT_EDITS = """() => new Promise((resolve) => {
  const opening = indexedDB.open('pointbrush', 1);
  opening.onsuccess = () => {
    const database = opening.result;
    const counting = database.transaction('outbox').objectStore('outbox').count();
    counting.onsuccess = () => (database.close(), resolve(counting.result));
  };
})"""
"""Number of edits that the browser has stored until the server answers them."""


def test_strokes_survive_a_closed_window(server: LiveServer, open_desk: Open, truth: Truth) -> None:
    desk = open_desk()
    name_person(desk, server)
    server.kill()
    desk.until("pb.state.connection.value.state === 'offline'")
    paint = truth(0, PERSON)
    desk.paint([paint])
    eventually(lambda: desk.page.evaluate(KEPT_EDITS))
    desk.page.close()
    server.start()
    again = Desk(desk.context.new_page(), server.page_url)
    again.ready()
    again.settled()
    assert painted(server, 0, 1) > 5
    desk.complaints.clear()
    assert again.complaints == []


def test_a_wrong_token_is_said_plainly(open_desk: Open, server: LiveServer) -> None:
    desk = open_desk()
    desk.context.clear_cookies()
    server.kill()
    desk.until("pb.state.connection.value.state === 'offline'")
    server.start()
    desk.until("pb.state.connection.value.state === 'refused'")
    assert "token" in desk.ask("pb.state.connection.value.detail")
    desk.complaints.clear()


def test_who_signs_out_is_out_and_lost_nothing(desk: Desk, server: LiveServer) -> None:
    desk.ask("pb.engine.closeSequence()")
    expect(desk.page.get_by_text("Signed in as")).to_contain_text("admin")
    desk.page.get_by_role("button", name="Sign out").click()
    expect(desk.page.get_by_role("heading", name="You are signed out")).to_be_visible()
    assert desk.page.evaluate("fetch('api/v1/session').then((answer) => answer.status)") == 401
    desk.page.reload()
    expect(desk.page.get_by_role("heading", name="You are signed out")).to_be_visible()
    desk.page.goto(server.page_url)
    desk.ready()
    desk.complaints.clear()  # refused requests are told in the console


def test_a_link_to_a_recording_that_is_gone_leads_to_the_list(
    desk: Desk, server: LiveServer
) -> None:
    desk.page.goto(f"{server.url}/?sequence=juggling")
    desk.ready()
    desk.ask("(pb.engine.openSequence('gone'), 1)")
    desk.until("pb.state.notices.value.some((notice) => notice.title === 'Not found')")
    desk.until("pb.state.opening.value === null && pb.state.sequence.value === null")


def test_a_lost_graphics_context_is_told_and_comes_back(
    open_desk: Open, server: LiveServer, truth: Truth
) -> None:
    desk = open_desk(width=960, height=540, drawn=True)
    name_person(desk, server)
    paint_person(desk, truth)
    desk.page.get_by_role("button", name="Frames", exact=True).click()
    desk.page.get_by_role("button", name="All frames").click()
    desk.until("pb.engine.viewer.laid > 0")
    desk.press("Escape")
    desk.page.mouse.move(480, 5)
    shown = "[pb.shown(), pb.engine.viewer.laid, pb.labels()]"
    before = json.dumps(desk.ask(shown), separators=(",", ":"))
    # Returns the picture, and the share of its pixels that changed since the last call.
    desk.ask("""(window.changed = () => {
      const { renderer } = pb.engine.viewer, gl = renderer.getContext();
      pb.engine.viewer.drawDesk();
      const pixels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
      gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      const last = window.pixels ?? pixels;
      window.pixels = pixels;
      return pixels.filter((value, i) => Math.abs(value - last[i]) > 8).length / pixels.length;
    }, 1)""")  # noqa: E501
    desk.until("window.changed() < 0.001 && window.pixels.some((value, i) => i % 4 < 3 && value)")

    told = desk.page.get_by_text("The graphics card stopped drawing")
    desk.ask(
        "(window.lose = pb.engine.viewer.renderer.getContext().getExtension('WEBGL_lose_context'),"
        " window.lose.loseContext(), 1)"
    )
    expect(told).to_be_visible()
    desk.ask("(window.lose.restoreContext(), 1)")
    expect(told).to_have_count(0)
    desk.until(f"JSON.stringify({shown}) === {json.dumps(before)}")
    assert desk.ask("window.changed()") < 0.001


# ── the rest of the job ──────────────────────────────────────────────────────────────────────


def test_five_clicks_lead_from_the_address_to_a_tracked_and_exported_label(
    desk: Desk, server: LiveServer, truth: Truth
) -> None:
    desk.ask("(window.clicks = 0, addEventListener('click', () => { window.clicks += 1 }, true))")
    desk.page.get_by_role("button", name="Create a label").click()
    desk.page.keyboard.type("person")
    desk.press("Enter")
    desk.until("pb.state.activeLabel.value > 0")
    desk.press("j")
    desk.page.mouse.click(*desk.place(truth(0, PERSON)))
    desk.page.get_by_role("button", name="Track forward").click()
    desk.until("pb.state.jobs.value.some((j) => j.kind === 'tracking' && j.state === 'done')", 90)
    with desk.page.expect_download() as started:
        desk.page.get_by_role("button", name="Export").click()
        desk.page.get_by_role("button", name="NPZ").click()
    assert desk.ask("window.clicks") == 5
    path = started.value.path()
    with zipfile.ZipFile(path) as archive:
        names = sorted(name for name in archive.namelist() if name.endswith(".npz"))
        assert len(names) == 6
        for frame in (0, 5):
            with archive.open(names[frame]) as file:
                labels = np.load(file)["label"]
            assert int((labels == 1).sum()) == painted(server, frame, 1) > 20
    desk.press("ArrowRight")
    desk.until(f"pb.shown().frame === 1 && pb.labels()[1] === {painted(server, 1, 1)}")
    desk.until("pb.state.timeline.value.rows.get(1)?.state[2] === 2")
    desk.press("Control+z")
    desk.until("!(1 in pb.labels(1))")
    desk.settled()
    assert [painted(server, frame, 1) for frame in range(1, 4)] == [0, 0, 0]
    assert painted(server, 0, 1) > 20


def command(desk: Desk, words: str) -> None:
    """Run the first command that everyday words find."""
    desk.press("Control+k")
    expect(desk.page.get_by_role("combobox", name="Search commands")).to_be_focused()
    desk.page.keyboard.type(words)
    desk.press("Enter")


def tab_to(desk: Desk, name: str) -> None:
    """Move the focus to a control by the Tab key."""
    for _ in range(60):
        if desk.page.evaluate(FOCUSED).startswith(name):
            return
        desk.press("Tab")
    raise AssertionError(f"no Tab leads to {name}, but to {desk.page.evaluate(FOCUSED)}")


FOCUSED = """(() => {
  const { ariaLabel, labels, textContent } = document.activeElement;
  return (ariaLabel ?? labels?.[0]?.querySelector('span')?.textContent ?? textContent).trim();
})()"""
"""Name of the control that has the focus."""


def test_keys_alone_import_paint_track_and_export(desk: Desk) -> None:
    desk.ask("(window.pointed = 0, addEventListener('pointerdown', () => (window.pointed += 1)))")
    with desk.page.expect_file_chooser() as chooser:
        command(desk, "upload")
    chooser.value.set_files([DATA / "0000.npz", DATA / "0001.npz"])
    desk.until("pb.state.importing.value?.busy === false")
    tab_to(desk, "Name")
    desk.press("Control+a")
    desk.page.keyboard.type("walk")
    desk.press("Tab")
    desk.until("pb.state.importing.value.busy === false")
    tab_to(desk, "Import")
    desk.press("Enter")
    desk.until("pb.state.sequences.value.some((recording) => recording.name === 'walk')")
    desk.until("pb.state.jobs.value.every((job) => job.kind !== 'import' || job.state === 'done')")
    if desk.ask("pb.state.sequence.value.name") != "walk":
        command(desk, "open walk")
    desk.until("pb.state.sequence.value?.name === 'walk' && pb.state.sequence.value.frames === 2")
    desk.ready()
    desk.press("n")
    desk.until("document.activeElement.tagName === 'INPUT'")
    desk.page.keyboard.type("person")
    desk.press("Enter")
    desk.until("pb.state.palette.value[0]?.name === 'person' && pb.state.activeLabel.value === 1")
    desk.press("b")
    desk.press("0")
    desk.settled()
    painted_points = desk.until("pb.labels()[1]")
    assert painted_points > 5
    command(desk, "propagate")
    tab_to(desk, "Track 1 label")
    desk.press("Enter")
    desk.until("pb.state.jobs.value.some((j) => j.kind === 'tracking' && j.state === 'done')", 90)
    command(desk, "download")
    expect(desk.page.get_by_role("button", name="NPZ", exact=True)).to_be_visible()
    tab_to(desk, "NPZ")
    with desk.page.expect_download() as started:
        desk.press("Enter")
    with zipfile.ZipFile(started.value.path()) as archive:
        names = sorted(name for name in archive.namelist() if name.endswith(".npz"))
        assert len(names) == 2
        with archive.open(names[0]) as file:
            assert int((np.load(file)["label"] == 1).sum()) == painted_points
    assert desk.ask("window.pointed") == 0


def test_exports_with_a_split(desk: Desk) -> None:
    desk.page.get_by_role("button", name="Export").click()
    desk.page.get_by_label("Validation").select_option("all of these frames")
    with desk.page.expect_download() as started:
        desk.page.get_by_role("button", name="Pointcept").click()
    with zipfile.ZipFile(started.value.path()) as archive:
        splits = {name.split("/")[-3] for name in archive.namelist() if name.endswith("coord.npy")}
    assert splits == {"val"}
