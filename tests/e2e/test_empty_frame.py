"""A moment without points."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from tests.e2e.desk import Desk
from tests.serving import surface


@pytest.fixture(scope="session")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A workspace with a recording of three frames, of which the second is empty."""
    folder = tmp_path_factory.mktemp("template") / "workspace"
    nothing = PointFrame(np.empty((0, 3), np.float32), np.empty((0, 3), np.uint8))
    import_frames(
        iter([surface(3_000, 0), nothing, surface(3_000, 2)]),
        folder / "sequences" / "gap",
        RecordingInfo("gap", "Gap", 10.0),
    )
    return folder


def test_an_empty_frame_shows_as_empty(open_desk: Callable[..., Desk]) -> None:
    desk = open_desk()
    desk.press("ArrowRight")
    desk.until("pb.shown().frame === 1 && pb.state.shown.value.total === 0")
    desk.page.get_by_text("This frame has no points").wait_for()
    desk.press("ArrowRight")
    desk.until("pb.shown().frame === 2 && pb.shown().points === pb.shown().total")
    assert not desk.page.get_by_text("This frame has no points").is_visible()
