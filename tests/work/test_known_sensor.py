"""What is known of a recording's sensor is found by the first run over it and kept for the next."""

from __future__ import annotations

import json
import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames, open_sequence
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences.check import verify
from pointbrush.tracking import METHODS, FrameResult, Seed, TrackOptions
from pointbrush.tracking.interface import KnownSensor
from pointbrush.work.tracking.sensor import sensor_of

SIZE = 96
BALL = 1


def room(eye: np.ndarray, ball: float, at: np.ndarray) -> tuple[PointFrame, np.ndarray]:
    """A wall with three pillars and a ball before it, from ``eye``; points are moved by ``at``."""
    down, across = np.indices((SIZE, SIZE)).reshape(2, -1)
    rays = np.stack([across - SIZE / 2 + 0.5, down - SIZE / 2 + 0.5, np.full(len(down), 90.0)], 1)
    rays /= 90.0
    depth = (3.0 - eye[2]) / np.ones(len(rays))
    for middle in (-0.9, 0.2, 0.8):
        front = 2.2 + 0.3 * middle - eye[2]
        x, y = (rays * front + eye)[:, :2].T
        depth[(np.abs(x - middle) < 0.12) & (y > middle / 3)] = front
    away = np.array([ball, 0.1, 1.8]) - eye
    along, square = rays @ away, (rays * rays).sum(axis=1)
    inside = along**2 - square * (away @ away - 0.2**2)
    hit = inside > 0
    depth[hit] = ((along - np.sqrt(np.maximum(inside, 0))) / square)[hit]
    xyz = rays * depth[:, None]
    grey = np.where(hit, 250, 60 + 60 * np.sin(9 * (xyz[:, 0] + eye[0])) * np.cos(7 * xyz[:, 1]))
    rgb = np.repeat(grey[:, None], 3, axis=1).astype(np.uint8)
    return PointFrame((xyz + at).astype(np.float32), rgb), hit


def recorded(
    folder: Path, eyes: Sequence[float], at: Sequence[float] = (0, 0, 0)
) -> tuple[Recording, Seed]:
    made = [
        room(np.array([eye, 0.0, 0.0]), 0.03 * number - 0.3, np.array(at))
        for number, eye in enumerate(eyes)
    ]
    import_frames((frame for frame, _ in made), folder / "room", RecordingInfo("room", "room", 30))
    recording = open_sequence(folder / "room")
    return recording, Seed(BALL, np.flatnonzero(made[0][1][recording[0].source_index]))


def run(recording: Recording, seed: Seed, known: KnownSensor) -> list[dict[int, list[int]]]:
    results: list[FrameResult] = list(
        METHODS["auto"]().track(
            recording.__getitem__,
            range(len(recording)),
            [seed],
            lambda _: None,
            TrackOptions(continue_lost=True, sensor=known),
        )
    )
    return [{n: points.tolist() for n, points in r.assignments.items()} for r in results]


def test_runs_over_a_camera_at_rest_share_what_is_known_of_it(tmp_path: Path) -> None:
    recording, seed = recorded(tmp_path, [0.0] * 6)
    found = sensor_of(recording)
    assert found == KnownSensor(at_rest=True)
    assert verify(recording.path) == []
    labels = run(recording, seed, found)
    assert all(labels[number].get(BALL) for number in range(1, 6))
    assert run(recording, seed, sensor_of(recording)) == labels
    assert run(recording, seed, KnownSensor()) == labels


def test_of_a_camera_that_moves_at_last_it_is_not_said_that_it_rests(tmp_path: Path) -> None:
    recording, _ = recorded(tmp_path, [0, 0, 0, 0, 0, 0.06, 0.12, 0.18])
    assert not sensor_of(recording).at_rest


def changed(path: Path, **fields: Any) -> None:
    path.write_text(json.dumps(json.loads(path.read_text()) | fields))


def test_facts_are_read_where_they_are_kept_and_found_anew_where_they_are_damaged(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    recording, _ = recorded(tmp_path, [0.0] * 3)
    path = recording.path / "sensor.json"
    found = sensor_of(recording)
    whole = path.read_bytes()
    changed(path, at_rest=False, place=[1, 2, 3])
    assert sensor_of(recording) == KnownSensor(place=(1.0, 2.0, 3.0))
    for spoil in (
        lambda: changed(path, identity="another"),
        lambda: changed(path, place=[1, 2]),
        lambda: path.write_bytes(whole[:20]),
    ):
        spoil()
        with caplog.at_level(logging.WARNING):
            assert sensor_of(recording) == found
        assert "found anew" in caplog.text
        caplog.clear()
        assert path.read_bytes() == whole
