"""An octree scan: opens coarse, sharpens where one looks, is painted at full resolution."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import laspy
import numpy as np
import pytest
from numpy.typing import NDArray
from playwright.sync_api import Browser, Route, expect

from pointbrush.sequences import importer
from pointbrush.work.folder_store import FolderTarget
from pointbrush.work.imports import importing
from pointbrush.work.imports.requests import ImportRequest
from tests.e2e.desk import Desk, launch
from tests.e2e.headset import Headset, wear
from tests.e2e.server import LiveServer

POINTS = 1_500_000
SIDE = 120.0
SHIFT = np.array([448_260.0, 5_411_930.0, 310.0])
BUDGET = 700_000
"""Points that the page keeps without a GPU; a quarter more may stay until they are in the way."""
SEQUENCE = "scan"
RADIUS = 1.0
PIECES = "pb.engine.playback.frame.pieces"
WISH = f"[...pb.engine.detail.asked].every((i) => {PIECES}.some((piece) => piece.index === i))"
SPY = """() => {
  window.labelWrites = [];
  const write = WebGL2RenderingContext.prototype.bufferSubData;
  WebGL2RenderingContext.prototype.bufferSubData = function (...given) {
    if (given[2] instanceof Uint16Array) window.labelWrites.push(given[4]);
    return write.apply(this, given);
  };
}
"""


def hills() -> NDArray[np.float64]:
    """(POINTS, 3) a rolling field, denser in its middle, metres."""
    rng = np.random.default_rng(5)
    spread = np.where(rng.random(POINTS) < 0.5, SIDE / 2, SIDE / 8)
    xyz = np.zeros((POINTS, 3))
    xyz[:, :2] = rng.uniform(-1, 1, (POINTS, 2)) * spread[:, None]
    xyz[:, 2] = np.sin(xyz[:, 0] / 9) + np.cos(xyz[:, 1] / 7) + rng.normal(0, 0.01, POINTS)
    return xyz


class Silent:
    """A job's channel that nobody listens to."""

    def progress(self, fraction: float, message: str) -> None:
        """Nobody asked."""

    def item(self, value: object) -> None:
        """Nobody asked."""


@pytest.fixture(scope="module")
def scan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A workspace with the LAS file imported as an octree."""
    folder = tmp_path_factory.mktemp("large")
    header = laspy.LasHeader(point_format=2, version="1.2")
    header.scales, header.offsets = np.full(3, 0.001), np.floor(SHIFT)
    rows = laspy.ScaleAwarePointRecord.zeros(POINTS, header=header)
    local = hills()
    rows.x, rows.y, rows.z = (local + SHIFT).T
    shade = 32_000 + 20_000 * np.sin(local * [0.7, 0.9, 2.3])
    rows.red, rows.green, rows.blue = shade.astype(np.uint16).T
    with laspy.open(folder / "scan.las", "w", header=header) as writer:
        writer.write_points(rows)
    target = folder / "workspace" / "sequences" / SEQUENCE
    target.parent.mkdir(parents=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(importer, "LARGE_POINTS", 200_000)
        patch.setattr(importing, "LARGE_POINTS", 200_000)
        request = ImportRequest((folder / "scan.las",))
        importing.ImportWork(request, FolderTarget(target), SEQUENCE)(Silent())
    return folder / "workspace"


@pytest.fixture
def large(scan: Path, browser: Browser) -> Iterator[tuple[Desk, LiveServer]]:
    live = LiveServer(scan)
    live.start()
    live.create_label(SEQUENCE, "mound", "#ff5d5d")
    desk = launch(browser, live.page_url)
    yield desk, live
    desk.close()
    live.stop()
    assert desk.complaints == []


@pytest.fixture
def worn(scan: Path, tmp_path: Path, browser: Browser) -> Iterator[tuple[Headset, LiveServer]]:
    """A headset on a page with a copy of the scan that nobody has painted yet."""
    workspace = tmp_path / "workspace"
    shutil.copytree(scan / "sequences", workspace / "sequences")
    live = LiveServer(workspace)
    live.start()
    live.create_label(SEQUENCE, "mound", "#ff5d5d")
    headset = wear(browser, live.page_url)
    yield headset, live
    headset.close()
    live.stop()
    assert headset.complaints == []


def settled(desk: Desk) -> int:
    """Wait until the page has chosen anew and has all that it chose; returns how many points."""
    desk.until("window.__pointbrush && pb.shown().drawn > 0 && pb.engine.detail.nodes.length > 0")
    for _ in range(2):
        before = desk.ask("pb.engine.detail.next")
        desk.until(f"pb.engine.detail.next > {before} && {WISH}")
    points: int = desk.ask("pb.shown().points")
    return points


def finest(desk: Desk) -> int:
    level: int = desk.ask(f"Math.max(...{PIECES}.map((piece) => piece.level))")
    return level


def stand(desk: Desk, eye: list[float], target: list[float]) -> None:
    """Look from a point to another, in the scan's own metres."""
    at = [room(desk, point) for point in (eye, target)]
    desk.ask(f"pb.look({at[0]}, {at[1]})")


def room(desk: Desk, local: list[float]) -> list[float]:
    x, y, z = np.array(local) + SHIFT
    place: list[float] = desk.ask(
        f"""(() => {{
          const [sx, sy, sz] = pb.state.sequence.value.shift, {{ viewer }} = pb.engine;
          const at = viewer.camera.position.clone().set({x} - sx, {y} - sy, {z} - sz);
          return at.applyMatrix4(viewer.room.matrixWorld).toArray();
        }})()"""
    )
    return place


def test_a_large_scan_sharpens_where_one_looks_and_is_painted_whole(
    large: tuple[Desk, LiveServer],
) -> None:
    desk, live = large
    assert desk.until("window.__pointbrush && pb.shown().total") == POINTS
    overview = settled(desk)
    assert 0.5 * BUDGET < overview <= 1.25 * BUDGET
    coarse = finest(desk)

    # Near the ground in the middle: finer chunks come, others make room, none comes twice.
    ground = [0.0, 0.0, 1.0]
    stand(desk, [0.0, -9.0, 4.0], ground)
    desk.until(f"Math.max(...{PIECES}.map((piece) => piece.level)) > {coarse}")
    near = settled(desk)
    assert near <= 1.25 * BUDGET
    counters = desk.ask("pb.counters()")
    assert counters["cachedBytes"] < 3 * 12 * near, "dropped chunks give their memory back"
    assert len(set(desk.ask(f"{PIECES}.map((piece) => piece.index)"))) == desk.ask(
        f"{PIECES}.length"
    )

    # A ball: the server paints all of its points, also those that are not on the page.
    desk.until("pb.state.activeLabel.value === 1")
    desk.ask(f"(pb.state.brush.value = {{ ...pb.state.brush.value, radius: {RADIUS} }})")
    desk.page.evaluate(SPY)
    desk.paint([(np.array(ground) + SHIFT).tolist()])
    desk.settled()
    label = live.annotation(SEQUENCE, 0)
    xyz = live.points(SEQUENCE, 0)
    away = np.linalg.norm(xyz - xyz[label == 1].mean(axis=0), axis=1)
    assert (label[away < 0.8 * RADIUS] == 1).all()
    assert (label[away > 1.3 * RADIUS] == 0).all()
    shown = desk.until("pb.labels()[1]")
    painted = int((label == 1).sum())
    assert 0 < shown <= painted
    touched = desk.ask("new Set(window.labelWrites).size")
    assert 0 < touched < desk.ask(f"{PIECES}.length"), "only chunks that the ball meets go over"

    # All of the place's points are there once one is near enough, with their labels.
    stand(desk, [0.0, -1.5, 2.5], ground)
    desk.until(f"pb.labels()[1] === {painted}")


def walk(headset: Headset, place: list[float]) -> None:
    """Stand a step before a place (source coordinates), looking over it."""
    x, y, z = headset.ask(f"hs.place({place})")
    headset.ask(f"device.position.set({x}, {y + 1.6}, {z + 1.0})")
    headset.frames()


def finest_at(place: list[float]) -> str:
    """The level of the finest chunk that is here of a place (source coordinates)."""
    return f"""Math.max(...{PIECES}.filter((piece) => {place}.every((at, axis) => {{
      const local = at - pb.state.sequence.value.shift[axis];
      return axis === 2 || (piece.lo[axis] <= local && local <= piece.hi[axis]);
    }})).map((piece) => piece.level))"""


def test_in_the_headset_it_sharpens_where_one_walks_and_is_painted_whole(
    worn: tuple[Headset, LiveServer],
) -> None:
    headset, live = worn
    headset.until("window.__pointbrush && pb.engine.detail.nodes.length > 0")
    headset.ask("pb.setAdaptive(false)")
    headset.enter()
    # Somebody with long legs walks to a corner, and from there to the middle.
    ground = (np.array([0.0, 0.0, 1.0]) + SHIFT).tolist()
    walk(headset, (np.array([-50.0, -50.0, 1.0]) + SHIFT).tolist())
    settled(headset)
    coarse = headset.ask(finest_at(ground))
    walk(headset, ground)
    headset.until(f"{finest_at(ground)} > {coarse}")
    assert settled(headset) <= 1.25 * BUDGET
    headset.until("pb.state.activeLabel.value === 1")
    headset.set_radius(RADIUS)
    headset.paint([ground])
    headset.settled()
    label = live.annotation(SEQUENCE, 0)
    away = np.linalg.norm(live.points(SEQUENCE, 0) - np.array(ground), axis=1)
    assert (label[away < 0.9 * RADIUS] == 1).all()
    assert (label[away > 1.1 * RADIUS] == 0).all()
    headset.until(f"pb.labels()[1] === {int((label == 1).sum())}")


def test_what_is_still_missing_is_asked_for_again_after_the_link_was_lost(
    large: tuple[Desk, LiveServer],
) -> None:
    desk, live = large
    overview = settled(desk)
    live.kill()
    desk.until("pb.state.connection.value.state !== 'online'")
    coarse = finest(desk)
    stand(desk, [0.0, -5.0, 4.0], [0.0, 0.0, 1.0])
    desk.pictures()
    live.start()
    desk.until(f"Math.max(...{PIECES}.map((piece) => piece.level)) > {coarse}")
    assert settled(desk) > 0.3 * overview
    # The browser itself complains of the connections that were refused.
    desk.complaints.clear()


def test_what_one_looks_at_is_predicted(large: tuple[Desk, LiveServer]) -> None:
    desk, _ = large
    known = {"id": "hills", "name": "hills", "classes": ["mound"], "score": None, "above": 0.5}
    known |= {"taught_by": {}, "examples": {}, "held_out": {}}
    asked: list[list[float]] = []

    def predict(route: Route) -> None:
        asked.append(route.request.post_data_json["place"])
        head = b'{"points": 3, "part": true, "confused": [], "doubts": [0]}'
        head += b" " * (-len(head) % 4)
        numbers, rest = np.array([0, 1, 700], "<u4").tobytes(), bytes([1, 1, 1, 200, 200, 200])
        route.fulfill(body=len(head).to_bytes(4, "little") + head + numbers + rest)

    desk.page.route("**/classifiers", lambda route: route.fulfill(json=[known]))
    desk.page.route("**/prediction?*", predict)
    desk.until("pb?.state.sequence.value")
    stand(desk, [0.0, -12.0, 6.0], [0.0, 0.0, 1.0])
    desk.page.get_by_role("button", name="By example").click()
    expect(desk.page.get_by_text("near the centre of the view")).to_be_visible()
    assert desk.ask("[...pb.engine.frame().predicted.numbers]") == [0, 1, 700]
    assert np.linalg.norm(np.array(asked[0]) - SHIFT) < SIDE / 4
