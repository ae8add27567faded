"""The plan of a recording: it shows a room below its ceiling, and all of everything else."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser

from pointbrush.formats import read
from pointbrush.frame import PointFrame
from pointbrush.samples.aerial import BUILDING, aerial_tile
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush_samples.scanning import room_scan
from pointbrush_samples.street import street
from tests.conftest import SHARED
from tests.e2e.desk import Desk, launch
from tests.e2e.server import LiveServer

TILE = aerial_tile(0)
ROOMS = ("room",)
REAL = {"kinect": "pcl_kinect3", "table": "osd_tables"}
"""Recordings of a folder beside the checkout: they are looked at where it is there."""
ROOF = 2.0
"""Metres round the middle of a roof that are roof."""


def recordings() -> Iterable[tuple[str, Iterable[PointFrame]]]:
    yield "aerial", [replace(TILE, label=None)]
    yield "street", [street(0).frame]
    yield "room", [room_scan(0, 60_000).frame]
    for name, folder in REAL.items():
        if (path := SHARED / "realdata" / folder).is_dir():
            yield name, islice(read(path), 1)


@pytest.fixture(scope="session")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("template") / "workspace"
    (folder / "sequences").mkdir(parents=True)
    for name, frames in recordings():
        target = folder / "sequences" / name
        import_frames(frames, target, RecordingInfo(name, name, 1.0))
    return folder


def show(desk: Desk, name: str) -> None:
    """Open a recording and look at its plan."""
    desk.ask(f"void pb.engine.openSequence({name!r})")
    desk.until(f"pb.state.sequence.value?.id === {name!r} && pb.state.framed.value")
    desk.until("pb.shown().total > 0 && pb.shown().drawn === pb.shown().total")
    desk.press("t")
    desk.until("pb.engine.viewer.camera.orthographic && !pb.engine.camera.flying")


def roof() -> list[float]:
    """The middle of a roof, source coordinates."""
    assert TILE.label is not None
    top = TILE.xyz[TILE.label == BUILDING]
    for point in top[np.argsort(-top[:, 2])]:
        near = np.linalg.norm(TILE.xyz[:, :2] - point[:2], axis=1) < ROOF
        if near.sum() > 30 and (TILE.label[near] == BUILDING).all():
            return [float(value) for value in point]
    raise AssertionError("no roof")


def test_a_plan_hides_a_ceiling_and_no_roof(browser: Browser, server: LiveServer) -> None:
    server.create_label("aerial", "roof", "#d0503c")
    desk = launch(browser, f"{server.page_url}&sequence=aerial")
    desk.ready()
    names = [each["id"] for each in server.request("GET", "sequences").json()]
    assert {"aerial", "street", *ROOMS} <= set(names)
    for name in names:
        show(desk, name)
        assert desk.ask("pb.engine.cut !== null") == (name in ROOMS), name
        assert desk.page.get_by_text("Slab active").count() == int(name in ROOMS)

    show(desk, "aerial")
    desk.until("pb.state.activeLabel.value === 1")
    x, y, z = roof()
    desk.paint([[x, y, z], [x + 0.3, y, z]])
    desk.settled()
    labels = server.annotation("aerial", 0)
    assert TILE.label is not None
    assert (labels == 1).sum() > 10
    assert (TILE.label[labels == 1] == BUILDING).all()
    desk.close()
    assert desk.complaints == []
