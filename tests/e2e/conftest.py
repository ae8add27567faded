"""A workspace with the small recording of ``data/``, a server on it, and Chromium."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser, expect, sync_playwright

from pointbrush.formats import read
from pointbrush.sequences import RecordingInfo, import_frames
from tests.e2e.chromium import COMPOSED, EXECUTABLE, FLAGS
from tests.e2e.desk import Desk, launch
from tests.e2e.headset import QUEST, Headset, Wear, wear
from tests.e2e.recording import SEQUENCE, Truth
from tests.e2e.server import LiveServer, complete
from tests.waiting import PATIENCE

DATA = Path(__file__).parents[2] / "data" / "juggling"
PAGE = Path(__file__).parents[2] / "server" / "pointbrush" / "web" / "page" / "index.html"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.e2e)


@pytest.fixture(scope="session")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A workspace folder with the recording ``juggling``, to be copied."""
    assert PAGE.is_file(), "the page is not built: run `make page`"
    folder = tmp_path_factory.mktemp("template") / "workspace"
    (folder / "sequences").mkdir(parents=True)
    import_frames(
        read(DATA), folder / "sequences" / SEQUENCE, RecordingInfo(SEQUENCE, "Juggling", 30.0)
    )
    complete(folder)
    return folder


@pytest.fixture
def server(template: Path, tmp_path: Path) -> Iterator[LiveServer]:
    """A running server on a fresh copy of the recording."""
    workspace = tmp_path / "workspace"
    shutil.copytree(template, workspace)
    live = LiveServer(workspace)
    live.start()
    yield live
    live.stop()


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    if not Path(EXECUTABLE).exists():
        pytest.skip(f"no browser at {EXECUTABLE}")
    with sync_playwright() as playwright:
        expect.set_options(timeout=1e3 * PATIENCE)
        chromium = playwright.chromium.launch(executable_path=EXECUTABLE, args=[*FLAGS, COMPOSED])
        yield chromium
        chromium.close()


@pytest.fixture
def open_desk(
    browser: Browser, server: LiveServer, request: pytest.FixtureRequest
) -> Iterator[Callable[..., Desk]]:
    """Opens windows on the server; they must not have complained when the test ends."""
    desks: list[Desk] = []

    def open_one(**options: int) -> Desk:
        desk = launch(browser, server.page_url, **options)
        desks.append(desk)
        desk.ready()
        return desk

    yield open_one
    for number, desk in enumerate(desks):
        if request.session.testsfailed and not desk.page.is_closed():
            desk.screenshot(f"{request.node.name}-{number}")
        desk.close()
    assert [desk.complaints for desk in desks] == [[] for _ in desks]


@pytest.fixture
def desk(open_desk: Callable[..., Desk]) -> Desk:
    """A window with the recording on screen."""
    return open_desk()


@pytest.fixture
def palette() -> dict[str, str]:
    """Labels that the recording has when a headset goes in: name → colour."""
    return {"person": "#ff5d5d"}


@pytest.fixture
def headset(browser: Browser, server: LiveServer, palette: dict[str, str]) -> Iterator[Headset]:
    """Inside the recording, with the first label of the palette chosen."""
    for name, colour in palette.items():
        server.create_label(SEQUENCE, name, colour)
    worn = wear(browser, server.page_url)
    worn.ready()
    worn.until("pb.state.activeLabel.value === 1")
    worn.enter()
    yield worn
    worn.close()
    assert worn.complaints == []


@pytest.fixture
def put_on(browser: Browser, server: LiveServer) -> Iterator[Wear]:
    worn: list[Headset] = []

    def one(device: str = QUEST, haptics: str = "Quest Browser") -> Headset:
        headset = wear(browser, server.page_url, device, haptics=haptics)
        worn.append(headset)
        headset.ready()
        headset.enter()
        return headset

    server.create_label(SEQUENCE, "person", "#ff5d5d")
    yield one
    for headset in worn:
        headset.close()
        assert headset.complaints == []


@pytest.fixture(scope="session")
def truth() -> Truth:
    """The middle of a labelled object in a frame, source coordinates."""

    def middle(frame: int, label: int) -> list[float]:
        with np.load(DATA / f"{frame:04}.npz") as arrays:
            mine = arrays["xyz"][arrays["truth"] == label]
        center = mine.mean(axis=0)
        nearest = mine[np.linalg.norm(mine - center, axis=1).argmin()]
        return [float(value) for value in nearest]

    return middle
