"""Recordings that tracking is measured on: generated ones, and real lidar beside the checkout.

Crowds are written to files and come in by the command line, as a person's recordings do.  As a
script it writes a recording, for runs of other commits: KIND SEED FRAMES FILE.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from entering_people import entering
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from tracking_frames import LEAST, Frame, store, stored, with_trees

from pointbrush.cli import main
from pointbrush.frame import PointFrame
from pointbrush.samples import generate, write
from pointbrush.sequences import StoredFrame, open_sequence
from pointbrush_samples.driving import drive

REAL = Path(__file__).parent.parent.parent / "shared" / "realdata"
DGP = ("dgp_scene_01", "dgp_scene_02")
KITTI = ("semantickitti_02", "semantickitti_03", "semantickitti_04", "semantickitti_05")
SCENES = (*DGP, *KITTI)
"""Recorded lidar.  For tuning: semantickitti_05 and dgp_scene_01; the others are for checks."""
KINDS: dict[str, tuple[str, dict[str, Any]]] = {
    "table-top": ("tabletop", {}),
    "3-pins": ("juggling", {"people": 1, "pins": 3, "label_people": False}),
    "6-pins": ("juggling", {"pins": 6, "label_people": False, "like_clothes": True}),
    "walking": ("walking", {}),
}
"""Kind -> what the samples call it, and its options."""
MORE: dict[str, tuple[str, dict[str, Any]]] = {"boxes": ("walking", {"people": 2, "boxes": 2})}
"""Kinds that are measured when they are named: two people who pass two turning boxes."""

STREETS = ("street", "street-no-poses", "street-16-beams", "drive")
"""A 48-beam lidar on a car, from the ray-caster of the tests, with its poses and without; one of 16
beams; a 64-beam one of the samples, among parked vehicles, with its poses."""
FEW_BEAMS = 16

ENTERING = ("entering", "stepping-out", "entering-part")
"""People who enter close to the camera; who step out of the picture for a moment; of whom only a
small part is painted."""

CROWDS = {"crowd-5hz": 5.0, "crowd-15hz": 15.0}
"""Kind of crowded room -> frames a second; three, four or five people, by the seed."""


TILT = Rotation.from_euler("xyz", [25, 40, 10], degrees=True).as_matrix()
AWAY = np.array([1.2, -3.0, 0.7])
SEEN = ("camera", "colourless", "turned", "noisy", "elsewhere", "nowhere")
"""As a depth camera measures; without colours; turned; half a millimetre of noise in all
directions; turned and moved, with its viewpoint, and without."""


def _seen(frame: Frame, how: str, rng: np.random.Generator) -> Frame:
    if how == "colourless":
        return replace(frame, rgb=None)
    if how == "turned":
        return replace(frame, xyz=frame.xyz @ TILT.T.astype(np.float32), viewpoint=None)
    if how == "noisy":
        noise = rng.normal(0, 0.0005, frame.xyz.shape).astype(np.float32)
        return replace(frame, xyz=frame.xyz + noise, viewpoint=None)
    if how in ("elsewhere", "nowhere"):
        xyz = (frame.xyz @ TILT.T + AWAY).astype(np.float32)
        return replace(frame, xyz=xyz, viewpoint=AWAY if how == "elsewhere" else None)
    return frame


def recorded(kind: str, seed: int, count: int, every: int = 1, seen: str = "camera") -> list[Frame]:
    """``count`` frames of any kind, or of a recording whose path is the ``kind``."""
    if kind.endswith(".npz"):
        return stored(Path(kind), count)
    if kind in SCENES:
        return real(kind)
    if kind in STREETS:
        return street(kind, seed, count)
    if kind in CROWDS:
        return crowd(kind, seed, count)
    if kind in ENTERING:
        made = entering(seed, count, kind)
        return with_trees([_in_memory(made.frame(i), made.truth[i]) for i in range(count)])
    return generated(kind, seed, count, every, seen)


def generated(
    kind: str, seed: int, count: int, every: int = 1, seen: str = "camera"
) -> list[Frame]:
    """``count`` frames of a kind, each ``every``-th of 30 a second, 512 x 424; ``seen`` of SEEN."""
    name, options = (KINDS | MORE)[kind]
    recording = generate(name, seed, count * every, **options)
    some = range(0, count * every, every)
    rng = np.random.default_rng(seed)
    return with_trees(
        [_seen(_in_memory(recording.frame(i), recording.truth[i]), seen, rng) for i in some]
    )


def _in_memory(frame: PointFrame, truth: NDArray[np.uint16]) -> Frame:
    return Frame(frame.xyz.astype(np.float32), frame.rgb, truth, frame.viewpoint)


def street(kind: str, seed: int, count: int) -> list[Frame]:
    """``count`` frames of a kind of STREETS, 10 a second."""
    if kind == "drive":
        return with_trees(
            [
                Frame(
                    made.frame.xyz.astype(np.float32),
                    None,
                    made.instance.astype(np.uint16),
                    made.frame.viewpoint,
                    made.T_room_frame,
                    made.frame.intensity,
                )
                for made in drive(seed, count)
            ]
        )
    sys.path.append(str(Path(__file__).parent.parent / "tests" / "tracking"))
    import scenes

    beams = {"beams": FEW_BEAMS} if kind == "street-16-beams" else {}
    posed = kind != "street-no-poses"
    return with_trees(
        [
            Frame(f.xyz, None, f.truth, f.viewpoint, f.pose if posed else None)
            for f in scenes.street(seed, count, **beams)
        ]
    )


def crowd(kind: str, seed: int, count: int) -> list[Frame]:
    """``count`` frames of a kind of CROWDS, as they are after ``pointbrush import``."""
    recording = generate("crowd", seed, count, rate=CROWDS[kind], people=3 + seed % 3)
    with tempfile.TemporaryDirectory() as folder:
        files, workspace = Path(folder) / "crowd", Path(folder) / "workspace"
        write(recording, files)
        if main(["import", str(files), "--name", kind, "--workspace", str(workspace)]):
            raise RuntimeError(f"{kind} {seed} cannot be imported")
        stored = open_sequence(next((workspace / "sequences").iterdir()))
        return with_trees([_held(frame, recording.truth[i]) for i, frame in enumerate(stored)])


def _held(frame: StoredFrame, truth: NDArray[np.uint16]) -> Frame:
    """A stored frame in memory, which outlives its files."""
    return Frame(
        np.array(frame.xyz),
        None if frame.rgb is None else np.array(frame.rgb),
        truth[frame.source_index],
        frame.viewpoint,
        frame.pose,
        lattice=frame.lattice,
    )


def real(scene: str) -> list[Frame]:
    """A lidar scene with ego motion; its persistent object numbers are the truth."""
    if scene in KITTI:
        return with_trees(_semantickitti(REAL / scene))
    frames = []
    for path in sorted((REAL / scene / "npz").glob("*.npz")):
        d = np.load(path)
        truth = d["instance"].astype(np.uint16)
        frames.append(Frame(d["xyz"], d["rgb"], truth, None, d["pose"]))
    return with_trees(frames)


def _semantickitti(folder: Path) -> list[Frame]:
    """The scans of a folder from the first one on in which an object is visible.

    Without poses where the place of the camera, which they are of, is not given.
    """
    calibration = (folder / "calib.txt").read_text().splitlines()
    place = [_matrix(line[3:]) for line in calibration if line.startswith("Tr:")]
    poses = [_matrix(line) for line in (folder / "poses.txt").read_text().splitlines()]
    frames: list[Frame] = []
    objects: dict[int, int] = {}
    scans = sorted((folder / "velodyne").glob("*.bin"))
    for path, T_start_camera in zip(scans, poses, strict=True):
        xyz = np.fromfile(path, np.float32).reshape(-1, 4)[:, :3].copy()
        packed = np.fromfile(folder / "labels" / f"{path.stem}.label", np.uint32)
        truth = np.zeros(len(xyz), np.uint16)
        for each in np.unique(packed[packed >> 16 > 0]).tolist():
            truth[packed == each] = objects.setdefault(each, len(objects) + 1)
        if frames or np.bincount(truth)[1:].max(initial=0) >= LEAST:
            pose = np.linalg.inv(place[0]) @ T_start_camera @ place[0] if place else None
            frames.append(Frame(xyz, None, truth, np.zeros(3), pose))
    return frames


def _matrix(line: str) -> NDArray[np.float64]:
    """(4, 4) the transform whose upper 12 numbers are in a line."""
    return np.vstack([np.array(line.split(), np.float64).reshape(3, 4), [0, 0, 0, 1]])


if __name__ == "__main__":
    store(recorded(sys.argv[1], int(sys.argv[2]), int(sys.argv[3])), Path(sys.argv[4]))
