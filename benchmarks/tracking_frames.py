"""Frames that tracking is measured on, in memory and in files.

Imports nothing but the tracker's interface, so that any commit's tracker can be given them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pointbrush.tracking.interface import PixelLattice

LEAST = 40
"""Points in the truth from which an object counts as visible."""


@dataclass(eq=False)
class Frame:
    """A ``TrackFrame`` in memory, with the true label of each point (N,) uint16."""

    xyz: NDArray[np.float32]
    rgb: NDArray[np.uint8] | None
    truth: NDArray[np.uint16]
    viewpoint: NDArray[np.float64] | None = None
    pose: NDArray[np.float64] | None = None
    intensity: NDArray[np.float32] | None = None
    lattice: PixelLattice | None = None
    sensor: NDArray[np.uint8] | None = None
    parts: Sequence[Any] = ()

    @cached_property
    def kdtree(self) -> cKDTree:
        """As the frame store builds it."""
        return cKDTree(self.xyz, balanced_tree=False)


@dataclass(frozen=True)
class Lattice:
    """A ``PixelLattice`` that was read from a file."""

    width: int
    height: int
    axis: int
    sign: float
    tangent: tuple[float, float]
    pitch: tuple[float, float]
    eye: tuple[float, float, float]


def store(frames: Sequence[Frame], path: Path) -> None:
    """Write a recording in one file, as in shared/recordings."""
    parts = {
        f"{number}_{each.name}": value
        for number, frame in enumerate(frames)
        for each in fields(frame)
        if (value := getattr(frame, each.name)) is not None
        and each.name not in ("lattice", "parts")
    }
    for number, frame in enumerate(frames):
        if (seen := frame.lattice) is not None:
            numbers = astuple(
                Lattice(
                    seen.width, seen.height, seen.axis, seen.sign, seen.tangent, seen.pitch,
                    seen.eye,
                )
            )  # fmt: skip
            parts[f"{number}_lattice"] = np.hstack(numbers)
    partial = path.with_suffix(".part.npz")
    np.savez_compressed(partial, **parts)
    partial.rename(path)


def stored(path: Path, count: int) -> list[Frame]:
    """Read the first ``count`` frames of a recording in one file."""
    d = np.load(path)
    found = sum(name.endswith("_xyz") for name in d.files)

    def frame(number: int) -> Frame:
        parts: dict[str, Any] = {
            each.name: d[name]
            for each in fields(Frame)
            if (name := f"{number}_{each.name}") in d.files
        }
        if "lattice" in parts:
            parts["lattice"] = _lattice(parts["lattice"].tolist())
        return Frame(**{"rgb": None} | parts)

    return with_trees([frame(number) for number in range(min(count, found))])


def _lattice(numbers: list[float]) -> Lattice:
    width, height, axis, sign, *rest = numbers
    x, y, z = rest[4:]
    return Lattice(
        int(width), int(height), int(axis), sign, (rest[0], rest[1]), (rest[2], rest[3]), (x, y, z)
    )


def drawn(frames: list[Frame], number: int) -> list[Frame]:
    """The same frames in draw ``number``: from 1 on each position is off by a micrometre."""
    if number == 0:
        return frames
    rng = np.random.default_rng(number)
    noise = (rng.normal(0, 1e-6, frame.xyz.shape).astype(np.float32) for frame in frames)
    return with_trees([replace(f, xyz=f.xyz + off) for f, off in zip(frames, noise, strict=True)])


def with_trees(frames: list[Frame]) -> list[Frame]:
    """The frames, with the trees made that other tools share: not part of the tracker's cost."""
    for frame in frames:
        _ = frame.kdtree
    return frames
