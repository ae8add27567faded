"""One click, one object: at the desk, alone and beside somebody, on small and large frames."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
from playwright.sync_api import Browser

from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from tests.e2e.desk import Desk, launch
from tests.e2e.geometry import overlaps
from tests.e2e.recording import PERSON, PIN, SEQUENCE, Truth, name_person, painted
from tests.e2e.server import LiveServer
from tests.e2e.test_accessibility import faults
from tests.waiting import eventually

READY = "pb.state.object.value?.ready && pb.state.object.value.levels > 1"


def hover(desk: Desk, point: list[float], until: str = READY) -> None:
    desk.page.mouse.move(*desk.place(point))
    desk.until(until)


def with_object_tool(desk: Desk, server: LiveServer) -> Desk:
    name_person(desk, server)
    desk.press("j")
    desk.page.get_by_role("radio", name="Object").wait_for()
    return desk


def overlap(server: LiveServer, truth: list[int]) -> float:
    with np.load(Path(__file__).parents[2] / "data" / "juggling" / "0000.npz") as arrays:
        wanted = np.isin(arrays["truth"], truth)
    taken = server.annotation(SEQUENCE, 0) == 1
    return float((wanted & taken).sum() / (wanted | taken).sum())


def test_hover_shows_levels_a_click_takes_and_one_undo_takes_back(
    desk: Desk, server: LiveServer, truth: Truth
) -> None:
    with_object_tool(desk, server)
    hover(desk, truth(0, PERSON))
    shown = desk.ask("pb.state.object.value")
    assert 2 <= shown["levels"] <= 6
    assert desk.labels().get(65534) == shown["points"]
    # Told from surroundings of its colour by an edge, which goes with it.
    assert desk.ask("pb.engine.viewer.uniforms.settings.value[27]") == 1
    assert faults(desk.page, "lit object") == []
    for _ in range(shown["level"]):
        desk.press("-")
    smallest = desk.ask("pb.state.object.value.points")
    desk.page.mouse.wheel(0, -100)
    desk.until("pb.state.object.value.level === 1")
    assert desk.ask("pb.state.object.value.points") > smallest
    for level in range(1, shown["level"]):
        desk.press("+")
        desk.until(f"pb.state.object.value.level === {level + 1}")
    desk.page.mouse.down()
    desk.page.mouse.up()
    desk.until("pb.state.object.value.taken")
    desk.settled()
    taken = painted(server, 0)
    assert taken == desk.ask("pb.state.object.value.points")
    assert overlap(server, [PERSON]) > 0.5
    desk.press("Escape")
    desk.until("pb.state.object.value === null || !pb.state.object.value.taken")
    desk.press("Control+z")
    desk.until("(pb.labels()[1] ?? 0) === 0")
    desk.settled()
    assert painted(server, 0) == 0


def test_while_its_loops_compile_the_tool_says_so_and_the_wheel_does_not_zoom(
    browser: Browser, template: Path, tmp_path: Path, truth: Truth
) -> None:
    shutil.copytree(template, tmp_path / "workspace")
    server = LiveServer(tmp_path / "workspace", NUMBA_CACHE_DIR=str(tmp_path / "loops"))
    server.start()
    try:
        desk = launch(browser, server.page_url)
        with_object_tool(desk, server)
        desk.page.get_by_text(re.compile(r"Preparing the object tool: \d+ %")).wait_for()
        desk.until("pb.state.compiling.value.get('objects') > 0")
        eye = "pb.engine.viewer.camera.position.toArray()"
        before = desk.ask(eye)
        desk.page.mouse.move(*desk.place(truth(0, PERSON)))
        desk.page.mouse.wheel(0, -300)
        desk.pictures()
        assert desk.ask(eye) == before
        assert desk.ask("pb.state.compiling.value.has('objects')")
        desk.page.keyboard.down("Control")
        desk.page.mouse.wheel(0, -300)
        desk.page.keyboard.up("Control")
        desk.until(f"{eye}.some((metres, axis) => metres !== {before}[axis])")
        desk.close()
    finally:
        server.stop()


def test_further_clicks_add_and_remove_and_stay_one_undo(
    desk: Desk, server: LiveServer, truth: Truth
) -> None:
    with_object_tool(desk, server)
    hover(desk, truth(0, PERSON))
    desk.page.mouse.click(*desk.place(truth(0, PERSON)))
    desk.until("pb.state.object.value.taken")
    desk.settled()
    first = painted(server, 0)
    pin = truth(0, PIN)
    desk.page.mouse.click(*desk.place(pin))
    index = int(np.linalg.norm(server.points(SEQUENCE, 0) - pin, axis=1).argmin())
    eventually(lambda: server.annotation(SEQUENCE, 0)[index] == 1)
    assert painted(server, 0) > first
    desk.settled()
    desk.page.keyboard.down("Alt")
    desk.page.mouse.click(*desk.place(pin))
    desk.page.keyboard.up("Alt")
    eventually(lambda: server.annotation(SEQUENCE, 0)[index] == 0)
    assert painted(server, 0) > 0
    desk.settled()
    desk.press("Control+z")
    desk.until("(pb.labels()[1] ?? 0) === 0")


def test_the_eraser_removes_from_what_was_taken(
    desk: Desk, server: LiveServer, truth: Truth
) -> None:
    with_object_tool(desk, server)
    places = [truth(0, PERSON), truth(0, PIN)]
    points = server.points(SEQUENCE, 0)
    clicked = [int(np.linalg.norm(points - at, axis=1).argmin()) for at in places]

    def stored() -> list[int]:
        return [int(label) for label in server.annotation(SEQUENCE, 0)[clicked]]

    for place, index in zip(places, (0, 1), strict=True):
        hover(desk, place, "pb.state.object.value?.ready")
        desk.page.mouse.click(*desk.place(place))
        eventually(lambda index=index: stored()[: index + 1] == [1] * (index + 1))
    desk.press("c")
    desk.page.mouse.click(*desk.place(places[1]))
    eventually(lambda: stored() == [1, 0])


def test_a_stroke_is_completed_to_the_object(desk: Desk, server: LiveServer, truth: Truth) -> None:
    with_object_tool(desk, server)
    hover(desk, truth(0, PERSON))
    desk.press("b")
    x, y, z = truth(0, PERSON)
    desk.paint([[x, y, z], [x, y + 0.15, z], [x, y + 0.3, z]])
    desk.until("pb.state.object.value?.completes")
    desk.settled()
    stroke = painted(server, 0)
    desk.page.get_by_text("Complete to object").wait_for()
    desk.page.get_by_role("button", name="By example").click()
    desk.page.get_by_role("button", name="Learn from painted points").wait_for()
    assert desk.page.locator(".bar .primary").count() == 1
    assert faults(desk.page, "an object to complete") == []
    for width in (1280, 900):
        desk.page.set_viewport_size({"width": width, "height": 720})
        assert overlaps(desk.page, ".bar, .readout > *, .toast, .views, .signs") == []
    desk.page.set_viewport_size({"width": 1280, "height": 720})
    desk.page.get_by_role("button", name="By example").click()
    desk.page.locator("#view").focus()
    desk.press("Tab")
    desk.until("pb.state.object.value === null || !pb.state.object.value.completes")
    eventually(lambda: painted(server, 0) > stroke)
    assert overlap(server, [PERSON]) > 0.5
    desk.settled()
    desk.press("Escape")
    desk.press("Control+z")
    desk.until(f"(pb.labels()[1] ?? 0) < {stroke + 1}")


def test_what_somebody_else_painted_meanwhile_is_left_alone(
    open_desk: Callable[..., Desk], server: LiveServer, truth: Truth
) -> None:
    desk, other = open_desk(), open_desk()
    with_object_tool(desk, server)
    blue = server.create_label(SEQUENCE, "blue", "#5d8bff")
    hover(desk, truth(0, PERSON))
    largest = desk.ask("pb.state.object.value.levels") - 1
    for _ in range(largest):
        desk.press("+")
    desk.until(f"pb.state.object.value.level === {largest}")
    shown = desk.ask("pb.state.object.value.points")
    other.press(str(blue))
    other.until(f"pb.state.activeLabel.value === {blue}")
    other.paint([truth(0, PERSON)])
    other.settled()
    theirs = painted(server, 0, blue)
    assert theirs > 0
    desk.page.mouse.down()
    desk.page.mouse.up()
    desk.until("pb.state.object.value?.taken")
    desk.settled()
    desk.until("(pb.labels()[1] ?? 0) > 0")
    assert painted(server, 0, blue) == theirs
    assert 0 < painted(server, 0) < shown


def test_fill_and_ground_take_what_was_lit(desk: Desk, server: LiveServer, truth: Truth) -> None:
    name_person(desk, server)
    x, _, z = truth(0, PERSON)
    floor = server.points(SEQUENCE, 0)
    low = floor[np.abs(floor[:, 0] - x - 0.6) + np.abs(floor[:, 2] - z) < 0.4]
    spot = [float(v) for v in low[np.argmax(low[:, 1])]]
    for key in ("g", "k"):
        desk.press(key)
        desk.page.mouse.move(*desk.place(spot))
        desk.until("(pb.labels()[65534] ?? 0) > 0")
        desk.pictures()
        lit = desk.labels()[65534]
        desk.page.mouse.down()
        desk.page.mouse.up()
        desk.settled()
        desk.until("(pb.labels()[1] ?? 0) > 0")
        assert painted(server, 0) == lit
        desk.press("Control+z")
        desk.until("(pb.labels()[1] ?? 0) === 0")


def odd_workspace(folder: Path) -> Path:
    """Frames of no points, of one, and a ball over a floor of 5 M points."""
    rng = np.random.default_rng(3)
    floor = rng.uniform(-4, 4, (4_700_000, 3)) * [1, 0, 1]
    way = rng.normal(size=(300_000, 3))
    ball = 0.4 * way / np.linalg.norm(way, axis=1, keepdims=True) + [0, 0.6, 0]
    xyz = np.concatenate([floor, ball]).astype(np.float32)
    frames = [xyz, np.zeros((0, 3), np.float32), np.full((1, 3), 0.5, np.float32)]
    grey = [np.full((len(frame), 3), 128, np.uint8) for frame in frames]
    import_frames(
        (PointFrame(frame, colour) for frame, colour in zip(frames, grey, strict=True)),
        folder / "sequences" / "odd",
        RecordingInfo("odd", "Odd", 10.0),
    )
    return folder


def test_frames_of_no_point_of_one_and_of_five_million(browser: Browser, tmp_path: Path) -> None:
    server = LiveServer(odd_workspace(tmp_path / "workspace"))
    server.start()
    desk = launch(browser, server.page_url, drawn=True)  # or all five million would be sent
    try:
        label = server.create_label("odd", "ball", "#ff5d5d")
        desk.until(f"window.__pointbrush && pb.state.activeLabel.value === {label}")
        desk.press("j")
        desk.until("pb.shown().total > 4000000 && pb.shown().drawn > 10000")
        hover(desk, [0.0, 1.0, 0.0], "pb.state.object.value?.levels > 0")
        # The smallest part comes first while the frame is not prepared.
        for _ in range(6):
            desk.press("+")
        desk.page.mouse.down()
        desk.page.mouse.up()
        desk.until("pb.state.object.value?.taken")
        desk.settled()
        points = server.points("odd", 0)
        taken = server.annotation("odd", 0) == label
        on_ball = np.abs(np.linalg.norm(points - [0, 0.6, 0], axis=1) - 0.4) < 0.01
        # Until the frame is prepared, of what is near the click.
        assert (taken & on_ball).sum() > max(50_000, 0.8 * taken.sum())
        desk.press("ArrowRight")
        desk.until("pb.shown().frame === 1")
        desk.page.mouse.move(400, 400)
        desk.page.mouse.click(420, 400)
        desk.press("ArrowRight")
        desk.until("pb.shown().frame === 2 && pb.shown().total === 1")
        desk.page.mouse.click(*desk.place([0.5, 0.5, 0.5]))
        desk.until("pb.state.object.value?.taken")
        desk.settled()
        assert server.annotation("odd", 2).tolist() == [label]
        assert desk.complaints == []
    finally:
        desk.close()
        server.stop()
