"""Boxes as other tools write them, each by the rules of its own source."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import feather

from pointbrush.errors import BadInputError
from pointbrush.formats.boxes.figures import FrameBox, PointFigure, instance_numbers
from pointbrush.formats.boxes.registry import is_box_file, read_boxes

ANGLES = np.array([-0.3, 0.2, 1.45])
CENTER, SIZE = np.array([5.0, -20.0, 1.0]), np.array([10.0, 2.4, 3.0])
KEY = "0a7e1f52-77aa-4c6e-8c59-111111111111"


def about(axis: int, angle: float) -> np.ndarray:
    turned = np.eye(3)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    turned[first, first] = turned[second, second] = np.cos(angle)
    turned[second, first], turned[first, second] = np.sin(angle), -np.sin(angle)
    return turned


RX, RY, RZ = (about(axis, angle) for axis, angle in enumerate(ANGLES))
FIXED, THREE = RZ @ RY @ RX, RX @ RY @ RZ


def xyz(values: np.ndarray) -> dict[str, float]:
    return dict(zip("xyz", map(float, values), strict=True))


def write(path: Path, content: Any) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content), "utf-8")
    return path


def only(path: Path, format: str) -> FrameBox:
    assert is_box_file(path, format)
    (part,) = read_boxes(path, format)
    (box,) = part.boxes
    assert isinstance(box, FrameBox)
    return box


def labelcloud(folder: Path, stated: str, angles: np.ndarray) -> Path:
    write(folder / "_classes.json", {"classes": [], "format": stated})
    sides = dict(zip(("length", "width", "height"), SIZE.tolist(), strict=True))
    place = {"centroid": xyz(CENTER), "dimensions": sides, "rotations": xyz(angles)}
    return write(folder / "0.json", {"objects": [{"name": "cart", **place}]})


def test_labelcloud_states_its_unit_of_angles(tmp_path: Path) -> None:
    """labelCloud/io/labels/centroid.py, utils/math3d.py: rotate_around_zyx."""
    radians = labelcloud(tmp_path / "rel", "centroid_rel", np.abs(ANGLES))
    degrees = labelcloud(tmp_path / "abs", "centroid_abs", np.degrees(np.abs(ANGLES)))
    turned = [about(axis, abs(angle)) for axis, angle in enumerate(ANGLES)]
    for path in (radians, degrees):
        box = only(path, "labelcloud")
        assert np.allclose(box.rotation, turned[2] @ turned[1] @ turned[0])
        assert np.allclose(box.size, SIZE)


def test_labelcloud_corners_are_a_turned_box(tmp_path: Path) -> None:
    """labelCloud/model/bbox.py: set_axis_aligned_verticies, get_vertices."""
    signs = [(-1, -1), (-1, 1), (1, 1), (1, -1)]
    corners = np.array([(x, y, z) for z in (-1, 1) for x, y in signs]) * SIZE / 2
    objects = [{"name": "cart", "vertices": (corners @ FIXED.T + CENTER).tolist()}]
    box = only(write(tmp_path / "0.json", {"objects": objects}), "labelcloud")
    assert np.allclose(box.rotation, FIXED)
    assert np.allclose(box.center, CENTER)
    assert np.allclose(box.size, SIZE)


def test_labelcloud_untransformed_kitti_is_in_the_points_coordinates(tmp_path: Path) -> None:
    """labelCloud/io/labels/kitti.py: the centre, and the angle about z."""
    write(tmp_path / "_classes.json", {"classes": [], "format": "kitti_untransformed"})
    path = tmp_path / "0.txt"
    path.write_text("cart 0 0 0 0 0 0 0 3 2.4 10 5 -20 1 1.45\n")
    box = only(path, "kitti-object")
    assert np.allclose(box.rotation, RZ)
    assert np.allclose(box.center, CENTER)
    assert np.allclose(box.size, SIZE)


def figures(key: str) -> dict[str, Any]:
    geometry = {"position": xyz(CENTER), "rotation": xyz(ANGLES), "dimensions": xyz(SIZE)}
    figure = {"key": "f", "objectKey": key, "geometryType": "cuboid_3d", "geometry": geometry}
    return {"objects": [{"key": key, "classTitle": "bus"}], "figures": [figure]}


def test_tools_of_three_js_turn_about_the_axes_that_have_turned(tmp_path: Path) -> None:
    """SUSTechPOINTS public/js/util.js (euler_angle_to_rotate_matrix), CVAT
    cvat-canvas3d/src/typescript/cuboid.ts, Xtreme1 pc-editor/utils/result.ts."""
    psr = {"position": xyz(CENTER), "rotation": xyz(ANGLES), "scale": xyz(SIZE)}
    contour = {"center3D": xyz(CENTER), "rotation3D": xyz(ANGLES), "size3D": xyz(SIZE)}
    listed = {"position": CENTER.tolist(), "rotation": ANGLES.tolist(), "scale": SIZE.tolist()}
    item = {"type": "cuboid_3d", "label_id": 0, "attributes": {"track_id": 4}, **listed}
    found = {
        "sustechpoints": [{"obj_id": "4", "obj_type": "bus", "psr": psr}],
        "xtreme1": [{"objects": [{"className": "bus", "trackId": "x", "contour": contour}]}],
        "datumaro": {
            "categories": {"label": {"labels": [{"name": "bus"}]}},
            "items": [{"id": "f1", "annotations": [item]}],
        },
        "supervisely": figures(KEY),
    }
    for format, content in found.items():
        box = only(write(tmp_path / f"{format}.json", content), format)
        assert np.allclose(box.rotation, THREE), format
        assert np.allclose(box.center, CENTER)
        assert np.allclose(box.size, SIZE)
        assert (box.name, bool(box.key)) == ("bus", True)
        others = found.keys() - {format}
        assert not [name for name in others if is_box_file(tmp_path / f"{format}.json", name)]


def test_supervisely_turns_about_fixed_axes(tmp_path: Path) -> None:
    """supervisely/convert/pointcloud_episodes/kitti_360/kitti_360_helper.py: as_euler("xyz")."""
    box = only(write(tmp_path / "0.json", figures(KEY.replace("-", ""))), "supervisely")
    assert np.allclose(box.rotation, FIXED)


def test_an_episode_of_supervisely_names_its_frames_and_marks_points(tmp_path: Path) -> None:
    """supervisely/project/pointcloud_episode_project.py, geometry/pointcloud.py."""
    write(tmp_path / "frame_pointcloud_map.json", {"0": "c.pcd", "1": "a.pcd"})
    mask = {"objectKey": "k", "geometryType": "point_cloud", "geometry": {"indices": [3, 5]}}
    objects = [{"key": "k", "classTitle": "tree"}]
    content = {"objects": objects, "frames": [{"index": 0, "figures": [mask]}]}
    (part,) = read_boxes(write(tmp_path / "annotation.json", content), "supervisely")
    (figure,) = part.boxes
    assert part.frame == "c.pcd"
    assert isinstance(figure, PointFigure)
    assert figure.rows.tolist() == [3, 5]


TRACKLET = """<boost_serialization><tracklets><item><objectType>bus</objectType><h>2.4</h>
<w>10</w><l>3</l><first_frame>3</first_frame><poses><item_version>0</item_version>{}</poses></item>
</tracklets></boost_serialization>"""
POSE = "<item><tx>5</tx><ty>-20</ty><tz>1</tz><rx>-0.3</rx><ry>0.2</ry><rz>1.45</rz>{}</item>"


def test_tracklets_of_cvat_have_centres_names_and_gaps(tmp_path: Path) -> None:
    """datumaro/plugins/kitti_raw_format/converter.py: w, h, l are x, y, z of the scale."""
    path = tmp_path / "tracklet_labels.xml"
    hidden = POSE.format("<truncation>2</truncation>")
    path.write_text(TRACKLET.format(hidden + POSE.format("<truncation>0</truncation>")))
    (tmp_path / "frame_list.txt").write_text("3 left\n4 right turn\n")
    (part,) = read_boxes(path, "kitti-tracklets")
    (box,) = part.boxes
    assert part.frame == "right turn"
    assert isinstance(box, FrameBox)
    assert np.allclose(box.center, CENTER)
    assert np.allclose(box.size, SIZE)
    assert np.allclose(box.rotation, THREE)


def test_cuboids_of_argoverse_are_told_by_their_time(tmp_path: Path) -> None:
    """av2-api src/av2/structures/cuboid.py: dst_SE3_object, length along x."""
    half = ANGLES[2] / 2
    columns = {"qw": [np.cos(half)], "qx": [0.0], "qy": [0.0], "qz": [np.sin(half)]}
    columns |= {
        f"{name}_m": [value] for name, value in zip(("tx", "ty", "tz"), CENTER, strict=True)
    }
    columns |= {f"{n}_m": [v] for n, v in zip(("length", "width", "height"), SIZE, strict=True)}
    named = {"track_uuid": ["u-1"], "category": ["BUS"]}
    path = tmp_path / "annotations.feather"
    feather.write_feather(
        pa.table({"timestamp_ns": [315966265359836000], **named, **columns}), path
    )
    (part,) = read_boxes(path, "argoverse")
    (box,) = part.boxes
    assert part.time == pytest.approx(315966265.359836)
    assert isinstance(box, FrameBox)
    assert (box.name, box.key) == ("BUS", "u-1")
    assert np.allclose(box.rotation, RZ)


def wxyz(axis: int, angle: float) -> list[float]:
    """Quaternion of a turn about an axis."""
    turn = [np.cos(angle / 2), 0.0, 0.0, 0.0]
    turn[1 + axis] = np.sin(angle / 2)
    return turn


def test_boxes_of_nuscenes_come_in_the_coordinates_of_the_scanner(tmp_path: Path) -> None:
    """nuscenes-devkit docs/schema_nuscenes.md, python-sdk/nuscenes/utils/data_classes.py: a
    sample's boxes in the world, width length height, quaternion w x y z."""
    world = np.array([411.0, 1180.0, 0.5])
    tables = {
        "category": [{"token": "c", "name": "vehicle.car", "index": 17}],
        "instance": [{"token": "i", "category_token": "c"}],
        "ego_pose": [{"token": "e", "translation": world.tolist(), "rotation": wxyz(2, 0.7)}],
        "calibrated_sensor": [{"token": "l", "translation": [0, 0, 1.8], "rotation": wxyz(1, 0.1)}],
        "sample_data": [
            {
                "filename": f"{folder}/{place}/x.bin",
                "sample_token": "s",
                "ego_pose_token": "e",
                "calibrated_sensor_token": "l",
                "is_key_frame": folder == "samples",
                "timestamp": 1533151603547590,
            }
            for folder in ("samples", "sweeps")
            for place in ("LIDAR_TOP", "CAM_FRONT")
        ],
    }
    R = about(2, 0.7) @ about(1, 0.1)
    length, width, height = SIZE.tolist()
    tables["sample_annotation"] = [
        {
            "token": "a",
            "sample_token": "s",
            "instance_token": "i",
            "translation": (R @ CENTER + about(2, 0.7) @ [0, 0, 1.8] + world).tolist(),
            "size": [width, length, height],
            "rotation": wxyz(2, 1.45),
        }
    ]
    for name, rows in tables.items():
        write(tmp_path / "v1.0-mini" / f"{name}.json", rows)
    path = tmp_path / "v1.0-mini" / "sample_annotation.json"
    found = [name for name in tables if is_box_file(path.with_stem(name), "nuscenes-boxes")]
    assert found == ["sample_annotation"]
    (part,) = read_boxes(path, "nuscenes-boxes")
    (box,) = part.boxes
    assert part.time == pytest.approx(1533151603.54759)
    assert isinstance(box, FrameBox)
    assert (box.name, box.key) == ("vehicle.car", "i")
    assert np.allclose(box.center, CENTER)
    assert np.allclose(box.size, SIZE)
    assert np.allclose(box.rotation, R.T @ about(2, 1.45))


@pytest.mark.parametrize("every_camera", [False, True])
def test_waymo_in_the_form_of_kitti(tmp_path: Path, every_camera: bool) -> None:
    """waymo_kitti_converter converter.py, save_label and save_calib: x ahead of the vehicle becomes
    z of the camera; the bottom's middle; heading about z as -heading - pi / 2 about y."""
    R_cam_front = np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]])
    mount = np.array([1.5, 0.1, 2.1])
    length, width, height = SIZE.tolist()
    x, y, z = R_cam_front @ (CENTER - [0, 0, height / 2] - mount)
    row = f"Car 0 0 -10 0 0 0 0 {height} {width} {length} {x} {y} {z} {-ANGLES[2] - np.pi / 2}"
    (tmp_path / "label_all").mkdir()
    (tmp_path / "calib").mkdir()
    path = tmp_path / "label_all" / "0000001.txt"
    path.write_text(row + (" 0 ZFpMuZ1cWW\n" if every_camera else "\n"))
    T = np.column_stack([R_cam_front, -R_cam_front @ mount])
    numbers = " ".join(map(str, T.ravel()))
    name = "Tr_velo_to_cam_0" if every_camera else "Tr_velo_to_cam"
    (tmp_path / "calib" / path.name).write_text(f"R0_rect: 1 0 0 0 1 0 0 0 1\n{name}: {numbers}\n")
    box = only(path, "kitti-object")
    assert np.allclose(box.center, CENTER)
    assert np.allclose(box.size, SIZE)
    assert np.allclose(box.rotation[:, 0], RZ[:, 0])
    assert box.key == ("ZFpMuZ1cWW" if every_camera else "")


@pytest.mark.parametrize("name", ["traffic-cone", "Truck2", "汽车"])
def test_names_of_kitti_are_any_word(tmp_path: Path, name: str) -> None:
    row = "0 0 -10 -1 -1 -1 -1 2 2 2 0 1 10 -1.57"
    (tmp_path / "a.txt").write_text(f"0 1 {name} {row}\n", "utf-8")
    (tmp_path / "b.txt").write_text(f"{name} {row}\n", "utf-8")
    told = [
        [is_box_file(tmp_path / f"{file}.txt", f"kitti-{kind}") for kind in ("tracking", "object")]
        for file in "ab"
    ]
    assert told == [[True, False], [False, True]]


def test_numbers_of_objects_are_those_of_their_keys() -> None:
    def mark(key: str) -> PointFigure:
        return PointFigure("car", key, np.zeros(0, np.int64))

    keys = ("a", "2", "", "b", "a", "0")
    assert instance_numbers(map(mark, keys)) == {"a": 1, "2": 2, "": 0, "b": 3, "0": 4}


def test_another_document_is_refused_by_name(tmp_path: Path) -> None:
    path = write(tmp_path / "0.json", {"objects": [{"name": "car", "bbox": [1, 2]}]})
    for format in ("labelcloud", "sustechpoints", "supervisely", "datumaro"):
        with pytest.raises(BadInputError, match=f"0.json: expected {format} boxes"):
            read_boxes(path, format)
