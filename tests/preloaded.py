"""Modules and compiled loops that forked processes use, loaded at the import of this module.

A command or a worker that loads them itself takes a second before its work begins.
"""

from __future__ import annotations

import gc
import importlib
import pkgutil
import tempfile
from contextlib import suppress
from pathlib import Path

import numpy as np

import pointbrush
from pointbrush.samples import generate
from pointbrush.samples.generating import small_camera
from pointbrush.selection.objects import ObjectFrame, candidates, prepare
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.work.loops.compiling import are_compiled
from pointbrush.work.loops.steps import track
from tests.serving import surface

FRAMES, STEP = 2, 6
LEFT = (".__main__", ".migrations.", "pointbrush.review")
"""Parts of the names of modules that do something at import, or that few processes use."""


def import_everything() -> None:
    """Import the modules of pointbrush, also its late imports, and the client of S3."""
    for module in pkgutil.walk_packages(pointbrush.__path__, "pointbrush."):
        if not any(part in module.name for part in LEFT):
            with suppress(ImportError):
                importlib.import_module(module.name)
    with suppress(ImportError):
        importlib.import_module("s3fs")


def load_loops() -> None:
    """Load the loops of import, tracking and object selection by a short run of each."""
    with tempfile.TemporaryDirectory() as folder:
        frames = (surface(300, i) for i in range(FRAMES))
        import_frames(frames, Path(folder) / "wall", RecordingInfo("wall", "wall", 30.0))
    recording = generate("tabletop", 1, FRAMES)
    recording.camera = small_camera(recording.camera, STEP)
    made = recording.frame(0)
    track(recording, "auto")
    for sensor in ("lidar", "room"):
        state = prepare(ObjectFrame(made.xyz, made.rgb, viewpoint=None, sensor=sensor))
        candidates(state, made.xyz[:1].astype(np.float64))


import_everything()
if are_compiled():
    load_loops()
gc.collect()
# Otherwise a collection in a forked process copies the pages of all objects.
gc.freeze()
