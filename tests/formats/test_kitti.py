"""KITTI, SemanticKITTI and XYZRGB records."""

from __future__ import annotations

import numpy as np
import pytest

from pointbrush.errors import BadInputError
from pointbrush.formats import open_source, read

RNG = np.random.default_rng(3)


def scan(path, count=50):
    path.parent.mkdir(parents=True, exist_ok=True)
    table = RNG.normal(scale=20, size=(count, 4)).astype("<f4")
    table[:, 3] = RNG.random(count)
    path.write_bytes(table.tobytes())
    return table


def test_a_semantickitti_sequence(tmp_path):
    root = tmp_path / "sequences" / "07"
    tables = [scan(root / "velodyne" / f"{i:06d}.bin") for i in range(3)]
    packed = np.arange(50, dtype="<u4") << 16 | np.uint32(40)
    (root / "labels").mkdir()
    (root / "labels" / "000001.label").write_bytes(packed.tobytes())
    (root / "times.txt").write_text("0.0\n0.1\n0.2\n")
    (root / "calib.txt").write_text("P0: 1\nTr: 0 -1 0 0 0 0 -1 0 1 0 0 0.5\n")
    (root / "poses.txt").write_text("".join(f"1 0 0 0 0 1 0 0 0 0 1 {i}\n" for i in range(3)))
    source = open_source([tmp_path])
    assert (source.count, source.fps) == (3, 10)
    frames = list(source.frames)
    assert np.array_equal(frames[2].xyz, tables[2][:, :3])
    assert np.array_equal(frames[2].intensity, tables[2][:, 3])
    assert frames[0].label is None
    assert frames[1].label.tolist() == [40] * 50
    assert frames[1].instance.tolist() == list(range(50))
    # The camera moved along its z, which is the velodyne's x.
    assert frames[2].pose[:3, 3] == pytest.approx([2, 0, 0])


def test_a_part_of_a_sequence_keeps_the_lists_of_the_whole(tmp_path):
    for i in (4, 2):
        scan(tmp_path / "velodyne" / f"{i:06d}.bin")
    (tmp_path / "times.txt").write_text("".join(f"{i / 10}\n" for i in range(9)))
    (tmp_path / "poses.txt").write_text("".join(f"1 0 0 {i} 0 1 0 0 0 0 1 0\n" for i in range(9)))
    frames = list(read(tmp_path))
    assert [frame.timestamp for frame in frames] == [0.2, 0.4]
    assert [frame.pose[0, 3] for frame in frames] == [2, 4]
    scan(tmp_path / "velodyne" / "000009.bin")
    with pytest.raises(BadInputError, match=r"times\.txt: expected 3 times, one per frame, got 9"):
        open_source([tmp_path])


@pytest.mark.parametrize("size", [15, 17, 16 * 50 + 4])
def test_broken_records_raise(tmp_path, size):
    (tmp_path / "a.bin").write_bytes(bytes(size))
    with pytest.raises(BadInputError, match="16 bytes"):
        list(read(tmp_path / "a.bin", "kitti"))


def test_labels_of_another_count_raise(tmp_path):
    scan(tmp_path / "a.bin")
    (tmp_path / "a.label").write_bytes(bytes(196))
    with pytest.raises(BadInputError, match=r"a\.label: expected 50 labels"):
        list(read(tmp_path / "a.bin"))


@pytest.mark.parametrize("top", [1, 255])
def test_xyzrgb_records_are_recognised_by_their_values(tmp_path, top):
    table = RNG.normal(scale=5, size=(40, 6)).astype("<f4")
    color = RNG.integers(0, 256, (40, 3))
    table[:, 3:] = color / 255 * top
    (tmp_path / "a.bin").write_bytes(table.tobytes())
    (tmp_path / "a.xyzrgb").write_bytes(table.tobytes())
    for path, name in (("a.bin", None), ("a.bin", "xyzrgb"), ("a.xyzrgb", None)):
        (frame,) = read(tmp_path / path, name)
        assert np.array_equal(frame.xyz, table[:, :3])
        assert np.array_equal(frame.rgb, color)


def surroundings(count, rings=1, offset=0.0):
    """Points round a scanner, ring by ring or all rings of a moment at once."""
    azimuth = np.repeat(np.linspace(0, 6.2, count), rings)
    lasers = [-15, 1, -13, 3, -11, 5, -9, 7, -7, 9, -5, 11, -3, 13, -1, 15]
    slope = np.radians(np.tile(lasers[:rings], count))
    reach = RNG.uniform(5, 50, count * rings)
    xyz = np.stack([np.cos(azimuth), np.sin(azimuth), np.tan(slope)]).T * reach[:, None]
    return (xyz + offset).astype("<f4")


CLOUDS = {
    "rings": lambda: surroundings(960),
    "lasers in turn": lambda: surroundings(1800, rings=16),
    "all positive": lambda: surroundings(960, offset=60),
    "a box on the floor": lambda: RNG.uniform(0, [4, 2, 1], (96, 3)).astype("<f4") + [5, 0, 0],
    "half zeros": lambda: surroundings(960) * (RNG.random((960, 1)) > 0.5),
}


@pytest.mark.parametrize("folder", ["a", "velodyne"])
@pytest.mark.parametrize("less", range(4))
@pytest.mark.parametrize("cloud", CLOUDS)
def test_coordinates_alone_are_recognised_by_their_values(tmp_path, cloud, less, folder):
    xyz = np.asarray(CLOUDS[cloud](), "<f4")
    xyz = xyz[: len(xyz) - less]
    path = tmp_path / folder / "0.bin"
    path.parent.mkdir()
    path.write_bytes(xyz.tobytes())
    (frame,) = read(path)
    assert np.array_equal(frame.xyz, xyz[xyz.any(axis=1)])
    assert frame.intensity is None


@pytest.mark.parametrize("cut", [0, 8])
@pytest.mark.parametrize("cloud", CLOUDS)
@pytest.mark.parametrize(
    "fourth",
    [
        lambda n: RNG.random(n),
        lambda n: RNG.integers(0, 256, n),
        lambda n: np.zeros(n),
        lambda n: np.full(n, 0.3),
        lambda n: RNG.normal(-30, 9, n),
        lambda n: RNG.uniform(0, 60000, n),
    ],
)
def test_records_with_a_fourth_float_are_never_taken_for_coordinates(tmp_path, cloud, fourth, cut):
    xyz = np.asarray(CLOUDS[cloud](), "<f4")
    table = np.c_[xyz, fourth(len(xyz))].astype("<f4")
    data = table.tobytes()
    (tmp_path / "0.bin").write_bytes(data[: len(data) - cut])
    try:
        (frame,) = read(tmp_path / "0.bin")
    except BadInputError:
        return
    assert not cut
    assert frame.intensity is not None


@pytest.mark.parametrize("more", [3, 2, 4, 6])
def test_records_with_other_floats_are_never_taken_for_coordinates(tmp_path, more):
    for normals in (False, True):
        table = RNG.normal(0, 9, (960, 3 + more))
        table[:, :3] = surroundings(960)
        if normals:
            table[:, 3:6] /= np.linalg.norm(table[:, 3:6], axis=1)[:, None]
        (tmp_path / "0.bin").write_bytes(table.astype("<f4").tobytes())
        with pytest.raises(BadInputError, match="none or several"):
            list(read(tmp_path / "0.bin"))


def test_real_scans_are_never_taken_for_coordinates(tmp_path, shared):
    for path in sorted((shared / "realdata").glob("semantickitti_0*/velodyne/*.bin")):
        table = np.fromfile(path, "<f4").reshape(-1, 4)
        for part in (table[:48_000], table[-480:]):
            (tmp_path / "0.bin").write_bytes(part.tobytes())
            (frame,) = read(tmp_path / "0.bin")
            assert np.array_equal(frame.intensity, part[:, 3])
        for part in (table[:48_000, :3], table[-4800:, :3]):
            (tmp_path / "0.bin").write_bytes(part.tobytes())
            (frame,) = read(tmp_path / "0.bin")
            assert np.array_equal(frame.xyz, part)


def test_coordinates_alone_with_labels(tmp_path):
    xyz = surroundings(48)
    (tmp_path / "0.bin").write_bytes(xyz.tobytes())
    (tmp_path / "0.label").write_bytes(np.arange(48, dtype="<u4").tobytes())
    (frame,) = read(tmp_path / "0.bin")
    assert np.array_equal(frame.xyz, xyz)
    assert frame.label.tolist() == list(range(48))


def test_records_of_neither_kind_are_not_guessed(tmp_path):
    (tmp_path / "a.bin").write_bytes(np.full(48, 1e20, "<f4").tobytes())
    with pytest.raises(BadInputError, match="name the format"):
        list(read(tmp_path / "a.bin"))
    (tmp_path / "a.bin").write_bytes(RNG.random((40, 6)).astype("<f4").tobytes())
    with pytest.raises(BadInputError, match="name the format"):
        list(read(tmp_path / "a.bin"))
    (tmp_path / "b.xyzrgb").write_bytes(bytes(25))
    with pytest.raises(BadInputError, match="24 bytes"):
        list(read(tmp_path / "b.xyzrgb"))


@pytest.mark.parametrize("line", ["1 2 3", "1 0 0 0 0 1 0 0 0 0 one 0", "2 0 0 0 0 2 0 0 0 0 2 0"])
def test_poses_that_are_none_raise(tmp_path, line):
    for i in range(2):
        scan(tmp_path / f"{i}.bin")
    (tmp_path / "poses.txt").write_text(line + "\n")
    with pytest.raises(BadInputError, match=r"poses\.txt line 1: expected"):
        open_source([tmp_path])
