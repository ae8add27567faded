"""Doubts about a real aerial survey: most are of one class, and answers make the map better."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import laspy
import numpy as np
from numpy.typing import NDArray

from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.workspace import Workspace
from tests.serving import settings_in

CLASSES = {"ground": (2,), "vegetation": (3, 4, 5), "building": (6,)}
"""Codes of ASPRS of each class."""
QUESTIONS = 12
CLEAR = 2 / 3
"""Share of a piece from which on it is of one class."""
RADIUS = 3.0
"""Metres of a stroke."""


def tile(shared: Path) -> tuple[PointFrame, NDArray[np.int64]]:
    """Return a sixth of a square kilometre, and the class of each point from 1, 0 for none."""
    file = laspy.read(shared / "realdata" / "aerial_ign" / "tile_2021.laz")
    xyz = np.stack([file.x, file.y, file.z], axis=1)
    xyz -= xyz.min(axis=0)
    part = (xyz[:, 0] < np.ptp(xyz[:, 0]) / 3) & (xyz[:, 1] < np.ptp(xyz[:, 1]) / 2)
    code = np.asarray(file.classification)[part]
    truth = np.zeros(len(code), np.int64)
    for kind, codes in enumerate(CLASSES.values(), 1):
        truth[np.isin(code, codes)] = kind
    strength = np.asarray(file.intensity, np.float32)[part]
    return PointFrame(xyz=xyz[part], intensity=strength), truth


def test_most_doubts_are_of_one_class_and_answers_help(tmp_path: Path, shared: Path) -> None:
    frame, truth = tile(shared)
    settings = settings_in(tmp_path)
    folder = Path(settings.workspace) / "sequences" / "tile"
    folder.parent.mkdir(parents=True)
    import_frames([frame], folder, RecordingInfo("tile", "tile", 1.0, up="z"))
    rng = np.random.default_rng(0)
    with closing(Workspace(settings)) as workspace:
        stored = workspace.recording("tile")[0]
        classifiers = workspace.classifiers
        ids = [workspace.labels.create_label("tile", "me", name=name).id for name in CLASSES]
        for kind, label in enumerate(ids, 1):
            place = frame.xyz[rng.choice(np.flatnonzero(truth == kind))]
            brush = {"shape": "sphere", "radius": RADIUS, "label": label}
            samples = {"samples": [{"origin": place.tolist()}]}
            workspace.strokes.apply("tile", 0, brush | samples, "me")
        made = classifiers.create("tiles", ["tile"])

        def right() -> float:
            kind = stored.to_source(classifiers.predict(made.id, "tile", 0).kind)
            return float((kind == truth)[truth > 0].mean())

        before, unclear, asked = right(), 0, np.zeros(len(truth), bool)
        for _ in range(QUESTIONS):
            place = classifiers.doubt(made.id, "tile", most=1)[0]
            numbers = np.concatenate([np.arange(first, first + n) for first, n in place.runs])
            piece = stored.source_index[numbers]
            assert len(piece) >= classifiers.options.doubt.fewest
            assert not asked[piece].any()
            asked[piece] = True
            counts = np.bincount(truth[piece], minlength=4)
            kind = int(counts.argmax())
            if kind and counts[kind] >= CLEAR * len(piece):
                classifiers.answer(made.id, "tile", 0, place.centre, ids[kind - 1], author="me")
            else:
                classifiers.ignore(made.id, "tile", 0, place.centre, place.radius)
                unclear += 1
        assert unclear <= QUESTIONS / 3
        assert right() > before
