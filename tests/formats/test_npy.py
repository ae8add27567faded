"""NumPy files: keys, structured arrays, poses, and files that lie."""

from __future__ import annotations

import io
import zipfile

import numpy as np
import pytest

from pointbrush.errors import BadInputError, TooLargeError
from pointbrush.formats import open_source, read

XYZ = np.arange(12, dtype=np.float32).reshape(4, 3)


def one(path, **kwargs):
    (frame,) = read(path, **kwargs)
    return frame


@pytest.mark.parametrize("key", ["xyz", "points", "pc"])
def test_npz_with_everything(tmp_path, key):
    pose = np.eye(4)
    pose[:3, 3] = 1, 2, 3
    np.savez(
        tmp_path / "a.npz",
        **{key: XYZ.astype(np.float64)},
        colors=np.full((4, 3), 0.5, np.float32),
        intensity=np.arange(4, dtype=np.uint8),
        label=np.arange(4, dtype=np.int64),
        instance=np.arange(4, dtype=np.int32),
        pose=pose,
        timestamp=12.5,
        unknown=np.array(["text"]),
    )
    frame = one(tmp_path / "a.npz")
    assert frame.xyz.dtype == np.float64
    assert frame.rgb.tolist() == [[128] * 3] * 4
    assert frame.intensity.tolist() == frame.label.tolist() == frame.instance.tolist()
    assert frame.pose.tolist() == pose.tolist()
    assert frame.timestamp == 12.5


def test_structured_arrays_and_plain_ones(tmp_path):
    rows = np.zeros(4, [("x", "f4"), ("y", "f4"), ("z", "f4"), ("red", "u1"), ("green", "u1"),
                        ("blue", "u1"), ("label", "u2")])  # fmt: skip
    rows["x"], rows["blue"], rows["label"] = XYZ[:, 0], 9, 3
    np.save(tmp_path / "a.npy", rows)
    frame = one(tmp_path / "a.npy")
    assert frame.xyz[:, 0].tolist() == XYZ[:, 0].tolist()
    assert frame.rgb[0].tolist() == [0, 0, 9]
    assert frame.label.tolist() == [3] * 4
    np.save(tmp_path / "b.npy", np.hstack([XYZ, np.full((4, 3), 255, np.float32)]))
    assert one(tmp_path / "b.npy").rgb.tolist() == [[255] * 3] * 4
    np.save(tmp_path / "m.npy", np.hstack([XYZ, np.full((4, 3), 127.6, np.float32)]))
    assert one(tmp_path / "m.npy").rgb.tolist() == [[128] * 3] * 4
    normals = np.full((4, 3), -0.5, np.float32)
    np.save(tmp_path / "n.npy", np.hstack([XYZ, normals]))
    assert one(tmp_path / "n.npy").rgb is None
    np.save(tmp_path / "i.npy", np.hstack([XYZ, np.full((4, 4), 0.25, np.float32)]))
    assert one(tmp_path / "i.npy").intensity.tolist() == [0.25] * 4
    assert one(tmp_path / "i.npy").rgb.tolist() == [[64] * 3] * 4
    np.save(tmp_path / "c.npy", XYZ.astype(">f8"))
    assert one(tmp_path / "c.npy").xyz.tolist() == XYZ.tolist()


def test_instances_that_do_not_fit_are_left_out_with_a_warning(tmp_path, caplog):
    np.savez(tmp_path / "a.npz", xyz=XYZ, instance=np.array([1, 2, 3, 70_000]))
    assert one(tmp_path / "a.npz").instance.tolist() == [1, 2, 3, 0]
    assert "(70000) have no instance" in caplog.text


def npy_claiming(shape: str) -> bytes:
    text = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode() + bytes(24)


def saved(array, **kwargs) -> bytes:
    out = io.BytesIO()
    np.save(out, array, **kwargs)
    return out.getvalue()


BAD = {
    "empty": (b"", "empty"),
    "magic": (b"hello world of numbers", "NumPy"),
    "cut off": (saved(XYZ)[:-4], "cut off"),
    "claims": (npy_claiming("(100000000, 3)"), "cut off"),
    "pickle": (saved(np.array([{}, 1], object), allow_pickle=True), "pickle"),
    "shape": (saved(np.zeros((100, 100))), "(100, 100)"),
    "text": (saved(np.array([["a", "b", "c"]])), "(N, 3)"),
    "NaN": (saved(np.array([[0, 0, np.inf]])), "infinity"),
    "scalar": (saved(np.float32(1)), "(N, 3)"),
    "complex": (saved(np.zeros((3, 3), complex)), "(N, 3)"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_arrays_say_what_was_expected(tmp_path, case):
    data, message = BAD[case]
    (tmp_path / "bad.npy").write_bytes(data)
    with pytest.raises(BadInputError, match=r"bad\.npy.*expected") as caught:
        one(tmp_path / "bad.npy")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"a": XYZ, "b": XYZ}, "'xyz' or 'points'"),
        ({"xyz": XYZ, "rgb": np.zeros((3, 3), np.uint8)}, "'rgb'"),
        ({"xyz": XYZ, "label": np.zeros(5, np.uint16)}, "'label'"),
        ({"xyz": XYZ, "label": np.full(4, -2)}, "label"),
        ({"xyz": XYZ, "pose": np.eye(3)}, "'pose'"),
    ],
)
def test_archives_whose_arrays_do_not_fit(tmp_path, arrays, message):
    np.savez(tmp_path / "bad.npz", **arrays)
    with pytest.raises(BadInputError, match=r"bad\.npz.*expected") as caught:
        one(tmp_path / "bad.npz")
    assert message in str(caught.value)


def test_a_cut_off_archive_raises(tmp_path):
    np.savez_compressed(tmp_path / "a.npz", xyz=XYZ)
    data = (tmp_path / "a.npz").read_bytes()
    for size in range(0, len(data), 7):
        (tmp_path / "b.npz").write_bytes(data[:size])
        with pytest.raises(BadInputError):
            one(tmp_path / "b.npz")


def test_an_archive_that_unpacks_to_far_more_is_too_large(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_BZIP2) as archive:
        archive.writestr("xyz.npy", saved(np.zeros((1_000_000, 3), np.float32)))
    with pytest.raises(TooLargeError, match="unpack"):
        one(tmp_path / "a.npz")


def test_real_lidar_frames(shared):
    source = open_source([shared / "realdata" / "dgp_scene_01"])
    assert (source.name, source.count, source.fps) == ("dgp_scene_01", 3, 10)
    frames = list(source.frames)
    assert [len(frame) for frame in frames] == [40733, 40523, 40239]
    assert all(frame.label is None for frame in frames)
    assert all(frame.instance.max() > 5 and frame.pose.shape == (4, 4) for frame in frames)


def test_arrays_of_an_archive_that_are_of_no_points_are_not_loaded(tmp_path):
    path = tmp_path / "a.npz"
    mark = np.full((700, 500), 0x5A5A5A5A, np.int32)
    np.savez(path, xyz=np.ones((9, 3), np.float32), ring=np.arange(9), picture=mark)
    data = path.read_bytes()
    path.write_bytes(data.replace(mark.tobytes(), bytes(mark.nbytes)))  # its checksum is wrong now
    (frame,) = read(path)
    assert frame.other["ring"].tolist() == list(range(9))
    assert list(frame.other) == ["ring"]
