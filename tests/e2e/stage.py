"""The stage with small cameras, for the page's tests."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from pointbrush.frame import DepthCamera
from pointbrush.samples.stage import Stage, StageOptions
from pointbrush.sequences import RecordingInfo, import_frames
from tests.e2e.server import complete

CAMERA = DepthCamera(width=224, height=186, fx=160.0, fy=160.0, cx=111.5, cy=90.0)
FRAMES = (0, 12)
STAGE = Stage(201, FRAMES[-1] + 1, StageOptions(3, 0.02, 2.0), camera=CAMERA)
"""Its mounts are wrong by 2 cm and 2 degrees."""
FRAME = STAGE.frame(0)
TRUTH: NDArray[np.uint16] = STAGE.truth[0]
PERSON = next(label.id for label in STAGE.labels if label.category == "person")


def make_workspace(factory: pytest.TempPathFactory) -> Path:
    """Return a workspace folder with the stage, to be copied."""
    folder = factory.mktemp("stage") / "workspace"
    (folder / "sequences").mkdir(parents=True)
    info = RecordingInfo("stage", "Stage", 30.0)
    frames = (STAGE.frame(i) for i in FRAMES)
    import_frames(frames, folder / "sequences" / "stage", info)
    complete(folder)
    return folder
