"""Depth and colour images: TUM RGB-D, Kinect v2 pairs, intrinsics, and what does not fit."""

from __future__ import annotations

import json

import numpy as np
import pytest
from PIL import Image

from pointbrush.errors import BadInputError
from pointbrush.formats import open_source, read


def image(path, array):
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(array).save(path)
    return path


def depths(width=512, height=424, value=1500):
    depth = np.full((height, width), value, np.uint16)
    depth[0] = 0
    return depth


def colors(width=512, height=424):
    color = np.zeros((height, width, 3), np.uint8)
    color[..., 0] = np.arange(width) % 256
    color[..., 1] = (np.arange(height) % 256)[:, None]
    return color


def test_kinect_2_pairs_in_natural_order(tmp_path):
    for i in (10, 9):
        image(tmp_path / "depth" / f"{i}.png", depths(value=i * 100))
        image(tmp_path / "color" / f"{i}.png", colors())
    source = open_source([tmp_path])
    frames = list(source.frames)
    assert source.count == 2
    assert [round(float(frame.xyz[0, 2]), 3) for frame in frames] == [0.9, 1.0]
    frame = frames[0]
    assert (len(frame), frame.dropped) == (512 * 423, 512)
    camera = frame.camera
    assert (camera.width, camera.height) == (512, 424)
    v, u = np.divmod(frame.pixel, 512)
    # Projected again, each point falls on its own pixel, and has that pixel's colour.
    assert np.allclose(frame.xyz[:, 0] / frame.xyz[:, 2] * camera.fx + camera.cx, u, atol=1e-3)
    assert np.allclose(frame.xyz[:, 1] / frame.xyz[:, 2] * camera.fy + camera.cy, v, atol=1e-3)
    assert np.array_equal(frame.rgb[:, 0], u % 256)
    assert np.array_equal(frame.rgb[:, 1], v % 256)
    assert frame.viewpoint.tolist() == [0, 0, 0]


def tum(root):
    times = [1305031102.175304, 1305031102.211214, 1305031102.243211]
    for name, shift in (("depth", 0.0), ("rgb", 0.005)):
        lines = ["# timestamp filename"]
        for time in times:
            file = f"{name}/{time + shift:.6f}.png"
            array = depths(640, 480, 5000) if name == "depth" else colors(640, 480)
            image(root / file, array)
            lines.append(f"{time + shift:.6f} {file}")
        (root / f"{name}.txt").write_text("\n".join(lines))
    (root / "groundtruth.txt").write_text(
        "".join(f"{time + 0.002:.6f} {i} 0 0 0 0 1 0\n" for i, time in enumerate(times))
    )
    return times


def test_tum_layout_pairs_by_time_and_has_poses(tmp_path):
    root = tmp_path / "rgbd_dataset_freiburg1_xyz"
    times = tum(root)
    source = open_source([tmp_path])
    frames = list(source.frames)
    assert [frame.timestamp for frame in frames] == times
    assert source.fps == pytest.approx(29.5, abs=1)
    assert [frame.pose[0, 3] for frame in frames] == [0, 1, 2]
    assert frames[0].pose[:3, :3].tolist() == [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]
    assert frames[0].camera.fx == 517.3
    assert frames[0].xyz[0, 2] == 1.0
    assert frames[0].rgb[5].tolist() == [5, 1, 0]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("camera.json", json.dumps({"fx": 100, "fy": 110, "cx": 4, "cy": 5, "depth_scale": 500})),
        ("intrinsics.txt", "# fx fy cx cy scale\n100 110\n4 5\n500"),
    ],
)
def test_intrinsics_from_a_file(tmp_path, name, text):
    image(tmp_path / "depth" / "0.png", depths(8, 6, 1000))
    image(tmp_path / "rgb" / "0.png", colors(16, 12))
    (tmp_path / name).write_text(text)
    (frame,) = read(tmp_path)
    assert (frame.camera.fx, frame.camera.fy, frame.camera.cx, frame.camera.cy) == (100, 110, 4, 5)
    assert frame.xyz[0].tolist() == pytest.approx([-4 * 2 / 100, -4 * 2 / 110, 2])
    assert frame.rgb[0].tolist() == [1, 3, 0]


def test_what_does_not_fit_says_so(tmp_path):
    image(tmp_path / "a" / "depth" / "0.png", depths(8, 6))
    with pytest.raises(BadInputError, match=r"camera\.json .* 8x6, got none"):
        open_source([tmp_path / "a"])
    image(tmp_path / "b" / "depth" / "0.png", depths())
    image(tmp_path / "b" / "depth" / "1.png", depths())
    image(tmp_path / "b" / "rgb" / "0.png", colors())
    with pytest.raises(BadInputError, match="each of 2 depth images, got 1"):
        open_source([tmp_path / "b"])
    image(tmp_path / "b" / "rgb" / "1.png", colors(640, 100))
    with pytest.raises(BadInputError, match=r"1\.png: .*512x424 .*got 640x100"):
        list(read(tmp_path / "b"))
    image(tmp_path / "b" / "depth" / "1.png", depths(640, 480))
    with pytest.raises(BadInputError, match=r"512x424 as the first, got 640x480|shape 640x480"):
        list(read(tmp_path / "b"))
    image(tmp_path / "c" / "depth" / "0.png", depths().astype(np.uint8))
    with pytest.raises(BadInputError, match="16 bits, got mode L"):
        list(read(tmp_path / "c"))
    (tmp_path / "c" / "camera.json").write_text('{"fx": -1, "fy": 1, "cx": 1, "cy": 1}')
    with pytest.raises(BadInputError, match="positive fx"):
        open_source([tmp_path / "c"])


def test_a_cut_off_image_raises(tmp_path):
    rng = np.random.default_rng(0)
    whole = image(tmp_path / "depth" / "0.png", rng.integers(1, 9999, (424, 512), np.uint16))
    data = whole.read_bytes()
    for part in (0, 4, 20, 33, 60, len(data) // 2, len(data) - 200):
        whole.write_bytes(data[:part])
        with pytest.raises(BadInputError, match=r"0\.png: expected"):
            list(read(tmp_path))


def test_lists_that_lead_outside_are_refused(tmp_path):
    tum(tmp_path / "run")
    (tmp_path / "run" / "rgb.txt").write_text("1305031102.2 ../secret.png\n")
    (tmp_path / "secret.png").write_bytes(b"x")
    with pytest.raises(BadInputError, match="file within run"):
        open_source([tmp_path / "run"])
