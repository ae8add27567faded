"""Depth and colour images: TUM RGB-D, Kinect v2 pairs, intrinsics, and what does not fit."""

from __future__ import annotations

import json

import numpy as np
import pytest
from PIL import Image

from pointbrush.errors import BadInputError
from pointbrush.formats import open_source, read, reported


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
    # Between the poses 2 ms after each image, whose steps are 36 and 32 ms.
    assert [frame.pose[0, 3] for frame in frames] == pytest.approx(
        [0, 1 - 2 / 36.04, 2 - 2 / 31.999], abs=1e-3
    )
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
    image(tmp_path / "b" / "rgb" / "1.png", colors(640, 100))
    with pytest.raises(BadInputError, match=r"1\.png: .*512x424 .*got 640x100"):
        list(read(tmp_path / "b"))
    image(tmp_path / "b" / "depth" / "1.png", depths(640, 480))
    with pytest.raises(BadInputError, match=r"512x424 as the first, got 640x480|shape 640x480"):
        list(read(tmp_path / "b"))
    image(tmp_path / "c" / "depth" / "0.png", depths().astype(np.uint8))
    with pytest.raises(BadInputError, match="16 bits or floats, got mode L"):
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


CAMERA = {"fx": 8, "fy": 8, "cx": 4, "cy": 3}


def test_marks_of_no_depth_are_no_points(tmp_path):
    depth = np.full((6, 8), 1000, np.uint16)
    depth[:, 0], depth[:, 1] = 65535, 0
    image(tmp_path / "depth" / "0.png", depth)
    metres = np.full((6, 8), 1.0, np.float32)
    metres[0, :6] = [np.nan, np.inf, -1, 0, 65535, 1e10]
    image(tmp_path / "depth" / "1.tiff", metres)
    (tmp_path / "camera.json").write_text(json.dumps(CAMERA))
    whole, real = read(tmp_path)
    assert (len(whole), whole.dropped) == (36, 12)
    assert (len(real), real.dropped) == (42, 6)
    # Floats are metres where no scale is stated, whole numbers are millimetres.
    assert whole.xyz[:, 2].tolist() == [1.0] * 36
    assert real.xyz[:, 2].tolist() == [1.0] * 42


@pytest.mark.parametrize(
    ("scale", "value", "said"),
    [
        (0.001, 1500, r"got 1\.5e\+06 by 0\.001 values per metre; camera\.json: depth_scale is"),
        (1, 1500, "got 1,500 by 1 values per metre"),
        (1, 500, "got 500 by 1 values per metre"),
        (1000, 1.5, r"got 0\.0015 by 1000 values per metre"),
    ],
)
def test_a_scale_of_the_wrong_way_is_refused(tmp_path, scale, value, said):
    image(
        tmp_path / "depth" / "0.tiff",
        np.full((6, 8), value, np.uint16 if isinstance(value, int) else np.float32),
    )
    (tmp_path / "camera.json").write_text(json.dumps({**CAMERA, "depth_scale": scale}))
    with pytest.raises(BadInputError, match=f"0.tiff: expected depths of .* metres, {said}"):
        list(read(tmp_path))


def shades(folder):
    with reported() as warnings:
        frames = list(open_source([folder]).frames)
    found = [None if frame.rgb is None else int(frame.rgb[0, 0]) for frame in frames]
    return found, " ".join(warnings)


@pytest.mark.parametrize(
    ("depth_name", "color_name"),
    [
        ("depth/{:06d}.png", "color/{:06d}.png"),
        ("depth/depth_{:04d}.png", "rgb/rgb_{:04d}.png"),
        ("frame-{:06d}.depth.png", "frame-{:06d}.color.png"),
        ("depth/{:06d}.png", "color/scene{}.png"),
        ("depth/161643123{}.5.png", "color/161643123{}.508.png"),
        ("depth/{}.100.png", "color/{}.108.png"),
    ],
)
def test_lost_images_shift_no_colour(tmp_path, depth_name, color_name):
    for k in (0, 1, 3, 4):
        image(tmp_path / depth_name.format(k), depths(8, 6))
    for k in (0, 2, 3, 4):
        image(tmp_path / color_name.format(k), np.full((6, 8, 3), 20 + 40 * k, np.uint8))
    (tmp_path / "camera.json").write_text(json.dumps(CAMERA))
    found, said = shades(tmp_path)
    assert found == [20, None, 140, 180]
    assert f"1 of 4 depth images have no colour: {depth_name.format(1).split('/')[-1]}" in said
    assert f"have no depth image and are left out: {color_name.format(2).split('/')[-1]}" in said


def test_names_that_tell_no_pairs_are_an_error(tmp_path):
    (tmp_path / "camera.json").write_text(json.dumps(CAMERA))
    for k in range(2):
        image(tmp_path / "depth" / f"{k}.png", depths(8, 6))
        image(tmp_path / "rgb" / f"{k + 7}.png", colors(8, 6))
    with pytest.raises(BadInputError, match=r"frames \(0\.png, 1\.png\), got 7\.png, 8\.png"):
        open_source([tmp_path])
    image(tmp_path / "rgb" / "0.png", colors(8, 6))
    image(tmp_path / "rgb" / "rgb_0.png", colors(8, 6))
    with pytest.raises(BadInputError, match=r"one file a moment, got .*0\.png, .*0\.png"):
        open_source([tmp_path])


def seven_scenes(folder):
    """Names, matrices and sizes of microsoft's 7-Scenes."""
    for k in range(3):
        image(folder / f"frame-{k:06d}.depth.png", depths(640, 480, 1000))
        image(folder / f"frame-{k:06d}.color.png", colors(640, 480))
        pose = np.eye(4)
        pose[0, 3] = k
        np.savetxt(folder / f"frame-{k:06d}.pose.txt", pose, delimiter="\t ")


def test_7_scenes_has_poses_and_its_own_camera(tmp_path):
    seven_scenes(tmp_path / "seq-01")
    frames = list(read(tmp_path / "seq-01"))
    assert [frame.pose[0, 3] for frame in frames] == [0, 1, 2]
    assert (frames[0].camera.fx, frames[0].camera.cx) == (585.0, 320.0)


def test_a_lost_camera_has_no_pose(tmp_path):
    seven_scenes(tmp_path / "seq-01")
    lost = tmp_path / "seq-01" / "frame-000001.pose.txt"
    lost.write_text("-inf " * 16)
    with reported() as warnings:
        frames = list(read(tmp_path / "seq-01"))
    assert [None if frame.pose is None else frame.pose[0, 3] for frame in frames] == [0, None, 2]
    assert "1 of 3 frames have no pose" in " ".join(warnings)


def test_scannet_has_colours_of_another_camera(tmp_path):
    image(tmp_path / "depth" / "0.png", depths(64, 48, 2000))
    # Columns of the colour image tell themselves; its camera looks at twice the angle a pixel.
    image(tmp_path / "color" / "0.jpg", np.full((97, 130, 3), 90, np.uint8))
    (tmp_path / "intrinsic").mkdir()
    depth_camera, color_camera = np.diag([50.0, 50, 1, 1]), np.diag([100.0, 100, 1, 1])
    depth_camera[:2, 2], color_camera[:2, 2] = (32, 24), (130, 48)
    np.savetxt(tmp_path / "intrinsic" / "intrinsic_depth.txt", depth_camera)
    np.savetxt(tmp_path / "intrinsic" / "intrinsic_color.txt", color_camera)
    (tmp_path / "pose").mkdir()
    np.savetxt(tmp_path / "pose" / "0.txt", np.eye(4))
    (frame,) = read(tmp_path)
    assert (frame.camera.fx, frame.camera.cx) == (50, 32)
    assert frame.pose.tolist() == np.eye(4).tolist()
    u = frame.pixel % 64
    # The right half of what depth sees is outside of the picture.
    assert (frame.rgb[u > 32] == 0).all()
    assert (frame.rgb[(u < 30) & (frame.pixel // 64 < 40)] > 80).all()
    (tmp_path / "intrinsic" / "intrinsic_color.txt").unlink()
    (frame,) = read(tmp_path)
    assert (frame.rgb > 80).all(), "a shape that is nearly the same is taken pixel by pixel"


def test_depth_at_twice_the_rate_of_colour_shares_its_images(tmp_path):
    (tmp_path / "camera.json").write_text(json.dumps(CAMERA))
    for k in range(4):
        image(tmp_path / "depth" / f"161643123{k // 2}.{100 + 16 * (k % 2)}.png", depths(8, 6))
    for k in range(2):
        image(tmp_path / "color" / f"161643123{k}.104.png", np.full((6, 8, 3), k, np.uint8))
    assert shades(tmp_path) == ([0, 0, 1, 1], "")


# ── pictures whose names do not say that they are colours ────────────────────────────────────


def with_pictures(folder, depth_name, color_name, size=(8, 6), count=3):
    """Depth images and pictures of the shades 20, 60, 100 …, seen by a known camera."""
    for k in range(count):
        image(folder / depth_name.format(k), depths(8, 6))
        shade = np.full((size[1], size[0], 3), 20 + 40 * k, np.uint8)
        image(folder / color_name.format(k), shade)
    (folder / "camera.json").write_text(json.dumps(CAMERA))
    return folder


def facts(folder):
    with open_source([folder]) as source:
        return source.listings[0].depth


@pytest.mark.parametrize(
    ("depth_name", "color_name"),
    [
        ("{:06d}_d.png", "{:06d}_c.png"),
        ("{:04d}.png", "{:04d}.jpg"),
        ("frame_{:04d}_z.pgm", "frame_{:04d}_left.ppm"),
        ("depth_{:04d}.png", "photo_{:04d}.jpg"),
        ("d-129488636{}.208451-2996770081.pgm", "r-129488636{}.221238-3118787619.ppm"),
        ("frame-{:06d}.depth.png", "frame-{:06d}.jpg"),
        ("depth/{:06d}.png", "left/{:06d}.jpg"),
        ("depth/{:06d}_d.png", "depth/{:06d}_c.png"),
        ("depth/161643123{}.100000.png", "cam0/161643123{}.108000.png"),
        ("depth/161643123{}500.png", "cam0/161643123{}511.png"),
        ("depth_aligned/{:06d}.png", "camera/frame{:06d}.png"),
        ("{:06d}_d.png", "left/{:06d}.png"),
    ],
)
def test_pictures_that_look_like_colours_are(tmp_path, depth_name, color_name):
    folder = with_pictures(tmp_path / "rec", depth_name, color_name)
    assert shades(folder) == ([20, 60, 100], "")
    found = facts(folder)
    assert found.color.endswith(", 3 of 3 frames")
    assert (found.intrinsics, found.unused) == ("camera.json", ())


def test_labels_and_infrared_pictures_are_no_colours(tmp_path):
    folder = with_pictures(tmp_path / "rec", "depth/{:03d}.png", "seg_vis/{:03d}.png")
    for k in range(3):
        image(folder / "ir" / f"{k:03d}.png", colors(8, 6))
        image(folder / "left" / f"{k:03d}.png", np.full((6, 8), 7, np.uint8))
    assert shades(folder) == ([None] * 3, "")
    found = facts(folder)
    assert found.color == "none"
    assert found.unused == ("ir/000.png (3)", "left/000.png (3)", "seg_vis/000.png (3)")


def test_of_several_pictures_those_of_most_frames_are_taken_and_the_others_named(tmp_path):
    folder = with_pictures(tmp_path / "rec", "depth/{:03d}.png", "right/{:03d}.png")
    image(folder / "left" / "001.png", colors(8, 6))
    found, said = shades(folder)
    assert found == [20, 60, 100]
    assert "rec: pictures are left unused: left/001.png (1)" in said
    # A folder that is named so is taken in any case.
    image(folder / "rgb" / "002.png", np.full((6, 8, 3), 200, np.uint8))
    found, said = shades(folder)
    assert found == [None, None, 200]
    assert "left/001.png (1), right/000.png (3)" in said


def test_pictures_that_do_not_fit_are_named_with_the_reason(tmp_path):
    folder = with_pictures(tmp_path / "rec", "depth/{:03d}.png", "left/{:03d}.png", (64, 6))
    image(folder / "right" / "7.png", colors(8, 6))
    image(folder / "thumbnail.jpg", colors(8, 6))
    found, said = shades(folder)
    assert found == [None] * 3
    assert "left/000.png (3): the pictures of 64x6 have not the shape" in said
    assert "intrinsic_color.txt" in said
    assert "right/7.png (1): expected files with the names, times or numbers" in said
    assert facts(folder).color == "none"
    # By the matrix of the colour camera any shape is seen.
    np.savetxt(folder / "intrinsic_color.txt", np.array([[8.0, 0, 32], [0, 8, 3], [0, 0, 1]]))
    assert shades(folder)[0] == [20, 60, 100]


def test_intrinsics_that_are_assumed_are_stated(tmp_path):
    for k in range(2):
        image(tmp_path / "depth" / f"{k}.png", depths())
        image(tmp_path / "color" / f"{k}.png", colors())
    with reported() as warnings:
        found = facts(tmp_path)
    assert (found.color, found.intrinsics) == (
        "color, 2 of 2 frames", "assumed: those of a Kinect v2",
    )  # fmt: skip
    assert "the intrinsics are assumed, those of a Kinect v2, by the size 512x424" in next(
        iter(warnings)
    )


def test_one_of_two_depth_cameras_is_chosen_by_its_folder(tmp_path):
    rig = tmp_path / "rig"
    for shift, side in enumerate(("front", "rear")):
        with_pictures(rig, f"depth_{side}/{{:03d}}.png", f"color_{side}/{{:03d}}.png")
        for k in range(3):
            shade = np.full((6, 8, 3), 20 + 40 * k + shift, np.uint8)
            image(rig / f"color_{side}" / f"{k:03d}.png", shade)
    with pytest.raises(BadInputError, match=r"2 folders .*\(depth_front, depth_rear\)"):
        open_source([rig])
    assert shades(rig / "depth_rear") == ([21, 61, 101], "")
    (rig / "depth_front").rename(rig / "depth")
    _, said = shades(rig)
    assert "rig: pictures are left unused: " in said
    assert "depth_rear/000.png (3)" in said
    assert "imported by its path" in said


def test_times_of_a_list_that_are_set_back_keep_its_order(tmp_path):
    tum(tmp_path)
    for name in ("depth", "rgb"):
        lines = (tmp_path / f"{name}.txt").read_text().splitlines()[1:]
        times = [3599.9, 0.0, 0.1, 0.2]
        rows = [f"{time} {lines[k % 3].split()[1]}" for k, time in enumerate(times)]
        (tmp_path / f"{name}.txt").write_text("\n".join(rows))
    (tmp_path / "groundtruth.txt").unlink()
    with reported() as warnings, open_source([tmp_path]) as source:
        assert [frame.timestamp for frame in source.frames] == [3599.9, 0.0, 0.1, 0.2]
        assert source.fps == 10
    assert "depth.txt: ordered by line in depth.txt, the times go back 1 times" in " ".join(
        warnings
    )
