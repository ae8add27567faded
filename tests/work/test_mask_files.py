"""Masks of pictures in files label points; labels leave as masks and come back."""

from __future__ import annotations

import io
import json
import re
import shutil
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from pointbrush.errors import BadInputError
from pointbrush.formats.cameras.pictures import Camera, PictureSource, picture
from pointbrush.formats.times.matching import Origin
from pointbrush.frame import DepthCamera, FramePart, PointFrame, Sensor, join_sensors
from pointbrush.labels import Label, Write
from pointbrush.labels.classes.palette import default_color
from pointbrush.labels.types import IMPORTED, PAINTED
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.settings import Settings
from pointbrush.values.masks import VOID
from pointbrush.workspace import Workspace
from tests.serving import with_labels
from tests.waiting import PATIENCE

FRAMES = 2
WIDTH, HEIGHT, FOCAL = 64, 48, 50.0
"""The depth camera."""
K = np.array([[400.0, 0, 320], [0, 400, 240], [0, 0, 1]])
SIZE = (640, 480)
"""Width and height of pictures of the lidar's cameras."""
AHEAD = np.array([[0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0], [0, 0, 0, 1.0]])
"""From a scanner (x ahead, z up) to a camera at its place (z ahead, y down)."""
CAR, MAN, GROUND = 1, 2, 3


def looking(side: float, up: float) -> NDArray[np.float64]:
    """Return ``T_camera_frame`` of a camera at some metres to the left of the lidar and above."""
    T = AHEAD.copy()
    T[:3, 3] = -AHEAD[:3, :3] @ [0.0, side, up]
    return T


CAMERAS = (
    Camera("front", K, looking(0.3, -0.2)),
    Camera("image_02", K, looking(-0.4, -0.1)),
    Camera("blind", None, None),
)


def depth_frame(index: int) -> tuple[PointFrame, NDArray[np.uint16]]:
    """A depth image with holes, of a man before a wall and a floor; and its labels."""
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    man = (abs(u - 20 - 5 * index) < 6) & (v > 10) & (v < 40)
    z = np.where(man, 1.5, np.where(v > 35, 2.0, 3.0))
    holes = np.random.default_rng(index).random((HEIGHT, WIDTH)) < 0.1
    label = np.where(man, MAN, np.where(v > 35, GROUND, 0))
    pixel = np.flatnonzero(~holes)
    z, u, v = (array.ravel()[pixel] for array in (z, u, v))
    xyz = np.column_stack([(u - WIDTH / 2) * z / FOCAL, (v - HEIGHT / 2) * z / FOCAL, z])
    camera = DepthCamera(WIDTH, HEIGHT, FOCAL, FOCAL, WIDTH / 2, HEIGHT / 2)
    frame = PointFrame(
        xyz.astype(np.float32), viewpoint=np.zeros(3), camera=camera, pixel=pixel.astype(np.uint32)
    )
    return frame, label.ravel()[pixel].astype(np.uint16)


def lidar_frame(index: int) -> tuple[PointFrame, NDArray[np.uint16]]:
    """A lidar of 48 lines that sees a car and a man before a wall, on the ground; and labels."""
    azimuth, elevation = np.meshgrid(
        np.radians(np.arange(-40.1, 40, 0.25)), np.radians(np.linspace(-20, 6, 48))
    )
    rays = np.column_stack(
        [
            (np.cos(azimuth) * np.cos(elevation)).ravel(),
            (np.sin(azimuth) * np.cos(elevation)).ravel(),
            np.sin(elevation).ravel(),
        ]
    )
    reach = 15 / rays[:, 0]
    label = np.zeros(len(rays), np.uint16)
    with np.errstate(divide="ignore"):
        down = np.where(rays[:, 2] < 0, -1.7 / rays[:, 2], np.inf)
    label[down < reach], reach = GROUND, np.minimum(reach, down)
    for kind, low, high in (
        (CAR, [7.0, -3 + index, -1.7], [10.0, -1 + index, -0.2]),
        (MAN, [6.0, 1.5, -1.7], [6.4, 2.1, 0.1]),
    ):
        with np.errstate(divide="ignore"):
            near, far = (np.array(side) / rays for side in (low, high))
        enter, leave = np.minimum(near, far).max(axis=1), np.maximum(near, far).min(axis=1)
        hit = (enter <= leave) & (enter > 0) & (enter < reach)
        label[hit], reach[hit] = kind, enter[hit]
    return PointFrame((rays * reach[:, None]).astype(np.float32), viewpoint=np.zeros(3)), label


def mounted_frame(index: int) -> tuple[PointFrame, NDArray[np.uint16]]:
    """The lidar with the depth camera two metres ahead of it; and the labels of both."""
    (lidar, of_lidar), (depth, of_depth) = lidar_frame(index), depth_frame(index)
    ahead = np.linalg.inv(AHEAD)
    ahead[0, 3] = 2.0
    parts = [(FramePart(0, np.eye(4)), lidar), (FramePart(1, ahead), depth)]
    rig = (Sensor("roof", "spinning"), Sensor("hand", "depth"))
    return join_sensors(rig, parts), np.concatenate([of_lidar, of_depth])


def photograph(size: tuple[int, int]) -> bytes:
    packed = io.BytesIO()
    Image.new("RGB", size, (90, 90, 90)).save(packed, "JPEG")
    return packed.getvalue()


Truth = Callable[[int], tuple[PointFrame, NDArray[np.uint16]]]
KINDS: dict[str, Truth] = {"kinect": depth_frame, "lidar": lidar_frame, "mounted": mounted_frame}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A workspace with recordings of a depth camera and of a lidar with cameras, twice each, and
    one of both."""
    folder = tmp_path_factory.mktemp("made")
    photo = photograph(SIZE)

    def pictures() -> Iterator[Any]:
        for frame in range(FRAMES):
            for camera in CAMERAS:
                yield picture(frame, camera, photo, "photo")

    taken = dict.fromkeys(("lidar", "mounted"), PictureSource(CAMERAS, pictures))
    for name in KINDS:
        for suffix in ("", "-again")[: 1 if name == "mounted" else 2]:
            import_frames(
                (KINDS[name](frame)[0] for frame in range(FRAMES)),
                folder / "sequences" / f"{name}{suffix}",
                RecordingInfo(
                    f"{name}{suffix}",
                    name,
                    10.0,
                    origins=[Origin(f"{frame:06d}.bin") for frame in range(FRAMES)],
                ),
                pictures=taken.get(name),
            )
    return folder


@pytest.fixture
def workspace(made: Path, tmp_path: Path) -> Iterator[Workspace]:
    shutil.copytree(made, tmp_path / "ws")
    with closing(Workspace(with_labels(Settings(workspace=tmp_path / "ws")))) as opened:
        yield opened


def edit(workspace: Workspace, sequence: str, added: list[Label], writes: dict[int, Write]) -> None:
    """Commit an edit."""
    workspace.labels.apply(
        sequence,
        edit_id=str(uuid4()),
        author="ann",
        kind="label",
        writes=lambda _: (added, writes),
        summary="",
    )


def painted(workspace: Workspace, sequence: str) -> None:
    """Paint the true labels; ids of labels are those of the scenes."""
    labels = [
        Label(CAR, "car 1", "car", default_color(CAR)),
        Label(MAN, "Ännä", "man", default_color(MAN)),
        Label(GROUND, "ground", "", default_color(GROUND)),
    ]
    edit(workspace, sequence, labels, {})
    for frame in range(FRAMES):
        workspace.annotations.put(sequence, frame, KINDS[sequence](frame)[1], author="ann")


def labels(workspace: Workspace, sequence: str, frame: int) -> NDArray[np.str_]:
    """Return the name of each point's label, source order."""
    names = {0: ""} | {label.id: label.name for label in workspace.labels.palette(sequence)}
    ids = workspace.annotations.read(sequence, frame)[0]
    return np.array([names[each] for each in ids.tolist()])


def run(workspace: Workspace, place: Path, sequence: str, **options: Any) -> Any:
    job = workspace.imports.begin_labels(sequence, place, "me", **options)
    return workspace.runner.wait(job.id, PATIENCE)


@pytest.mark.parametrize("kind", ["masks-png", "masks-coco"])
def test_labels_of_a_depth_camera_come_back_equal(
    workspace: Workspace, tmp_path: Path, kind: str
) -> None:
    painted(workspace, "kinect")
    deleted = np.zeros(len(depth_frame(1)[1]), np.bool_)
    deleted[::7] = True
    workspace.annotations.put("kinect", 1, deleted, layer="deleted", author="ann")
    workspace.export("kinect", kind, tmp_path / "out.zip")
    done = run(workspace, tmp_path / "out.zip", "kinect-again")
    assert done.state == "done", done.error
    assert done.result["doubtful"] == 0
    for frame in range(FRAMES):
        expected = labels(workspace, "kinect", frame)
        if frame == 1:
            expected[deleted] = ""
        assert (labels(workspace, "kinect-again", frame) == expected).all()
    assert {(each.name, each.category) for each in workspace.labels.palette("kinect-again")} == {
        ("Ännä", "man"), ("ground", ""),
    }  # fmt: skip


@pytest.mark.parametrize("kind", ["masks-png", "masks-coco"])
def test_labels_of_a_lidar_come_back_without_errors(
    workspace: Workspace, tmp_path: Path, kind: str
) -> None:
    painted(workspace, "lidar")
    workspace.export("lidar", kind, tmp_path / "out", frames="1:2")
    done = run(workspace, tmp_path / "out", "lidar-again")
    assert done.state == "done", done.error
    assert [each["frame"] for each in done.result["frames"]] == [1]
    truth, found = (labels(workspace, name, 1) for name in ("lidar", "lidar-again"))
    assert ((found == "") | (found == truth)).all()
    assert 0.9 * np.count_nonzero(truth) <= np.count_nonzero(found)
    assert workspace.labels.undo("lidar-again", "me")
    assert not (labels(workspace, "lidar-again", 1) != "").any()


def test_png_masks_are_images_of_labels_and_classes(workspace: Workspace, tmp_path: Path) -> None:
    painted(workspace, "kinect")
    workspace.export("kinect", "masks-png", tmp_path / "out")
    with Image.open(tmp_path / "out" / "labels" / "depth" / "000000.png") as image:
        indices, color = np.asarray(image), image.convert("RGB").getpixel((20, 20))
    frame, label = depth_frame(0)
    assert (indices.ravel()[frame.pixel] == label).all()
    assert (np.delete(indices.ravel(), frame.pixel) == 255).all()
    assert "#{:02x}{:02x}{:02x}".format(*color) == default_color(MAN)
    numbers = json.loads((tmp_path / "out" / "classes.json").read_text())
    with Image.open(tmp_path / "out" / "classes" / "depth" / "000000.png") as image:
        assert (np.asarray(image)[indices == MAN] == numbers["man"]).all()


def test_ids_above_254_make_masks_of_16_bits(workspace: Workspace, tmp_path: Path) -> None:
    far = Label(1000, "far", "wall", "#102030")
    edit(workspace, "kinect", [far], {})
    frame, _ = depth_frame(0)
    workspace.annotations.put("kinect", 0, np.full(len(frame.xyz), far.id, np.uint16), author="ann")
    workspace.export("kinect", "masks-png", tmp_path / "out")
    with Image.open(tmp_path / "out" / "labels" / "depth" / "000000.png") as image:
        assert set(np.unique(np.asarray(image)).tolist()) == {1000, VOID}
    done = run(workspace, tmp_path / "out", "kinect-again")
    assert done.state == "done", done.error
    assert (labels(workspace, "kinect-again", 0) == "far").all()


def test_coco_masks_have_tracks_areas_and_boxes(workspace: Workspace, tmp_path: Path) -> None:
    painted(workspace, "lidar")
    workspace.export("lidar", "masks-coco", tmp_path / "out")
    document = json.loads((tmp_path / "out" / "annotations.json").read_text())
    assert [each["file_name"] for each in document["images"]] == [
        f"{camera}/{frame:06d}.jpg" for frame in range(2) for camera in ("front", "image_02")
    ]
    names = {each["id"]: each["name"] for each in document["categories"]}
    first = [each for each in document["annotations"] if each["image_id"] == 1]
    assert {(each["track_id"], names[each["category_id"]]) for each in first} == {
        (CAR, "car"), (MAN, "man"), (GROUND, "ground"),
    }  # fmt: skip
    (man,) = (each for each in first if each["track_id"] == MAN)
    x, y, width, height = man["bbox"]
    assert 0.7 * width * height < man["area"] <= width * height
    assert 150 < x < 320 < y + height


def masks_in(place: Path) -> dict[str, list[Any]]:
    """The masks of labels of an export, by their file names."""
    place = place / "labels"
    return {
        path.relative_to(place).as_posix(): np.asarray(Image.open(path)).tolist()
        for path in place.rglob("*.png")
    }


def test_masks_of_one_of_several_sensors_have_only_its_points(
    workspace: Workspace, tmp_path: Path
) -> None:
    """They are those of a recording of this sensor alone, and no depth image of another."""
    found = {}
    for name in KINDS:
        painted(workspace, name)
        for sensor in ("roof", "hand") if name == "mounted" else (None,):
            out = tmp_path / (sensor or name)
            workspace.export(name, "masks-png", out, sensor=sensor)
            found[sensor or name] = masks_in(out)
    assert found["roof"] == found["lidar"]
    of_depth = {name.replace("-hand", ""): mask for name, mask in found["hand"].items()}
    assert of_depth.keys() == found["kinect"].keys() | found["lidar"].keys()
    for name, mask in found["kinect"].items():
        assert of_depth[name] == mask


def of_pixels(folder: Path, value: int, frames: int = FRAMES, size: tuple[int, int] = SIZE) -> None:
    """Write masks that are wholly of one class."""
    folder.mkdir(parents=True)
    for frame in range(frames):
        Image.new("L", size, value).save(folder / f"{frame:06d}.png")


def paint_some(workspace: Workspace) -> NDArray[np.int64]:
    """Paint every tenth point of the lidar's first frame as "kept"; returns their numbers."""
    kept = workspace.labels.create_label("lidar", "ann", name="kept").id
    stored = workspace.recording("lidar")[0]
    numbers = np.arange(0, stored.count, 10)
    edit(workspace, "lidar", [], {0: Write(numbers, label=kept, provenance=PAINTED)})
    return np.sort(stored.source_index[numbers]).astype(np.int64)


def test_masks_of_several_cameras_are_one_edit_and_painted_points_win(
    workspace: Workspace, tmp_path: Path
) -> None:
    of_pixels(tmp_path / "masks" / "front", 1)
    of_pixels(tmp_path / "masks" / "IMAGE_02" / "SegmentationClass", 1)
    (tmp_path / "masks" / "classes.txt").write_text("background\nwall\n")
    trial = run(workspace, tmp_path / "masks", "lidar", dry_run=True)
    assert trial.state == "done", trial.error
    assert not (labels(workspace, "lidar", 0) != "").any()
    some = paint_some(workspace)
    shutil.copytree(tmp_path / "masks", tmp_path / "id of an upload" / "masks")
    upload = tmp_path / "id of an upload"
    done = run(workspace, upload, "lidar", upload=upload)
    assert done.state == "done", done.error
    names = labels(workspace, "lidar", 0)
    assert (names[some] == "kept").all()
    assert (np.delete(names, some) == "wall").mean() > 0.95
    for key in ("labelled", "doubtful", "files", "matched"):
        assert done.result[key] == trial.result[key]
    assert {each["file"] for each in done.result["files"]} == {
        f"masks/{folder}/{frame:06d}.png"
        for folder in ("front", "IMAGE_02/SegmentationClass")
        for frame in range(FRAMES)
    }
    provenance = workspace.annotations.read("lidar", 0, "provenance")[0]
    assert (provenance[names == "wall"] == IMPORTED).all()


def test_a_table_of_more_frames_than_the_recording_names_the_others(
    workspace: Workspace, tmp_path: Path
) -> None:
    images = [
        {"id": k, "file_name": f"{k:06d}.jpg", "width": WIDTH, "height": HEIGHT} for k in range(4)
    ]
    whole = [[0, 0, WIDTH, 0, WIDTH, HEIGHT, 0, HEIGHT]]
    annotations = [
        {"id": k, "image_id": k, "category_id": 1, "segmentation": whole} for k in range(4)
    ]
    categories = [{"id": 1, "name": "room"}]
    document = {"images": images, "annotations": annotations, "categories": categories}
    (tmp_path / "found.json").write_text(json.dumps(document))
    done = run(workspace, tmp_path / "found.json", "kinect")
    assert done.state == "done", done.error
    assert done.result["matched"] == 2
    assert [name.split("/")[-1] for name in done.result["unmatched_files"]] == [
        "000002.jpg", "000003.jpg",
    ]  # fmt: skip
    # Objects without tracks in several pictures have the label of their class.
    assert {each.name for each in workspace.labels.palette("kinect")} == {"room"}
    assert (labels(workspace, "kinect", 0) == "room").all()


@pytest.mark.parametrize(
    ("folder", "size", "frames", "said"),
    [
        ("front", (64, 48), 2, "expected a mask of 640x480 pixels, .* got 64x48"),
        ("front", SIZE, 3, r"files with the names, .* got 1 of no frame: 000002.png"),
        ("left", SIZE, 2, r"a folder with the name of a camera \(front, image_02, blind\)"),
        ("blind", SIZE, 2, "camera 'blind': expected a calibration, its K is not known"),
    ],
)
def test_masks_that_do_not_fit_are_refused_in_words(
    workspace: Workspace,
    tmp_path: Path,
    folder: str,
    size: tuple[int, int],
    frames: int,
    said: str,
) -> None:
    of_pixels(tmp_path / "masks" / folder, 1, frames, size)
    job = run(workspace, tmp_path / "masks", "lidar")
    assert job.state == "failed"
    assert re.search(said, job.error)


def test_a_recording_without_cameras_has_no_masks(workspace: Workspace, tmp_path: Path) -> None:
    xyz = np.random.default_rng(0).uniform(-5, 5, (50, 3)).astype(np.float32)
    import_frames(
        [PointFrame(xyz)], tmp_path / "ws" / "sequences" / "bare", RecordingInfo("bare", "b", 1.0)
    )
    with pytest.raises(BadInputError, match="of a depth camera, got neither"):
        workspace.export("bare", "masks-png", tmp_path / "out")
    assert not (tmp_path / "out").exists()
    of_pixels(tmp_path / "masks", 1, 1)
    job = run(workspace, tmp_path / "masks", "bare")
    assert "expected a recording with pictures of cameras or of a depth camera" in job.error
