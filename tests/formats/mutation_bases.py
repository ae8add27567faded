"""Small whole files of every format, to be changed: written here, and real ones where they are."""

from __future__ import annotations

import io
import json
import tarfile
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow import feather

from pointbrush.formats import EXPORTS, export
from pointbrush.formats.boxes.conventions import CONVENTIONS
from pointbrush.formats.boxes.writing import BOX_WRITERS
from pointbrush.formats.times.matching import Origin
from pointbrush.geometry.oriented_box import BoxPose, OrientedBox
from pointbrush.geometry.quaternions import quaternion_of
from pointbrush.sequences import RecordingInfo, import_frames
from tests.conftest import SHARED
from tests.formats import (
    test_bags,
    test_class_maps,
    test_e57,
    test_exports,
    test_layouts,
    test_pictures,
    test_rgbd,
)
from tests.formats.test_box_round_trips import frames_of, out, turned

MOST_BYTES = 60_000
"""Size of a real file that is taken."""
REAL = {
    "text": ("text", ".txt", ".xyz", ".pts", ".csv"), "ptx": ("text", ".ptx"),
    "ply": ("ply", ".ply"), "pcd": ("pcd", ".pcd"), "las": ("las", ".las"),
    "laz": ("las", ".laz"), "e57": ("e57", ".e57"), "npy": ("npy", ".npy"),
    "npz": ("misc_pyntcloud", ".npz"), "rosbag1": ("bags", ".bag"),
}  # fmt: skip
"""Folder and endings of the real files of a family."""


@dataclass(frozen=True)
class Base:
    """Files of a folder by name, of which ``place`` is imported: a recording, or its labels.

    ``labels``: the kind of ``recording`` that they are of, or names of ``classes``; "" for files
    that are a recording.
    """

    name: str
    files: Mapping[str, bytes]
    place: str = ""
    labels: str = ""
    format: str | None = None
    by_order: bool = False


@dataclass
class _Made:
    """A folder whose files become a base."""

    bases: dict[str, list[Base]] = field(default_factory=dict)

    def add(self, family: str, base: Base) -> None:
        self.bases.setdefault(family, []).append(base)

    def one(self, family: str, name: str, content: bytes) -> None:
        """Add a file that is a recording."""
        self.add(family, Base(name, {name: content}, name))

    def folder(self, family: str, name: str, write: Callable[[Path], object], **more: str) -> None:
        """Add a folder as ``write`` fills it."""
        self.add(family, Base(name, filled(write), **more))


def filled(write: Callable[[Path], object]) -> dict[str, bytes]:
    """Return the files that ``write`` puts into a folder."""
    with tempfile.TemporaryDirectory() as folder:
        write(Path(folder))
        return {
            str(path.relative_to(folder)): path.read_bytes()
            for path in sorted(Path(folder).rglob("*"))
            if path.is_file()
        }


@cache
def recording(kind: str) -> Path:
    """Return the recording that labels of ``points`` or ``boxes`` are of."""
    folder = Path(tempfile.mkdtemp(prefix=f"{kind}-"))
    points = [frame.points for frame in test_exports.frames(3)]
    named = [Origin("") for _ in points]
    if kind == "boxes":
        frames = frames_of([])
        named = [Origin(f"{frame.name}.pcd") for frame in frames]
        points = [replace(p, timestamp=f.time) for p, f in zip(points, frames, strict=True)]
    import_frames(points, folder / "recording", RecordingInfo("fuzz", "fuzz", 10, origins=named))
    return folder / "recording"


def bases() -> dict[str, list[Base]]:
    """Return the bases of each family; the first of a family is read."""
    made = _Made()
    _exported(made)
    _bags(made)
    _others(made)
    _layouts(made)
    for family, (folder, *endings) in REAL.items():
        for path in sorted((SHARED / "formats" / folder).glob("*")):
            if path.suffix in endings and 0 < path.stat().st_size < MOST_BYTES:
                made.one(family, path.name, path.read_bytes())
    return made.bases


def _exported(made: _Made) -> None:
    """What our writers make: recordings, and labels of the recording."""

    def write(format: str, folder: Path) -> None:
        export(format, test_exports.frames(3), test_exports.PALETTE, folder / "e")

    for format in ("ply", "pcd", "las", "laz", "npz", "semantickitti"):
        files = filled(lambda folder, format=format: write(format, folder))
        family = "kitti" if format == "semantickitti" else format
        made.add(family, Base(f"our {format}", files, "e"))
    for format, entry in EXPORTS.items():
        if not (entry.whole_boxes or entry.pictures):
            files = filled(lambda folder, format=format: write(format, folder))
            made.add("labels", Base(f"our {format}", files, "e", "points"))
    _plain_labels(made)
    for format, writer in BOX_WRITERS.items():
        upright = CONVENTIONS[writer.convention].upright
        R = turned(0.4, *((0.0, 0.0) if upright else (0.1, 0.2)))
        poses = {k: BoxPose(np.array([k, 2.0, 1.0]), quaternion_of(R)) for k in range(2)}
        box = OrientedBox(1, 1, np.array([4.0, 2.0, 1.5]), poses, {"parked": True})
        files = filled(lambda folder, format=format, box=box: out(format, frames_of([box]), folder))
        made.add(
            "boxes",
            Base(f"our {format}", files, "", "boxes", writer.read_as[0], format == "kitti-object"),
        )


def _plain_labels(made: _Made) -> None:
    """Labels a point that other tools write, for three frames of 60 points."""
    numbers = np.random.default_rng(2).integers(0, 4, 60)
    npy, npz = io.BytesIO(), io.BytesIO()
    np.save(npy, numbers.astype(np.int32))
    np.savez(npz, data=(numbers * 1000 + 7).astype(np.uint16))
    lines = "\n".join(map(str, numbers)).encode()
    xyz = "\n".join(f"{n} {n} 1.5" for n in range(9)).encode()
    for format, name, content in (
        ("semantickitti", "{}.label", numbers.astype("<u4").tobytes()),
        ("lidarseg", "{}_lidarseg.bin", numbers.astype(np.uint8).tobytes()),
        ("panoptic", "{}_panoptic.npz", npz.getvalue()),
        ("npy", "{}.npy", npy.getvalue()),
        ("lines", "{}.labels", lines),
        ("s3dis", "{}/Annotations/chair_1.txt", xyz),
    ):
        files = {name.format(frame): content for frame in range(3)}
        if name.startswith("{}_"):
            rows = [{"index": i, "name": f"class {i}"} for i in range(4)]
            files["v1.0-mini/category.json"] = json.dumps(rows).encode()
        made.add("labels", Base(format, files, "", "points", format, True))

    for name, text in (
        ("a.yaml", test_class_maps.YAML),
        ("a.xml", test_class_maps.XML),
        ("a.txt", "1: car\n2 tree\n"),
        ("a.json", '{"1": "car", "2": {"name": "tree", "color": "#00ff00"}}'),
    ):
        made.add("classes", Base(name, {name: text.encode()}, name, "classes"))


def _bags(made: _Made) -> None:
    for packed in ("none", "bz2"):
        made.one("rosbag1", f"{packed}.bag", test_bags.rosbag1(packed))
    for packed in ("", "zstd"):
        made.one("mcap", f"{packed or 'plain'}.mcap", test_bags.mcap(packed, "cdr", True))
    made.one("mcap", "ros1.mcap", test_bags.mcap("", "ros1", False))
    made.folder("rosbag2", "run", lambda folder: test_bags.rosbag2(folder / "run" / "r.db3"))
    for compressed in (True, False):
        content = test_pictures.jpeg(3) if compressed else bytes(72)
        kind = "CompressedImage" if compressed else "Image"
        topic = "/cam/image_raw" + ("/compressed" if compressed else "")
        image = test_pictures.image_message(101.54, content, compressed=compressed)
        rows = (
            ("/tf_static", "tf2_msgs/TFMessage", 0.0, test_pictures.transform_message()),
            ("/cam/camera_info", "sensor_msgs/CameraInfo", 0.0, test_pictures.info_message()),
            ("/points", "sensor_msgs/PointCloud2", 101.5, test_bags.message(1, cdr=False)),
            (topic, f"sensor_msgs/{kind}", 101.54, image),
        )
        made.one("pictures", f"{kind}.bag", test_pictures.rosbag1(*rows))


def _others(made: _Made) -> None:
    rng = np.random.default_rng(1)
    made.one("e57", "small.e57", test_e57.e57(40, pose=test_e57.POSE))
    made.one("ptx", "two.ptx", (test_layouts.PTX * 2).encode())
    table = np.column_stack([rng.normal(0, 9, (50, 3)), rng.integers(0, 256, (50, 3))])
    made.one("text", "colours.xyz", "\n".join(" ".join(map(str, r)) for r in table).encode())
    npy = io.BytesIO()
    np.save(npy, table)
    made.one("npy", "table.npy", npy.getvalue())
    named = np.zeros(50, [("x", "f4"), ("y", "f4"), ("z", "f4"), ("rgb", "u1", 3), ("label", "u2")])
    for column, axis in enumerate("xyz"):
        named[axis] = table[:, column]
    npy = io.BytesIO()
    np.save(npy, named)
    made.one("npy", "named.npy", npy.getvalue())
    made.one("kitti", "four.bin", table[:, :4].astype("<f4").tobytes())
    made.one("kitti", "six.xyzrgb", table.astype("<f4").tobytes())
    made.one("kitti", "five.pcd.bin", table[:, :5].astype("<f4").tobytes())
    columns = {"x": table[:, 0], "y": table[:, 1].astype(np.float16), "z": table[:, 2]}
    columns |= {"intensity": table[:, 3].astype(np.uint8), "stamp": np.arange(50)}
    for packing in ("uncompressed", "lz4", "zstd"):
        packed = io.BytesIO()
        feather.write_feather(pa.table(columns), packed, packing)
        made.one("feather", f"{packing}.feather", packed.getvalue())
    cloud = made.bases["ply"][0].files
    zipped, tarred = io.BytesIO(), io.BytesIO()
    with (
        zipfile.ZipFile(zipped, "w", zipfile.ZIP_DEFLATED) as archive,
        tarfile.open(fileobj=tarred, mode="w:gz") as tar,
    ):
        for name, content in cloud.items():
            archive.writestr(name, content)
            entry = tarfile.TarInfo(name)
            entry.size = len(content)
            tar.addfile(entry, io.BytesIO(content))
    made.one("archive", "run.zip", zipped.getvalue())
    made.one("archive", "run.tar.gz", tarred.getvalue())


def _layouts(made: _Made) -> None:
    def depth(folder: Path) -> None:
        test_rgbd.image(folder / "depth" / "0.png", test_rgbd.depths(8, 6, 1000))
        test_rgbd.image(folder / "rgb" / "0.png", test_rgbd.colors(16, 12))
        known = {"fx": 100, "fy": 110, "cx": 4, "cy": 5, "depth_scale": 500}
        (folder / "camera.json").write_text(json.dumps(known))

    def tum(folder: Path) -> None:
        for name in ("depth", "rgb"):
            lines = [f"{10 + i / 10:.6f} {name}/{i}.png" for i in range(2)]
            (folder / f"{name}.txt").write_text("\n".join(lines))
            for i in range(2):
                array = test_rgbd.depths(8, 6) if name == "depth" else test_rgbd.colors(8, 6)
                test_rgbd.image(folder / name / f"{i}.png", array)
        (folder / "groundtruth.txt").write_text("9.9 0 0 0 0 0 0 1\n10.2 1 0 0 0 0 0 1\n")
        (folder / "intrinsics.txt").write_text("# fx fy cx cy scale\n100 110\n4 5\n500")

    def argoverse(folder: Path) -> None:
        lidar = folder / "sensors" / "lidar"
        lidar.mkdir(parents=True)
        times = [315_966_265_259_836_000 + i * 100_000_000 for i in range(2)]
        for i, time in enumerate(times):
            rows = test_layouts.records(i)
            cloud = {n: rows[:, k] for k, n in enumerate("xyz")}
            feather.write_feather(pa.table(cloud), lidar / f"{time}.feather")
        place = {n: [0.0, 1.0] for n in ("tx_m", "ty_m", "tz_m", "qx", "qy", "qz", "qw")}
        poses = pa.table({"timestamp_ns": times, **place})
        feather.write_feather(poses, folder / "city_SE3_egovehicle.feather")

    made.folder("depth", "depth", depth)
    made.folder("depth", "tum", tum)
    made.folder("argoverse", "log", argoverse)
    made.folder("nuscenes", "sweeps", lambda f: test_pictures.nuscenes(f, True),
                place="samples/LIDAR_TOP")  # fmt: skip
    made.folder("pictures", "cameras.json", lambda f: test_pictures.described(f / "r"), place="r")
