"""Real recordings with the class of every point, for label by example.

The split, which was set before anything was measured: options are chosen on ``TUNING``, and
``CHECKING`` only checks them.  Sets that are not on this machine are left out.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats import read
from pointbrush.frame import PointFrame
from pointbrush_samples.classes import Classified

REAL = Path(__file__).parent.parent.parent / "shared" / "realdata"
AERIAL = ("ground", "vegetation", "building")
AERIAL_CODES = {2: 1, 3: 2, 4: 2, 5: 2, 6: 3}
"""LAS class -> number of the class."""
PARTS = (2, 3)
"""Parts of a tile along each axis of the plan."""
STREET = ("road", "ground", "vegetation", "building", "vehicle", "pole/sign/person")
STREET_CODES = {
    **dict.fromkeys((40, 44, 60), 1),  # road, parking, lane marking
    **dict.fromkeys((48, 49, 72), 2),  # sidewalk, other ground, terrain
    **dict.fromkeys((70, 71), 3),  # vegetation, trunk
    **dict.fromkeys((50, 51, 52), 4),  # building, fence, other structure
    **dict.fromkeys((10, 11, 13, 15, 16, 18, 20, 252, 256, 257, 258, 259), 5),
    **dict.fromkeys((30, 31, 32, 80, 81, 253, 254, 255), 6),
}
"""SemanticKITTI class -> number of the group; 252 and above are moving."""
RETURNS = ("return_number", "number_of_returns")
TERRAIN = ("ground", "other")
FEWEST = 200
"""True points of a class in a frame below which its IoU does not count."""
TUNING = {"aerial": ("tile_2021",), "street": ("05", "03"), "terrain": ("samp11", "samp31")}
CHECKING = {"aerial": ("tile_2023",), "street": ("02", "04"), "terrain": ("samp21", "samp51")}
Sets = dict[str, list[Classified]]
"""Recordings by name, each with its frames."""


def real_sets(kind: str, names: tuple[str, ...]) -> Sets:
    """Return the recordings of a kind; a tile becomes one for each of its parts."""
    read: dict[str, Callable[[str], Sets]] = {"aerial": _tile, "street": _drive, "terrain": _sample}
    return {part: frames for name in names for part, frames in read[kind](name).items()}


def _truth(codes: NDArray[np.integer], numbers: dict[int, int]) -> NDArray[np.uint16]:
    table = np.zeros(2**16, np.uint16)
    table[list(numbers)] = list(numbers.values())
    return table[codes]


def _tile(name: str) -> Sets:
    """Read an aerial tile, in parts."""
    path = REAL / "aerial_ign" / f"{name}.laz"
    if not path.exists():
        return {}
    (frame,) = read(path)
    truth = _truth(frame.other["classification"], AERIAL_CODES)
    low, high = frame.xyz.min(axis=0)[:2], frame.xyz.max(axis=0)[:2]
    at = np.minimum((frame.xyz[:, :2] - low) / (high - low) * PARTS, np.subtract(PARTS, 1))
    part = at.astype(int) @ [PARTS[1], 1]
    found = {}
    for number in range(PARTS[0] * PARTS[1]):
        own = part == number
        cut = PointFrame(
            frame.xyz[own], None if frame.rgb is None else frame.rgb[own],
            None if frame.intensity is None else frame.intensity[own],
            other={key: frame.other[key][own] for key in RETURNS if key in frame.other},
        )  # fmt: skip
        found[f"{name}-{number}"] = [Classified(cut, truth[own], AERIAL)]
    return found


def _drive(name: str) -> Sets:
    """Read a drive."""
    folder = REAL / f"semantickitti_{name}"
    if not folder.is_dir():
        return {}
    poses = np.loadtxt(folder / "poses.txt").reshape(-1, 3, 4)
    T = np.eye(4)
    T[:3] = _calibration(folder)
    frames = []
    for path, pose in zip(sorted((folder / "velodyne").glob("*.bin")), poses, strict=True):
        rows = np.fromfile(path, "<f4").reshape(-1, 4)
        codes = np.fromfile(folder / "labels" / f"{path.stem}.label", "<u4") & 0xFFFF
        camera = np.vstack([pose, [0, 0, 0, 1]])
        frame = PointFrame(
            rows[:, :3].copy(), intensity=rows[:, 3].copy(), viewpoint=np.zeros(3),
            pose=np.linalg.inv(T) @ camera @ T,
        )  # fmt: skip
        frames.append(Classified(frame, _truth(codes, STREET_CODES), STREET))
    return {f"drive-{name}": frames}


def _calibration(folder: Path) -> NDArray[np.float64]:
    """Return the transform (3, 4) from the lidar to the camera; drive 04 has that of drive 05."""
    for place in (folder, REAL / "semantickitti_05"):
        for line in (place / "calib.txt").read_text().splitlines():
            if line.startswith("Tr:"):
                return np.array(line.split()[1:], float).reshape(3, 4)
    raise ValueError(f"{folder}: expected a line Tr in calib.txt, got none")


def _sample(name: str) -> Sets:
    """Read an aerial sample with the ground marked."""
    folder = REAL / "terrain_isprs"
    if not folder.is_dir():
        return {}
    (every,) = read(folder / f"{name}-utm.pcd")
    (ground,) = read(folder / f"{name}-utm-ground.pcd")
    known = {row.tobytes() for row in np.ascontiguousarray(ground.xyz)}
    truth = [1 if row.tobytes() in known else 2 for row in np.ascontiguousarray(every.xyz)]
    return {name: [Classified(PointFrame(every.xyz), np.array(truth, np.uint16), TERRAIN)]}
