"""Take the picture of several sensors anew, on the stage; ``docs/pictures.py`` runs it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from playwright.sync_api import Browser

from pointbrush.samples.stage import Stage, StageOptions
from pointbrush.sequences import RecordingInfo, import_frames
from tests.e2e.desk import launch
from tests.e2e.server import LiveServer

SIZE = (1440, 810)
"""Window, pixels."""


def take(browser: Browser, folder: Path, save: Callable[..., None]) -> None:
    """Show the list of sensors, and points in the colours of their sensors."""
    workspace = folder / "stage"
    (workspace / "sequences").mkdir(parents=True)
    stage = Stage(0, 1, StageOptions())
    target = workspace / "sequences" / "stage"
    import_frames(stage.frames, target, RecordingInfo("stage", "Stage", 30.0))
    server = LiveServer(workspace)
    server.start()
    try:
        server.create_label("stage", "person", "#ff5d5d")
        desk = launch(browser, server.page_url, *SIZE, drawn=True)
        desk.ready()
        desk.page.get_by_role("button", name="Sensors", exact=True).click()
        desk.page.get_by_role("checkbox", name="Colour by sensor").check()
        desk.page.mouse.move(0, SIZE[1] / 2)  # without the button's tip
        seen = desk.ask("pb.counters().pictures")
        desk.ask("pb.engine.viewer.invalidate()")
        desk.until(f"pb.counters().pictures > {seen}")
        save(desk, "desk-sensors")
        desk.close()
    finally:
        server.stop()
