"""Files, folders, globs and archives as recordings: order, times, rates, and what is refused."""

from __future__ import annotations

import io
import tarfile
import zipfile
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pointbrush.errors import BadInputError, ForbiddenError, NotFoundError, TooLargeError
from pointbrush.formats import Limits, open_source, read, reported, source_name


def cloud(path: Path, value: float) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    axes = "".join(f"property float {axis}\n" for axis in "xyz")
    path.write_text(f"ply\nformat ascii 1.0\nelement vertex 1\n{axes}end_header\n{value} 0 0\n")
    return path


def values(*paths: Path, **kwargs) -> list[float]:
    return [float(frame.xyz[0, 0]) for frame in open_source(list(paths), **kwargs).frames]


def test_folders_globs_and_lists_are_in_natural_order(tmp_path):
    files = [cloud(tmp_path / "run" / f"frame{i}.ply", i) for i in (10, 9, 1, 100)]
    (tmp_path / "run" / "notes.json").write_text("{}")
    (tmp_path / "run" / "readme.txt").write_text("hello")
    (tmp_path / "run" / ".hidden.ply").write_text("x")
    assert values(tmp_path / "run") == [1, 9, 10, 100]
    assert values(tmp_path / "run" / "*.ply") == [1, 9, 10, 100]
    assert values(*files) == [1, 9, 10, 100]
    source = open_source([tmp_path / "run"])
    assert (source.name, source.count, source.fps) == ("run", 4, None)


def zipped(target: Path, folder: Path) -> Path:
    with zipfile.ZipFile(target, "w") as archive:
        for path in sorted(folder.rglob("*.*")):
            archive.write(path, path.relative_to(folder.parent))
    return target


def tarred(target: Path, folder: Path) -> Path:
    with tarfile.open(target, "w:gz") as archive:
        archive.add(folder, folder.name)
    return target


@pytest.mark.parametrize("pack", [zipped, tarred])
def test_archives_are_read_and_leave_nothing_behind(tmp_path, pack, monkeypatch):
    for i in (2, 11):
        cloud(tmp_path / "run" / f"{i}.ply", i)
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(scratch))
    archive = pack(tmp_path / ("a.zip" if pack is zipped else "a.tar.gz"), tmp_path / "run")
    assert [frame.xyz[0, 0] for frame in read(archive)] == [2, 11]
    assert list(scratch.iterdir()) == []
    with open_source([archive]) as source:
        assert (source.name, source.count) == ("a", 2)
        assert list(scratch.iterdir()) != []
    assert list(scratch.iterdir()) == []


def test_times_in_names_give_the_rate(tmp_path):
    for i in range(4):
        cloud(tmp_path / f"frame_20121214T1422{i // 10}5.{i}00000.ply", i)
    source = open_source([tmp_path])
    assert source.fps == 10
    stamps = [frame.timestamp for frame in source.frames]
    assert stamps[0] == pytest.approx(1355494925.0)
    assert np.diff(stamps) == pytest.approx(0.1, abs=1e-6)


@pytest.mark.parametrize(
    "lines",
    [
        ["0.2", "0.1", "0.3"],
        ["0.2 0.ply", "0.3 2.ply", "0.1 1.ply"],
        ["# time name", "clouds/1.ply,0.1", "clouds/0.ply,0.2", "clouds/2.ply,0.3"],
        [f"2011-09-26 13:02:25.{t}00000000" for t in (2, 1, 3)],
        ["1500000000200000000", "1500000000100000000", "1500000000300000000"],
    ],
)
def test_a_timestamp_file_decides_the_order(tmp_path, lines):
    for i in range(3):
        cloud(tmp_path / f"{i}.ply", i)
    (tmp_path / "timestamps.txt").write_text("\n".join(lines))
    assert values(tmp_path) == [1, 0, 2]
    assert open_source([tmp_path]).fps == 10


def test_a_timestamp_file_that_does_not_fit_raises(tmp_path):
    for i in range(3):
        cloud(tmp_path / f"{i}.ply", i)
    (tmp_path / "times.txt").write_text("0\n1\n")
    with pytest.raises(BadInputError, match="expected 3 times, one per frame, got 2"):
        open_source([tmp_path])


def test_mixed_formats_are_named(tmp_path):
    cloud(tmp_path / "a.ply", 1)
    np.save(tmp_path / "b.npy", np.zeros((2, 3)))
    with pytest.raises(BadInputError, match=r"one format, got 1 (npy|ply) and 1 (npy|ply)"):
        open_source([tmp_path])
    with pytest.raises(BadInputError, match="npy and ply"):
        open_source([tmp_path / "a.ply", tmp_path / "b.npy"])
    assert values(tmp_path, format="ply") == [1]


def test_the_subfolder_with_the_points_is_found(tmp_path):
    cloud(tmp_path / "one" / "raw" / "0.ply", 1)
    np.savez(cloud(tmp_path / "one" / "npz" / "x.npz", 0), xyz=np.full((1, 3), 2.0))
    assert values(tmp_path / "one") == [1]
    np.savez(cloud(tmp_path / "two" / "raw" / "0.npz", 0), data=np.full((1, 4), 3.0))
    np.savez(cloud(tmp_path / "two" / "npz" / "0.npz", 0), xyz=np.full((1, 3), 4.0))
    assert values(tmp_path / "two") == [4]
    assert open_source([tmp_path / "two" / "npz"]).name == "two"
    with pytest.raises(BadInputError, match=r"one recording, got 2 folders.*one, two"):
        open_source([tmp_path])


@pytest.mark.parametrize(
    ("taken", "other"),
    [
        ("velodyne_points/data/0.ply", "sick_points/data/0.ply"),
        ("lidar/0.ply", "lidar_rear/0.pcd"),
        ("0.ply", "rear/0.ply"),
        ("velodyne/0.ply", "camera/depth/0.png"),
    ],
)
def test_folders_of_other_sensors_are_named(tmp_path, taken, other):
    cloud(tmp_path / "rig" / taken, 1)
    if other.endswith(".png"):
        (tmp_path / "rig" / other).parent.mkdir(parents=True)
        Image.fromarray(np.full((480, 640), 900, np.uint16)).save(tmp_path / "rig" / other)
    else:
        cloud(tmp_path / "rig" / other, 2)
    for harmless in ("labels/0.ply", "calib/0.txt", "raw_pictures/0.npy.md"):
        (tmp_path / "rig" / harmless).parent.mkdir()
        (tmp_path / "rig" / harmless).write_text("")
    with reported() as warnings:
        assert values(tmp_path / "rig") == [1]
    (said,) = warnings
    left_out = other.split("/")[0]
    assert f"left out, as points of another sensor: {left_out}; import these by the path" in said
    assert said.endswith(f"as rig/{left_out}")


def test_points_beside_depth_images_are_named(tmp_path):
    cloud(tmp_path / "rig" / "velodyne" / "0.ply", 1)
    (tmp_path / "rig" / "depth").mkdir()
    Image.fromarray(np.full((424, 512), 900, np.uint16)).save(tmp_path / "rig" / "depth" / "0.png")
    with reported() as warnings, open_source([tmp_path / "rig"]) as source:
        assert source.listings[0].format == "rgbd"
    assert "left out, as points of another sensor: velodyne" in " ".join(warnings)
    assert "rig/velodyne" in " ".join(warnings)


def test_one_recording_in_two_formats_leaves_no_sensor_out(tmp_path):
    cloud(tmp_path / "raw" / "0.ply", 1)
    np.savez(cloud(tmp_path / "npz" / "0.npz", 0), xyz=np.full((1, 3), 1.0))
    with reported() as warnings:
        assert values(tmp_path) == [1]
    assert not warnings


@pytest.mark.parametrize(
    ("paths", "name"),
    [
        (["run/a.copc.laz"], "a"),
        (["run/a.tar.gz"], "a"),
        (["run/a.b.ply"], "a.b"),
        (["run/*.ply"], "run"),
        (["run/0.ply", "run/1.ply"], "run"),
        ([f"{'0af' * 10}12/scan_08.ply", f"{'0af' * 10}12/scan_09.ply"], "scan"),
        ([f"{'0af' * 10}12/8.ply", f"{'0af' * 10}12/9.ply"], "upload"),
    ],
)
def test_names_of_recordings(tmp_path, paths, name):
    assert source_name([tmp_path / path for path in paths]) == name
    (tmp_path / "kitchen" / "raw" / "data").mkdir(parents=True)
    for inner in ("kitchen", "kitchen/raw", "kitchen/raw/data"):
        assert source_name([tmp_path / inner]) == "kitchen"


def test_notes_beside_the_folder_with_the_points_are_no_points(tmp_path):
    cloud(tmp_path / "scans" / "0.ply", 1)
    (tmp_path / "notes.txt").write_text("Dear diary")
    assert values(tmp_path) == [1]
    (tmp_path / "scans" / "0.ply").unlink()
    (tmp_path / "notes.txt").write_text("5 6 7\n")
    assert values(tmp_path) == [5]


def test_what_is_not_there_is_not_found(tmp_path):
    for path in (tmp_path / "no", tmp_path / "*.ply"):
        with pytest.raises(NotFoundError, match="there is no"):
            open_source([path])
    with pytest.raises(BadInputError, match="format: expected one of"):
        open_source([cloud(tmp_path / "a.ply", 1)], "mp3")
    (tmp_path / "empty").mkdir()
    with pytest.raises(BadInputError, match="empty: expected a folder with point cloud files"):
        open_source([tmp_path / "empty"])
    (tmp_path / "a.mp3").write_bytes(b"ID3")
    with pytest.raises(BadInputError, match=r"a\.mp3: expected a file ending in \.ply"):
        open_source([tmp_path / "a.mp3"])


def test_the_first_bytes_tell_where_the_name_does_not(tmp_path):
    assert values(cloud(tmp_path / "upload", 7)) == [7]


@pytest.mark.parametrize("inside", ["link.ply", "sub/link.ply", "sub"])
def test_links_out_of_the_allowed_folders_are_refused(tmp_path, inside):
    cloud(tmp_path / "secret" / "0.ply", 1)
    cloud(tmp_path / "open" / "run" / "0.ply", 2)
    roots = ((tmp_path / "open").resolve(),)
    assert values(tmp_path / "open" / "run", limits=Limits(roots=roots)) == [2]
    link = tmp_path / "open" / "run" / inside
    link.parent.mkdir(exist_ok=True)
    link.symlink_to(tmp_path / "secret" / ("0.ply" if inside.endswith("ply") else ""))
    for path in (tmp_path / "open" / "run", tmp_path / "secret", tmp_path / "open" / "*" / "*"):
        with pytest.raises(ForbiddenError, match="under the folders that may be imported from"):
            open_source([path], limits=Limits(roots=roots))


def hostile_zip(path: Path, name: str, data: bytes = b"x") -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, data)
    return path


@pytest.mark.parametrize(
    "name", ["../evil.ply", "/etc/evil.ply", "a/../../evil.ply", "C:\\evil.ply"]
)
def test_names_that_lead_outside_an_archive_are_refused(tmp_path, name):
    with pytest.raises(BadInputError, match="inside the archive"):
        open_source([hostile_zip(tmp_path / "a.zip", name)])
    assert not (tmp_path.parent / "evil.ply").exists()


def test_links_in_an_archive_are_not_followed(tmp_path):
    with tarfile.open(tmp_path / "a.tar", "w") as archive:
        link = tarfile.TarInfo("a.ply")
        link.type, link.linkname = tarfile.SYMTYPE, "/etc/passwd"
        archive.addfile(link)
    with pytest.raises(BadInputError, match="expected a folder with point cloud files"):
        open_source([tmp_path / "a.tar"])


def test_archives_have_limits(tmp_path):
    archive = hostile_zip(tmp_path / "a.zip", "a.ply", bytes(100_000))
    with pytest.raises(TooLargeError, match="at most 1000 bytes"):
        open_source([archive], limits=Limits(max_unpacked_bytes=1000))
    with pytest.raises(TooLargeError, match="at most 0 files"):
        open_source([archive], limits=Limits(max_files=0))


@pytest.mark.parametrize("pack", [zipped, tarred])
def test_archives_in_an_archive_are_read(tmp_path, pack):
    for i in (2, 11):
        cloud(tmp_path / "run" / f"{i}.ply", i)
    (tmp_path / "outer").mkdir()
    inner = tmp_path / "outer" / ("run.zip" if pack is zipped else "run.tar.gz")
    limit = pack(inner, tmp_path / "run").stat().st_size + 100
    # Of a Mac: what is hidden is no archive.
    (tmp_path / "outer" / "._run.zip").write_bytes(b"extended attributes")
    archive = zipped(tmp_path / "a.zip", tmp_path / "outer")
    assert [frame.xyz[0, 0] for frame in read(archive)] == [2, 11]
    with pytest.raises(TooLargeError, match=r"a\.zip: expected at most 3 files"):
        open_source([archive], limits=Limits(max_files=3))
    with pytest.raises(TooLargeError, match=r"a\.zip: expected at most \d+ bytes"):
        open_source([archive], limits=Limits(max_unpacked_bytes=limit))


def test_archives_that_cannot_be_read_are_called_as_the_user_calls_them(tmp_path):
    cloud(tmp_path / "run" / "1.ply", 1)
    for level in range(6):
        (tmp_path / f"in{level}").mkdir()
        inner = tmp_path / f"in{level}" / f"{level}.zip"
        zipped(inner, tmp_path / (f"in{level - 1}" if level else "run"))
    with pytest.raises(TooLargeError, match=r"5\.zip: expected archives nested at most 3 deep"):
        open_source([inner])
    packed = (tmp_path / "in0" / "0.zip").read_bytes()
    damaged = hostile_zip(tmp_path / "damaged.zip", "b/c.zip", packed[: len(packed) // 2])
    with pytest.raises(BadInputError, match=r"damaged\.zip: expected a whole archive 'c\.zip'"):
        open_source([damaged])
    other = hostile_zip(tmp_path / "other.zip", "paper.pdf")
    with pytest.raises(BadInputError, match=r"^other\.zip: expected a folder with point cloud"):
        open_source([other])


def test_damaged_archives_raise(tmp_path):
    good = hostile_zip(tmp_path / "a.zip", "a.ply", bytes(1000)).read_bytes()
    (tmp_path / "cut.zip").write_bytes(good[: len(good) // 2])
    (tmp_path / "cut.tar.gz").write_bytes(b"\x1f\x8b\x08\x00 not really")
    (tmp_path / "empty.zip").write_bytes(b"")
    for name in ("cut.zip", "cut.tar.gz", "empty.zip"):
        with pytest.raises(BadInputError, match="expected a whole archive"):
            open_source([tmp_path / name])


def test_a_tar_that_claims_more_than_it_holds_is_cut_off(tmp_path):
    info = tarfile.TarInfo("a.ply")
    info.size = 10_000
    out = io.BytesIO()
    out.write(info.tobuf())
    out.write(bytes(512))
    (tmp_path / "a.tar").write_bytes(out.getvalue())
    with pytest.raises(BadInputError):
        open_source([tmp_path / "a.tar"])
