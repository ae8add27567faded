"""Recordings of several sensors, from their files to exports of each sensor."""

from __future__ import annotations

import json
import shutil
import zipfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np
import pytest
from PIL import Image
from pyarrow import feather

from pointbrush.cli import main
from pointbrush.client import Client
from pointbrush.errors import BadInputError
from pointbrush.formats import EXPORTS
from pointbrush.formats.readers.nuscenes import tables_in, world_from_sensor
from pointbrush.formats.tables.corrections import Corrections
from pointbrush.geometry.oriented_box import BoxPose, OrientedBox
from pointbrush.labels import Label
from pointbrush.workspace import Workspace
from tests.formats.test_joined_sensors import (
    FRONT,
    MOUNTS,
    REAR,
    frames_of,
    nuscenes_with_radar,
    rig,
    two_lidars,
)
from tests.serving import Served, serving, settings_in
from tests.waiting import PATIENCE


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    folder = tmp_path_factory.mktemp("sensors")
    inbox = folder / "inbox"
    (inbox / "rig").mkdir(parents=True)
    rig(inbox / "rig")
    (inbox / "rig" / "mounts.json").write_text(
        json.dumps({name: {"T_frame_sensor": T.tolist()} for name, T in MOUNTS.items()})
    )
    two_lidars(inbox)
    with serving(settings_in(folder, import_roots=str(inbox))) as running:
        yield running


@pytest.fixture(scope="module")
def client(served: Served) -> Iterator[Client]:
    token = served.headers["Authorization"].removeprefix("Bearer ")
    with Client(served.url, token) as opened:
        yield opened


@pytest.fixture
def inbox(served: Served) -> Path:
    return served.workspace.settings.roots[0]


def exported(archive: Path) -> dict[str, Any]:
    """The arrays of each frame, and ``export.json``."""
    with zipfile.ZipFile(archive) as packed:
        found: dict[str, Any] = {
            name: dict(np.load(packed.open(name)))
            for name in sorted(packed.namelist())
            if name.endswith(".npz")
        }
        return found | {"about": json.loads(packed.read("export.json"))}


def require_alone(found: dict[str, Any], place: Path, **options: Any) -> None:
    """Require the points and times of a sensor's own recording, bit for bit; frames without it are
    empty."""
    alone = {frame.timestamp: frame for frame in frames_of(place, **options)}
    arrays = [value for name, value in found.items() if name != "about"]
    filled = [each for each in arrays if len(each["xyz"])]
    assert len(filled) == len(alone) - ("right" in place.name)
    for each in filled:
        frame = alone[each["timestamp"][()]]
        for name in ("xyz", "rgb", "intensity"):
            expected = getattr(frame, name)
            assert (name in each) == (expected is not None)
            assert expected is None or np.array_equal(each[name], expected)
            assert expected is None or each[name].dtype == expected.dtype


@pytest.mark.parametrize("how", ["path", "upload"])
def test_three_depth_cameras_come_in_and_out(
    client: Client, inbox: Path, tmp_path: Path, how: str
) -> None:
    files, options = None, {"server_path": inbox / "rig", "extrinsics": "mounts.json"}
    if how == "upload":
        files = [*(inbox / "rig" / name for name in MOUNTS), inbox / "rig" / "mounts.json"]
        named = [f"{name}={name}" for name in MOUNTS]
        options = {"sensor": named, "extrinsics": "mounts.json"}
    seen = client.preview(files, **options)
    assert [(each["name"], each["type"], each["joined"]) for each in seen.sensors] == [
        ("left", "depth", 4), ("middle", "depth", 4), ("right", "depth", 3)
    ]  # fmt: skip
    assert seen.sensors[2]["left_out"] == 1
    assert seen.sensors[1]["apart"] == pytest.approx(0.005)
    recording = client.import_files(files, name=f"rig-{how}", **options)
    for name in MOUNTS:
        out = recording.export("npz", tmp_path / f"{name}.zip", sensor=name)
        require_alone(exported(Path(out)), inbox / "rig" / name)
    whole = exported(recording.export("npz", tmp_path / "all.zip"))
    second = whole["000001.npz"]
    assert np.unique(second["sensor"]).tolist() == [0, 1, 2]
    times = [frame["sensors"]["middle"]["time"] for frame in whole["about"]["frames"]]
    assert times == [10.005 + k / 8 for k in range(4)]
    assert np.array_equal(second["sensor_time"][second["sensor"] == 1][:1], times[1:2])
    told = whole["about"]["frames"][1]["sensors"]["left"]
    assert np.array_equal(np.reshape(told["T_frame_sensor"], (4, 4)), MOUNTS["left"])
    with pytest.raises(BadInputError, match="expected one of left, middle, right, got 'top'"):
        recording.export("npz", tmp_path / "none.zip", sensor="top")
    masks = recording.export("masks-png", tmp_path / "masks.zip", sensor="middle")
    with zipfile.ZipFile(masks) as packed:
        names = [name for name in packed.namelist() if name.startswith("labels/")]
        assert names == [f"labels/depth-middle/{frame:06d}.png" for frame in range(4)]


def test_two_lidars_of_a_bag_come_in_and_out(client: Client, inbox: Path, tmp_path: Path) -> None:
    recording = client.import_files(server_path=inbox / "drive.bag", topic=[FRONT, REAR])
    for name, topic in (("front", FRONT), ("rear", REAR)):
        out = recording.export("npz", tmp_path / f"{name}.zip", sensor=name)
        require_alone(exported(Path(out)), inbox / "drive.bag", topic=topic)


def test_a_command_sends_the_folders_of_sensors_to_a_server(
    served: Served, client: Client, inbox: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mounts = ["--extrinsics", str(inbox / "rig" / "mounts.json"), "--name", "sent"]
    named = [f"--sensor={name}={inbox / 'rig' / name}" for name in ("left", "right")]
    token = served.headers["Authorization"].removeprefix("Bearer ")
    for sent in (named, [str(inbox / "rig")]):
        assert main(["import", *sent, *mounts, "--server", served.url, "--token", token]) == 0
        assert "sensor right (depth): 3 frames" in capsys.readouterr().out


def test_paths_outside_and_unknown_files_are_refused(
    client: Client, inbox: Path, tmp_path: Path
) -> None:
    outside = shutil.copy(inbox / "rig" / "mounts.json", tmp_path / "mounts.json")
    for options in (
        {"server_path": inbox / "rig", "extrinsics": str(outside)},
        {"server_path": inbox, "sensor": ["a=rig/left", "b=../../etc"]},
    ):
        with pytest.raises(Exception, match="under the folders that may be imported from"):
            client.preview(**options)
    with pytest.raises(BadInputError, match="extrinsics: expected an uploaded file"):
        client.preview([inbox / "rig" / "left"], extrinsics="mounts.json")


def test_commands_import_and_export_by_sensor(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rig(tmp_path)
    mounts, at = tmp_path / "my.json", ["--workspace", str(tmp_path / "ws")]
    mounts.write_text(json.dumps({n: {"T_frame_sensor": T.tolist()} for n, T in MOUNTS.items()}))
    named = [each for n in ("left", "right") for each in ("--sensor", f"{n}={tmp_path / n}")]
    wanted = ["import", *named, "--extrinsics", str(mounts), "--clock-offset", "right=0", *at]
    assert main([*wanted, "--dry-run"]) == 0
    assert (
        "left (depth): 4 frames; right (depth): 3 frames, 5.0 ms apart" in capsys.readouterr().out
    )
    assert main([*wanted, "--name", "rig"]) == 0
    assert "right: 1 of 4 frames are left out" in capsys.readouterr().err
    out = tmp_path / "out.zip"
    assert (
        main(["export", "rig", "--format", "npz", "--out", str(out), "--sensor", "right", *at]) == 0
    )
    require_alone(exported(out), tmp_path / "right")


@pytest.fixture
def drive(tmp_path: Path) -> Iterator[Workspace]:
    """nuScenes with a radar, and a box around points of both sensors."""
    nuscenes_with_radar(tmp_path / "nuscenes")
    with closing(Workspace(settings_in(tmp_path))) as workspace:
        chosen = Corrections(sensors="all")
        job = workspace.imports.begin([tmp_path / "nuscenes"], name="drive", chosen=chosen)
        assert workspace.runner.wait(job.id, PATIENCE).state == "done"
        pose = BoxPose(np.array([5.0, 0, 0]), np.array([0.0, 0, 0, 1]))
        box = OrientedBox(0, 1, np.full(3, 200.0), {0: pose, 1: pose})
        workspace.labels.apply(
            "drive", edit_id=str(uuid4()), author="ann", kind="label", summary="", boxes=[box],
            writes=lambda _: ([Label(1, "car", "vehicle", "#ff0000")], ()),
        )  # fmt: skip
        yield workspace


def test_labels_of_the_lidar_are_of_its_points(drive: Workspace, tmp_path: Path) -> None:
    """lidarseg has a class for each point of the lidar, and none for points of radars."""
    sweeps = sorted((tmp_path / "nuscenes" / "samples" / "LIDAR_TOP").iterdir())
    (tmp_path / "labels").mkdir()
    for sweep in sweeps:
        name = sweep.name.replace(".pcd.bin", "_lidarseg.bin")
        np.full(40, 17, np.uint8).tofile(tmp_path / "labels" / name)
    job = drive.imports.begin_labels("drive", tmp_path / "labels", "ann", format="lidarseg")
    done = drive.runner.wait(job.id, PATIENCE)
    assert done.result is not None, done.error
    assert done.result["labelled"] == 80
    drive.export("drive", "npz", tmp_path / "out", sensor="LIDAR_TOP")
    assert np.load(tmp_path / "out" / "000001.npz")["label"].all()
    drive.export("drive", "npz", tmp_path / "radar", sensor="RADAR_FRONT")
    assert not np.load(tmp_path / "radar" / "000001.npz")["label"].any()


def test_nuscenes_tables_have_each_sensor_at_its_place(drive: Workspace, tmp_path: Path) -> None:
    drive.export("drive", "nuscenes-boxes", tmp_path / "out")
    source, made = (
        tables_in(tmp_path / name) for name in ("nuscenes/v1.0-mini", "out/v1.0-pointbrush")
    )
    given, wrote = (
        {row["timestamp"]: (Path(row["filename"]).parent.name, world_from_sensor(row, t.by_token))
         for row in t.data if "CAM" not in row["filename"]}
        for t in (source, made)
    )  # fmt: skip
    assert {time: name for time, (name, _) in given.items()} == {
        time: name for time, (name, _) in wrote.items()
    }
    # Both worlds differ by one rigid transform: it is the same for all sensors and sweeps.
    moves = [wrote[time][1] @ np.linalg.inv(T) for time, (_, T) in given.items()]
    assert np.allclose(moves, moves[0], atol=1e-9)
    folder = tmp_path / "out" / "v1.0-pointbrush"
    modes = json.loads((folder / "sensor.json").read_text())
    assert [(row["channel"], row["modality"]) for row in modes] == [
        ("LIDAR_TOP", "lidar"), ("RADAR_FRONT", "radar")
    ]  # fmt: skip
    boxes = json.loads((folder / "sample_annotation.json").read_text())
    assert [(row["num_lidar_pts"], row["num_radar_pts"]) for row in boxes] == [(40, 6)] * 2


def test_argoverse_tables_have_the_mounts(drive: Workspace, tmp_path: Path) -> None:
    drive.export("drive", "argoverse2", tmp_path / "out")
    table = feather.read_table(
        tmp_path / "out/calibration/egovehicle_SE3_sensor.feather"
    ).to_pydict()
    assert table["sensor_name"] == ["LIDAR_TOP", "RADAR_FRONT"]
    # The radar is 3 m ahead of the lidar, and 3 m further by the vehicle's motion.
    offset = np.array([np.subtract(*table[name]) for name in ("tx_m", "ty_m", "tz_m")])
    assert np.linalg.norm(offset) == pytest.approx(np.hypot(6, 1.3))


def test_every_format_of_points_or_boxes_takes_a_sensor(drive: Workspace, tmp_path: Path) -> None:
    drive.annotations.put("drive", 0, np.ones(46, np.uint16), author="ann", layer="label")
    for name in (each.name for each in EXPORTS.values() if not each.pictures):
        for sensor in (None, "RADAR_FRONT"):
            drive.export("drive", name, tmp_path / f"{name}-{sensor}", sensor=sensor)
    manifest = json.loads((tmp_path / "labels-only-RADAR_FRONT" / "manifest.json").read_text())
    assert [(frame["rows"], frame["labelled"]) for frame in manifest["frames"]] == [(6, 6), (6, 0)]


def test_boxes_of_one_sensor_are_in_its_coordinates(drive: Workspace, tmp_path: Path) -> None:
    drive.export("drive", "sustechpoints", tmp_path / "whole")
    drive.export("drive", "sustechpoints", tmp_path / "radar", sensor="RADAR_FRONT")
    (whole, radar) = (
        json.loads(next(iter(sorted((tmp_path / name / "label").glob("*.json")))).read_text())[0]
        for name in ("whole", "radar")
    )
    places = [[box["psr"]["position"][axis] for axis in "xyz"] for box in (whole, radar)]
    assert np.linalg.norm(np.subtract(*places)) == pytest.approx(np.hypot(6, 1.3), abs=1e-3)


def test_up_of_a_rig_of_cameras_is_found_in_the_axes_of_its_mounts(tmp_path: Path) -> None:
    """Two cameras 1.4 m above the floor look at a wall; the rig has z up, not y down."""
    y = (np.arange(48)[:, None] - 23.5) / 40 + np.zeros((48, 64))
    depth = np.where(y > 1.4 / 4, 1.4 / np.maximum(y, 1e-9), 4.0) * 1000
    T = np.eye(4)
    T[:3, :3] = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]
    for name in ("a", "b"):
        (tmp_path / "rig" / name / "depth").mkdir(parents=True)
        image = Image.fromarray(depth.astype(np.uint16))
        image.save(tmp_path / "rig" / name / "depth" / "0.png")
        camera = {"fx": 40, "fy": 40, "cx": 31.5, "cy": 23.5}
        (tmp_path / "rig" / name / "camera.json").write_text(json.dumps(camera))
    (tmp_path / "rig" / "extrinsics.json").write_text(
        json.dumps({name: {"T_frame_sensor": T.tolist()} for name in "ab"})
    )
    with closing(Workspace(settings_in(tmp_path))) as workspace:
        assert workspace.imports.preview([tmp_path / "rig"]).up == "z"
        job = workspace.imports.begin([tmp_path / "rig"])
        done = workspace.runner.wait(job.id, PATIENCE)
        assert done.result is not None, done.error
        assert (done.result["up"], done.result["up_from"]) == ("z", "guessed")
        counts = [(each["name"], each["frames"]) for each in done.result["sensors"]]
        assert counts == [("a", 1), ("b", 1)]
