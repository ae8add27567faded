"""Frames of several sensors: stored bit for bit, placed by mounts that can be corrected."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pointbrush.errors import BadInputError, DamagedError
from pointbrush.formats import read
from pointbrush.frame import FramePart, PointFrame, Sensor, join_sensors
from pointbrush.samples.geometry import rigid, vec
from pointbrush.sequences import (
    Manifest,
    RecordingInfo,
    StoredFrame,
    import_frames,
    importer,
    open_sequence,
    read_manifest,
    update_manifest,
    verify,
)
from pointbrush.sequences.storage.manifest import (
    VERSION,
    changed_manifest,
    checksum,
    parse_manifest,
    rename_sequence,
)
from pointbrush.sequences.storage.recording_files import FolderFiles
from tests.depth_camera import depth_camera
from tests.rigs import cloud, corrections, mount, rig
from tests.sequences.depth_decoder import decode_depth, unproject
from tests.sequences.vertex_decoder import decode_points

SENSORS = (Sensor("left", "spinning"), Sensor("right", "radar"), Sensor("rear"))
MAP = rigid(np.eye(3), vec(5e5, -4e6, 120))


def frame_of(counts: dict[int, int], seed: int, far: bool = False) -> PointFrame:
    """A frame of so many points of each sensor; ``far``: on a map, and of double precision."""
    dtype = np.float64 if far else np.float32
    place = MAP if far else np.eye(4)
    given = [
        (FramePart(sensor, place @ mount(sensor), 0.1 * sensor), cloud(count, seed + sensor, dtype))
        for sensor, count in counts.items()
    ]
    return join_sensors(SENSORS, given, timestamp=float(seed))


def put(frames: list[PointFrame], target: Path) -> list[StoredFrame]:
    import_frames(frames, target, RecordingInfo("s", "A rig", 10.0))
    assert verify(target) == []
    return list(open_sequence(target))


@settings(max_examples=15)
@given(
    counts=st.lists(
        st.dictionaries(st.integers(0, 2), st.integers(0, 9000), min_size=1), min_size=1, max_size=3
    ),
    far=st.booleans(),
    seed=st.integers(0, 99),
)
def test_frames_come_back_bit_for_bit_per_sensor(
    tmp_path_factory: pytest.TempPathFactory, counts: list[dict[int, int]], far: bool, seed: int
) -> None:
    frames = [frame_of(dict(sorted(each.items())), seed + k, far) for k, each in enumerate(counts)]
    for frame, stored in zip(frames, put(frames, tmp_path_factory.mktemp("s") / "s"), strict=True):
        assert stored.sensors == SENSORS
        assert stored.sensor is not None
        np.testing.assert_array_equal(stored.to_source(stored.sensor), frame.sensor)
        assert stored.sensor_xyz().tobytes() == frame.sensor_xyz.tobytes()
        assert stored.sensor_xyz().dtype == frame.sensor_xyz.dtype
        assert stored.source_xyz().tobytes() == frame.xyz.tobytes()
        np.testing.assert_array_equal(stored.to_source(stored.rgb), frame.rgb)
        for part in stored.parts:
            mine = stored.sensor == part.sensor
            own = stored.sensor_xyz()[stored.source_index[mine]]
            T = part.T_frame_sensor
            np.testing.assert_allclose(
                stored.xyz[mine],
                own @ T[:3, :3].T + T[:3, 3],
                rtol=1e-6,
                atol=2e-4 if far else 4e-6,
            )
            assert part.timestamp == 0.1 * part.sensor
            assert mine.any()
        # Every chunk holds points of one sensor, and levels follow one another.
        sensors, levels = stored.chunk_table["sensor"], stored.chunk_table["level"].tolist()
        assert levels == sorted(levels)
        for chunk, sensor in zip(stored.chunks, sensors.tolist(), strict=True):
            assert chunk.sensor == sensor
            assert (stored.sensor[chunk.first : chunk.first + chunk.count] == sensor).all()
            own = stored.xyz[chunk.first : chunk.first + chunk.count]
            np.testing.assert_array_equal(own.min(axis=0), np.float32(chunk.lo))
            np.testing.assert_array_equal(own.max(axis=0), np.float32(chunk.hi))


@pytest.fixture(scope="module")
def stored_rig(tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("rig") / "s"
    put([rig(0), rig(2)], target)
    return target


def test_each_depth_camera_has_the_depth_image_that_it_has_alone(
    stored_rig: Path, tmp_path: Path
) -> None:
    stored_error = read_manifest(stored_rig).position_error
    stored = open_sequence(stored_rig)[0]
    table = stored.chunk_table
    for part in stored.parts:
        mine = np.flatnonzero(table["sensor"] == part.sensor)
        assert (part.lattice is not None) == (part.type == "depth")
        chunks = [stored.depth(c, c + 1).tobytes() for c in mine]
        own = stored.sensor_xyz()[stored.source_index[stored.sensor == part.sensor]]
        if part.lattice is None:
            assert not any(map(stored.is_band, mine))
            assert chunks == [stored.wire(c, c + 1).tobytes() for c in mine]
            continue
        assert all(map(stored.is_band, mine))
        found = decode_depth(part.lattice, chunks)[0]
        shown = unproject(part.lattice, found.pixel, found.depth)
        assert np.abs(shown - own).max() <= stored_error
        [alone] = put([depth_camera(part.sensor)], tmp_path / part.name)
        assert b"".join(chunks) == alone.depth(0, len(alone.chunks)).tobytes()


def test_real_depth_cameras_take_at_most_a_byte_a_point_each(shared: Path, tmp_path: Path) -> None:
    frames = list(read(shared / "realdata" / "pcl_kinect3"))[:2]
    given = [(FramePart(k, mount(k)), frames[k]) for k in range(2)]
    [stored] = put([join_sensors(SENSORS[:2], given)], tmp_path / "s")
    ends = [stored.depth_start(chunk) for chunk in range(len(stored.chunks) + 1)]
    for sensor in range(2):
        mine = stored.chunk_table["sensor"] == sensor
        assert np.diff(ends)[mine].sum() <= 1.0 * len(frames[sensor])


def test_points_on_the_wire_are_in_the_coordinates_of_their_sensor(stored_rig: Path) -> None:
    manifest = read_manifest(stored_rig)
    stored = open_sequence(stored_rig)[1]
    for chunk in stored.chunks:
        part = stored.parts[chunk.sensor or 0]
        data = stored.wire(chunk.index, chunk.index + 1)
        q = decode_points(data, chunk.count)[:, :6].copy().view("<u2")
        shown = np.array(chunk.origin) + q * np.array(chunk.scale)
        T = part.T_frame_sensor
        placed = shown @ T[:3, :3].T + T[:3, 3]
        own = stored.xyz[chunk.first : chunk.first + chunk.count]
        assert np.abs(placed - own).max() <= manifest.position_error


def test_a_corrected_mount_moves_the_points_of_its_sensor_only(
    stored_rig: Path, tmp_path: Path
) -> None:
    shutil.copytree(stored_rig, tmp_path / "s")
    before = open_sequence(tmp_path / "s")
    files = {path: path.read_bytes() for path in (tmp_path / "s").rglob("*.[pw]*")}
    trees = before[0].kdtree.data.copy()
    manifest = update_manifest(tmp_path / "s", corrections=corrections())
    after = open_sequence(tmp_path / "s")
    old, new = before[0], after[0]
    assert after.identity == before.identity
    assert after.placement != before.placement
    assert files == {path: path.read_bytes() for path in files}
    assert verify(tmp_path / "s") == []
    moved = new.sensor == 1
    np.testing.assert_array_equal(new.xyz[~moved], old.xyz[~moved])
    T = mount(1) @ corrections()[1]
    np.testing.assert_allclose(new.parts[1].T_frame_sensor, T)
    np.testing.assert_allclose(new.parts[1].viewpoint, T[:3, 3])
    own = new.sensor_xyz()
    np.testing.assert_array_equal(own, old.sensor_xyz())
    placed = own[new.source_index[moved]] @ T[:3, :3].T + T[:3, 3]
    np.testing.assert_allclose(new.xyz[moved], placed, atol=1e-5)
    np.testing.assert_array_equal(new.to_source(new.xyz), new.source_xyz())
    np.testing.assert_array_equal(new.kdtree.data, new.xyz)
    np.testing.assert_array_equal(old.kdtree.data, trees)
    require_inside(new, manifest)
    update_manifest(tmp_path / "s", corrections=[np.eye(4)] * 3)
    undone = open_sequence(tmp_path / "s")
    assert undone.placement == before.placement
    np.testing.assert_array_equal(undone[0].xyz, old.xyz)


def test_corrected_points_on_a_map_are_inside_their_boxes(tmp_path: Path) -> None:
    put([frame_of({0: 5000, 1: 5000, 2: 100}, 0, far=True)], tmp_path / "s")
    before = open_sequence(tmp_path / "s")[0].xyz
    manifest = update_manifest(tmp_path / "s", corrections=corrections())
    stored = open_sequence(tmp_path / "s")[0]
    moved = np.linalg.norm(stored.xyz - before, axis=1)
    assert moved[stored.sensor != 1].max() == 0
    assert 0.01 < np.median(moved[stored.sensor == 1]) < 0.5
    require_inside(stored, manifest)


def require_inside(stored: StoredFrame, manifest: Manifest) -> None:
    """All points are in the boxes by which selection and the page find them."""
    blocks = stored.blocks
    block = np.repeat(np.arange(len(blocks.lo)), np.diff(blocks.first))
    chunk = np.repeat(np.arange(len(stored.chunks)), stored.chunk_table["count"])
    boxes = (
        manifest.bounds,
        (blocks.lo[block], blocks.hi[block]),
        (blocks.chunk_lo[chunk], blocks.chunk_hi[chunk]),
    )
    for lo, hi in boxes:
        assert (stored.xyz >= np.float32(lo)).all()
        assert (stored.xyz <= np.float32(hi)).all()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ([np.eye(4)] * 2, "one for each of 3 sensors"),
        ([np.eye(4), np.eye(4), np.diag([2.0, 2, 2, 1])], "correction of top: expected a rotation"),
        ([np.eye(4), np.full((4, 4), np.nan), np.eye(4)], "correction of right: expected numbers"),
        ([np.eye(4), np.eye(3), np.eye(4)], "correction of right: expected 16 numbers"),
    ],
)
def test_other_corrections_are_refused(stored_rig: Path, given: Any, words: str) -> None:
    with pytest.raises(BadInputError, match=words):
        changed_manifest(read_manifest(stored_rig), corrections=given)


def test_mounts_of_each_frame_and_frames_without_a_sensor(tmp_path: Path) -> None:
    moving = [mount(10), mount(11), mount(12)]
    frames = []
    for k, T in enumerate(moving):
        given = [(FramePart(0, np.eye(4), 1.0 + k), cloud(100, k))]
        if k != 1:
            given.append((FramePart(1, T, 1.5 + k), cloud(50 + k, k)))
        frames.append(join_sensors(SENSORS[:2], given))
    put(frames, tmp_path / "s")
    [fixed, other] = read_manifest(tmp_path / "s").sensors
    assert (len(fixed.mounts), len(other.mounts)) == (1, 3)
    assert (other.times, other.points) == ([1.5, None, 3.5], [50, 0, 52])
    recording = open_sequence(tmp_path / "s")
    assert [[part.sensor for part in stored.parts] for stored in recording] == [[0, 1], [0], [0, 1]]
    np.testing.assert_array_equal(recording[2].parts[1].T_frame_sensor, moving[2])


def test_older_servers_open_recordings_of_one_sensor_only(stored_rig: Path, tmp_path: Path) -> None:
    import_frames([cloud(10, 0)], tmp_path / "s", RecordingInfo("s", "A scan"))
    assert json.loads((tmp_path / "s" / "manifest.json").read_bytes())["version"] == 7
    content = json.loads((stored_rig / "manifest.json").read_bytes())
    assert content["version"] == VERSION == 8
    content.pop("checksum")
    content["version"] = 9
    data = json.dumps(content | {"checksum": checksum(content)}).encode()
    with pytest.raises(BadInputError, match="version 1 to 8, got 9, of a newer pointbrush"):
        parse_manifest(data, "s")


def test_several_sensors_have_more_points_than_a_frame_of_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The frame is no octree: it has depth images, and is exported whole."""
    monkeypatch.setattr(importer, "LARGE_POINTS", 100)
    monkeypatch.setattr(importer, "JOINED_POINTS", 250)
    frame = frame_of({0: 100, 1: 60}, 0)
    (stored,) = put([frame], tmp_path / "s")
    assert not stored.large
    assert stored.sensor_xyz().tobytes() == frame.sensor_xyz.tobytes()
    for counts, said in (
        ({0: 60, 1: 101}, "sensor right: expected at most 100 points in a frame .*, got 101"),
        ({0: 90, 1: 90, 2: 90}, "^expected at most 250 points in a frame .*, got 270: leave out"),
    ):
        with pytest.raises(BadInputError, match=said):
            put([frame_of(counts, 0)], tmp_path / "refused")
        assert not (tmp_path / "refused").exists()


def test_a_depth_camera_that_begins_later_has_a_lattice(tmp_path: Path) -> None:
    lidar = (FramePart(0, mount(0)), cloud(500, 1))
    later = join_sensors(SENSORS[:2], [lidar, (FramePart(1, mount(1)), depth_camera(0))])
    first, second = put([join_sensors(SENSORS[:2], [lidar]), later], tmp_path / "s")
    assert first.depth_ends is None
    assert [part.lattice is None for part in second.parts] == [True, False]


def test_copies_and_damage_of_a_recording_of_several_sensors(
    stored_rig: Path, tmp_path: Path
) -> None:
    update_manifest(shutil.copytree(stored_rig, tmp_path / "s"), corrections=corrections())
    FolderFiles(tmp_path / "s").copy_to(tmp_path / "copy")
    rename_sequence(tmp_path / "copy", "copy")
    original, copy = open_sequence(tmp_path / "s"), open_sequence(tmp_path / "copy")
    assert copy.identity != original.identity
    assert verify(tmp_path / "copy") == []
    np.testing.assert_array_equal(copy[1].xyz, original[1].xyz)
    path = tmp_path / "copy" / "frames" / "000000.points"
    data = bytearray(path.read_bytes())
    data[-100] ^= 1
    path.write_bytes(data)
    assert [problem.split(":")[0] for problem in verify(tmp_path / "copy")] == [
        "frames/000000.points"
    ]
    with pytest.raises(DamagedError, match="frame 0 is damaged"):
        open_sequence(tmp_path / "copy")[0].xyz  # noqa: B018 - reads the files


def test_points_far_from_their_sensor_are_refused(tmp_path: Path) -> None:
    far = PointFrame(np.full((2, 3), 5e5))
    frame = join_sensors(SENSORS[:1], [(FramePart(0, np.eye(4)), far)])
    with pytest.raises(BadInputError, match="sensor left: expected points within 16,384 m of it"):
        put([frame], tmp_path / "s")
