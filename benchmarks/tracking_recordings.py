"""Recordings that tracking is measured on: generated ones, and real lidar beside the checkout."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pointbrush.samples import generate

REAL = Path(__file__).parent.parent.parent / "shared" / "realdata"
SCENES = ("dgp_scene_01", "dgp_scene_02")
KINDS: dict[str, tuple[str, dict[str, Any]]] = {
    "table-top": ("tabletop", {}),
    "3-pins": ("juggling", {"people": 1, "pins": 3, "label_people": False}),
    "6-pins": ("juggling", {"pins": 6, "label_people": False, "like_clothes": True}),
    "walking": ("walking", {}),
}
"""Kind -> what the samples call it, and its options."""

STREETS = ("street", "street-no-poses")
"""A 48-beam lidar on a car, from the ray-caster of the tests, with its poses and without."""


@dataclass(eq=False)
class Frame:
    """A ``TrackFrame`` in memory, with the true label of each point (N,) uint16."""

    xyz: NDArray[np.float32]
    rgb: NDArray[np.uint8] | None
    truth: NDArray[np.uint16]
    viewpoint: NDArray[np.float64] | None = None
    pose: NDArray[np.float64] | None = None
    intensity: NDArray[np.float32] | None = None

    @cached_property
    def kdtree(self) -> cKDTree:
        """As the frame store builds it."""
        return cKDTree(self.xyz, balanced_tree=False)


def generated(kind: str, seed: int, count: int, every: int = 1) -> list[Frame]:
    """``count`` frames of a kind, each ``every``-th of 30 a second, 512 x 424."""
    name, options = KINDS[kind]
    recording = generate(name, seed, count * every, **options)
    some = range(0, count * every, every)
    frames = ((recording.frames[i], recording.truth[i]) for i in some)
    return _with_trees(
        [Frame(f.xyz.astype(np.float32), f.rgb, truth, f.viewpoint) for f, truth in frames]
    )


def street(kind: str, seed: int, count: int) -> list[Frame]:
    """``count`` frames of a kind of STREETS, 10 a second."""
    sys.path.append(str(Path(__file__).parent.parent / "tests" / "tracking"))
    import scenes

    told = kind == "street"
    return _with_trees(
        [
            Frame(f.xyz, None, f.truth, f.viewpoint, f.pose if told else None)
            for f in scenes.street(seed, count)
        ]
    )


def real(scene: str) -> list[Frame]:
    """A lidar scene with ego motion; its persistent object numbers are the truth."""
    frames = []
    for path in sorted((REAL / scene / "npz").glob("*.npz")):
        d = np.load(path)
        truth = d["instance"].astype(np.uint16)
        frames.append(Frame(d["xyz"], d["rgb"], truth, None, d["pose"]))
    return _with_trees(frames)


def _with_trees(frames: list[Frame]) -> list[Frame]:
    for frame in frames:
        _ = frame.kdtree  # stored with a recording, so not part of the cost
    return frames
