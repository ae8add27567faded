"""Boxes that the makers of formats read from our exports: `make peers` has them read anew.

The makers' packages cannot share our environment, so that each has one of its own, and what it
read is kept in ``tests/golden/boxes``: the boxes, and the files that it read them from.
"""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pointbrush.formats.boxes.scene import Scene, SceneFrame, View, by_frame
from pointbrush.formats.boxes.writing import BOX_WRITERS
from pointbrush.geometry.oriented_box import BoxPose, OrientedBox
from pointbrush.geometry.quaternions import quaternion_of

GOLDEN = Path(__file__).parent / "golden" / "boxes"
CACHE = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "pointbrush-box-readers"
CLASSES = {1: "vehicle", 2: "pedestrian"}
START = 1533151603.5


@dataclass(frozen=True)
class Reader:
    """``packages`` are all that its import needs; ``alone`` comes without what it asks for beside
    (PyTorch, Jupyter); ``script`` prints the boxes of a folder in the points' coordinates."""

    alone: str
    packages: tuple[str, ...]
    script: str


NUSCENES = (
    *("numpy<2", "pyquaternion", "matplotlib", "Pillow", "tqdm", "opencv-python-headless"),
    *("scikit-learn", "shapely", "descartes", "cachetools"),
)
AV2 = (
    *("numpy", "pandas", "pyarrow", "scipy", "universal-pathlib", "opencv-python-headless"),
    *("rich", "av", "matplotlib", "numba", "joblib", "pyproj", "polars", "click"),
)
PRINT = """
def told(frame, name, center, size, rotation):
    return {"frame": frame, "name": str(name), "center": [float(v) for v in center],
            "size": [float(v) for v in size], "rotation": [float(v) for v in rotation.ravel()]}
"""
READERS: Mapping[str, Reader] = {
    "nuscenes-boxes": Reader(
        "nuscenes-devkit==1.2.0",
        NUSCENES,
        PRINT
        + """
import json, sys
from nuscenes.nuscenes import NuScenes
nusc = NuScenes("v1.0-pointbrush", sys.argv[1], verbose=False)
found = []
for number, sample in enumerate(nusc.sample):
    for box in nusc.get_sample_data(sample["data"]["LIDAR_TOP"])[1]:
        length, width, height = box.wlh[[1, 0, 2]]
        found.append(told(number, box.name, box.center, (length, width, height),
                          box.rotation_matrix))
print(json.dumps(found))
""",
    ),
    "kitti-object": Reader(
        "nuscenes-devkit==1.2.0",
        NUSCENES,
        PRINT
        + """
import json, os, sys
from pathlib import Path
from nuscenes.utils.kitti import KittiDB
root = Path(sys.argv[1])
(root / "train" / "image_2").mkdir(parents=True)
for place in ("calib", "label_2"):
    os.symlink(root / place, root / "train" / place)
for path in (root / "label_2").iterdir():
    (root / "train" / "image_2" / f"{path.stem}.png").touch()
kitti, found = KittiDB(str(root)), []
for token in kitti.tokens:
    for box in kitti.get_boxes(token):
        box.rotate(kitti.kitti_to_nu_lidar_inv)
        found.append(told(int(token[-6:]), box.name, box.center, box.wlh[[1, 0, 2]],
                          box.rotation_matrix))
print(json.dumps(found))
""",
    ),
    "argoverse2": Reader(
        "av2==0.3.6",
        AV2,
        PRINT
        + """
import json, sys
from pathlib import Path
from av2.structures.cuboid import CuboidList
cuboids = CuboidList.from_feather(Path(sys.argv[1]) / "annotations.feather").cuboids
times = sorted({cuboid.timestamp_ns for cuboid in cuboids})
print(json.dumps([told(times.index(each.timestamp_ns), each.category, each.xyz_center_m,
                       each.dims_lwh_m, each.dst_SE3_object.rotation) for each in cuboids]))
""",
    ),
}


def turned(yaw: float, pitch: float = 0.0) -> np.ndarray:
    c, s, cp, sp = np.cos(yaw), np.sin(yaw), np.cos(pitch), np.sin(pitch)
    level = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    return np.asarray(level @ [[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])


def example(format: str) -> list[SceneFrame]:
    """Make three frames of a moving scanner: a car that turns, and a walker in two of them."""
    tilt = 0.0 if format.startswith("kitti") else 0.1
    car = {
        k: BoxPose(np.array([12.0 + k, -3.0, 0.8]), quaternion_of(turned(0.4 + 0.2 * k, tilt)))
        for k in range(3)
    }
    walker = {
        k: BoxPose(np.array([6.0, 2.0 + k, 0.9]), quaternion_of(turned(-2.5))) for k in (1, 2)
    }
    boxes = [
        OrientedBox(1, 1, np.array([4.4, 1.9, 1.6]), car, {"parked": False}),
        OrientedBox(2, 2, np.array([0.6, 0.7, 1.8]), walker, {"occluded": 1.0}),
    ]
    found = by_frame(boxes, CLASSES)
    camera = np.eye(4)
    camera[:3, :3] = np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]]) @ turned(0.02, 0.03).T
    camera[:3, 3] = 0.05, -0.1, -0.3
    K = np.array([[720.0, 0, 620], [0, 720, 187], [0, 0, 1]])
    frames = []
    for k in range(3):
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = turned(0.3 * k), (2.0 * k, 0.5, 0)
        view = View(K, camera, 1242, 375)
        counted = tuple(range(len(found[k])))
        frames.append(
            SceneFrame(k, f"{k:06d}", START + k / 2, found[k], counted, pose=pose, view=view)
        )
    return frames


def files(format: str) -> Iterator[tuple[str, bytes]]:
    """Write the example in a format."""
    scene = Scene("drive", {"vehicle": "#ff8800", "pedestrian": "#00ffaa"})
    yield from BOX_WRITERS[format].write(iter(example(format)), scene)


def content(name: str, data: bytes) -> Any:
    """Read a file as JSON, as a table or as lines of words; None for pictures."""
    if name.endswith(".json"):
        return json.loads(data)
    if name.endswith(".feather"):
        from pyarrow import feather

        return feather.read_table(io.BytesIO(data)).to_pydict()
    return [line.split() for line in data.decode().splitlines()] if name.endswith(".txt") else None


def _python(reader: Reader) -> Path:
    """Build the environment of a reader where there is none; returns its interpreter."""
    place = CACHE / reader.alone.replace("==", "-")
    python = place / "bin" / "python"
    if not (place / "ready").is_file():
        print(f"== {reader.alone} in an environment of its own")
        subprocess.run([sys.executable, "-m", "venv", "--clear", place], check=True)
        pip = [python, "-m", "pip", "install", "--quiet"]
        subprocess.run([*pip, *reader.packages], check=True)
        subprocess.run([*pip, "--no-deps", reader.alone], check=True)
        (place / "ready").touch()
    return python


def main() -> None:
    """Have the makers' packages read the example, and keep what they say."""
    for format, reader in READERS.items():
        python = _python(reader)
        with tempfile.TemporaryDirectory() as folder:
            kept = {}
            for name, data in files(format):
                path = Path(folder) / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(data)
                kept[name] = content(name, data)
            done = subprocess.run(
                [python, "-c", reader.script, folder], check=True, capture_output=True, text=True
            )
        table = {"reader": reader.alone, "boxes": json.loads(done.stdout), "files": kept}
        GOLDEN.mkdir(parents=True, exist_ok=True)
        text = json.dumps(table, ensure_ascii=False, separators=(",", ":"))
        (GOLDEN / f"{format}.json").write_text(text.replace("},{", "},\n{") + "\n", "utf-8")
        print(f"{format}: {len(table['boxes'])} boxes read by {reader.alone}")


if __name__ == "__main__":
    main()
