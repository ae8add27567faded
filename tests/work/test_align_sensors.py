"""The sensors of a recording are aligned in a job, which can be undone."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pointbrush.cli import main
from pointbrush.client import Client, Recording
from pointbrush.errors import ConflictError
from pointbrush.frame import DepthCamera
from pointbrush.samples.stage import Stage, StageOptions
from pointbrush.sequences import RecordingInfo, import_frames
from tests.serving import TOKEN, Served, add_sequence, serving, settings_in

SEED = 201
"""A seed on which nothing was tuned."""
SMALL = DepthCamera(width=256, height=212, fx=182.7, fy=182.7, cx=127.4, cy=102.7)
FRAMES = (0, 12, 24)


@pytest.fixture(scope="module")
def stage() -> Stage:
    return Stage(SEED, FRAMES[-1] + 1, StageOptions(3, 0.02, 2.0), camera=SMALL)


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory, stage: Stage) -> Iterator[Served]:
    settings = settings_in(tmp_path_factory.mktemp("served"))
    folder = settings.workspace / "sequences" / "stage"
    made = (stage.frame(i) for i in FRAMES)
    import_frames(made, folder, RecordingInfo("stage", "Stage", 30.0))
    exact = Stage(SEED, 1, StageOptions(), camera=SMALL)
    folder = settings.workspace / "sequences" / "exact"
    import_frames(exact.frames, folder, RecordingInfo("exact", "Exact mounts", 30.0))
    add_sequence(settings, "alone", frames=1)
    with serving(settings) as running:
        yield running


@pytest.fixture
def client(served: Served) -> Iterator[Client]:
    with Client(served.url, TOKEN) as opened:
        yield opened


def errors(recording: Recording, stage: Stage) -> list[tuple[float, float]]:
    """Return metres and degrees by which each mount is wrong."""
    found = []
    for sensor, true in zip(recording.manifest.sensors, stage.true_mounts, strict=True):
        left = np.linalg.inv(true) @ np.reshape(np.asarray(sensor.mounts[0]), (4, 4))
        turn = Rotation.from_matrix(left[:3, :3]).magnitude()
        found.append((float(np.linalg.norm(left[:3, 3])), float(np.degrees(turn))))
    return found


def test_sensors_are_aligned_and_the_alignment_is_undone(client: Client, stage: Stage) -> None:
    before = client["stage"].frames[0].points()
    result = client["stage"].align_sensors()
    assert [each.name for each in result.sensors] == ["front", "right", "left"]
    assert all(each.after < 0.3 * each.before for each in result.sensors)
    aligned = errors(client["stage"], stage)
    assert aligned[0] == (0.0, 0.0)
    assert max(metres for metres, _ in aligned) < 0.01  # a quarter of the pixels of the sample
    assert max(degrees for _, degrees in aligned) < 0.2
    moved = client["stage"].frames[0].points()["xyz"]
    assert np.abs(moved - before["xyz"]).max() > 0.02
    client["stage"].align_sensors(undo=True)
    assert np.array_equal(client["stage"].frames[0].points()["xyz"], before["xyz"])
    client["stage"].align_sensors(undo=True)
    assert errors(client["stage"], stage) == aligned


def test_a_click_labels_an_object_in_all_sensors(client: Client, stage: Stage) -> None:
    recording = client["exact"]
    frame, person = recording.frames[0], stage.labels[-1]
    truth = stage.truth[FRAMES[0]] == person.id
    points = frame.points()
    label = recording.create_label("person", category="person")
    eye = np.zeros(3)  # the page's camera, where the front sensor is
    chosen = np.flatnonzero(truth & (points["sensor"] == 0))
    middle = points["xyz"][chosen] - np.median(points["xyz"][chosen], axis=0)
    at = points["xyz"][chosen[np.linalg.norm(middle, axis=1).argmin()]]
    levels = frame.objects([eye], [at - eye])
    own = np.flatnonzero(truth)
    best = max(levels, key=lambda level: _iou(level.numbers, own))
    frame.stroke(
        label=label.id, shape="object", samples=[eye], directions=[at - eye], candidate=best.id
    )
    labelled = frame.annotation() == label.id
    assert _iou(np.flatnonzero(labelled), own) > 0.8
    for sensor in range(len(stage.sensors)):
        seen = truth & (points["sensor"] == sensor)
        assert (labelled & seen).sum() > 0.7 * seen.sum() > 0


def _iou(one: np.ndarray, other: np.ndarray) -> float:
    """IoU of two sets of point numbers."""
    return len(np.intersect1d(one, other)) / len(np.union1d(one, other))


def test_one_sensor_cannot_be_aligned(client: Client) -> None:
    with pytest.raises(ConflictError, match="expected a recording of several"):
        client["alone"].align_sensors()


def test_the_command_shows_each_sensor(served: Served, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["align-sensors", "stage", "--server", served.url, "--token", TOKEN]
    assert main(command) == 0
    out = capsys.readouterr().out
    assert "front\tmoved by 0.0 mm" in out
    assert "aligned 3 sensors" in out
