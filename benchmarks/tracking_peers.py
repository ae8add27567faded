"""What `auto` is compared with: registrations of other libraries, in the paper's loop.

A peer registers the object's points to the next frame; the points near the moved object get the
label, as in ``pointbrush.tracking.icp``.  Open3D and small_gicp are no dependencies: they are
installed into a folder of the benchmark's own when they are asked for.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.tracking import FrameResult, Seed, TrackOptions, TrackState
from pointbrush.tracking.compute.rigid import transform
from pointbrush.tracking.icp import PaperTracker, _begun, _Object, _painted
from pointbrush.tracking.interface import Frames, Known, TrackFrame

F64 = NDArray[np.float64]
FOLDER = (
    Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "pointbrush-benchmark-peers"
)
FAR = 0.3
"""Metres within which a peer pairs points."""
FEW = 12
"""Points under which neighbourhoods have no normal and no covariance."""


@dataclass(frozen=True)
class Cloud:
    """Points (N, 3) in metres and their colours (N, 3), 0 to 255."""

    xyz: F64
    rgb: F64


Register = Callable[[_Object, TrackFrame], F64]
"""An object's points in the last frame, the next frame -> ``T_target_source`` (4, 4)."""
FromLibrary = Callable[[Any, Cloud, Cloud, float], F64]
"""The library, source, target, the source's point spacing in metres -> the same."""


def stay(_thing: _Object, _frame: TrackFrame) -> F64:
    """Copy labels to the nearest points: nothing has moved."""
    return np.eye(4)


def _register(fit: FromLibrary, library: Any, track: _Object, frame: TrackFrame) -> F64:
    """Register to what of the frame lies within ``FAR`` of the object's box.

    No farther point could be paired, and a peer that sees only these is many times as fast.
    """
    low, high = track.xyz.min(axis=0) - FAR, track.xyz.max(axis=0) + FAR
    near = np.flatnonzero(((frame.xyz >= low) & (frame.xyz <= high)).all(axis=1))
    if min(len(near), len(track.xyz)) < FEW:
        return np.eye(4)
    rgb = np.zeros((len(near), 3)) if frame.rgb is None else frame.rgb[near].astype(np.float64)
    target = Cloud(frame.xyz[near].astype(np.float64), rgb)
    try:
        T = fit(library, Cloud(track.xyz, track.colour), target, track.spacing)
    except RuntimeError:  # a peer that found no pairs
        return np.eye(4)
    return T if np.isfinite(T).all() else np.eye(4)


@dataclass(frozen=True)
class Peer:
    """A ``Method`` out of a registration of the last frame's labelled points."""

    register: Register

    def track(
        self,
        frames: Frames,
        order: Sequence[int],
        seeds: Sequence[Seed],
        known: Known,  # noqa: ARG002  # the benchmark's recordings carry no other labels
        options: TrackOptions,  # noqa: ARG002
    ) -> Iterator[FrameResult]:
        """See ``Method.track``."""
        first = frames(order[0])
        objects = {s.label: _begun(first, s.indices, np.eye(4)) for s in seeds}
        yield FrameResult(
            order[0], {}, {s.label: _painted(len(s.indices), np.eye(4)) for s in seeds}
        )
        for number in order[1:]:
            frame, found, tracks = frames(number), {}, {}
            for label, track in objects.items():
                T = self.register(track, frame)
                near = frame.kdtree.query_ball_point(
                    transform(T, track.xyz), PaperTracker.reach * track.spacing
                )
                points = np.unique(np.concatenate([np.asarray(n, np.int64) for n in near]))
                inliers = float(np.mean([len(n) > 0 for n in near]))
                found[label] = points
                tracks[label] = TrackState(T, 0.0, inliers, inliers, len(points), "tracked")
                if len(points):
                    objects[label] = _begun(frame, points, T @ track.pose)
            yield FrameResult(number, found, tracks)


def _open3d_cloud(o3d: Any, cloud: Cloud, normals: bool) -> Any:
    made = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(cloud.xyz))
    if normals:
        made.colors = o3d.utility.Vector3dVector(cloud.rgb / 255.0)
        made.estimate_normals()
    return made


def _open3d_icp(o3d: Any, source: Cloud, target: Cloud, _spacing: float) -> F64:
    a, b = (_open3d_cloud(o3d, cloud, False) for cloud in (source, target))
    return np.asarray(o3d.pipelines.registration.registration_icp(a, b, FAR).transformation)


def _open3d_color(o3d: Any, source: Cloud, target: Cloud, _spacing: float) -> F64:
    a, b = (_open3d_cloud(o3d, cloud, True) for cloud in (source, target))
    return np.asarray(o3d.pipelines.registration.registration_colored_icp(a, b, FAR).transformation)


def _small_gicp(library: Any, source: Cloud, target: Cloud, spacing: float) -> F64:
    fit = library.align(
        target.xyz, source.xyz, downsampling_resolution=spacing, max_correspondence_distance=FAR
    )
    return np.asarray(fit.T_target_source)


def _import_open3d(folder: Path) -> Any:
    # The library without its package, which wants dash, flask and notebooks to draw with.
    path = next((folder / "open3d").glob("pybind.*.so"))
    spec = importlib.util.spec_from_file_location("open3d.pybind", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.utility.set_verbosity_level(module.utility.VerbosityLevel.Error)
    return module


def _import_small_gicp(folder: Path) -> Any:
    sys.path.append(str(folder))
    return importlib.import_module("small_gicp")


LIBRARIES = {"open3d==0.20.0": _import_open3d, "small_gicp==1.0.1": _import_small_gicp}
PEERS: dict[str, tuple[str, FromLibrary]] = {
    "open3d-icp": ("open3d==0.20.0", _open3d_icp),
    "open3d-color": ("open3d==0.20.0", _open3d_color),
    "small_gicp": ("small_gicp==1.0.1", _small_gicp),
}
"""Name -> the library that it needs, and its registration."""


def peer(name: str) -> Peer:
    """A peer, installed when it is not there; raises ImportError that says why it cannot be."""
    requirement, fit = PEERS[name]
    return Peer(partial(_register, fit, _library(requirement)))


@cache
def _library(requirement: str) -> Any:
    try:
        return LIBRARIES[requirement](_installed(requirement))
    except (ImportError, OSError, StopIteration) as error:
        raise ImportError(f"{requirement}: {error or 'no library in its wheel'}") from error


def _installed(requirement: str) -> Path:
    """The folder of a library; raises ImportError when it cannot be installed."""
    folder = FOLDER / requirement
    if folder.is_dir():
        return folder
    print(
        f"== {requirement} for this benchmark only, from PyPI into {folder}",
        file=sys.stderr,
        flush=True,
    )
    partial_folder = folder.with_suffix(f".partial-{os.getpid()}")
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--only-binary"]
    command += [":all:", "--target", str(partial_folder), requirement]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        shutil.rmtree(partial_folder, ignore_errors=True)
        errors = [line for line in done.stderr.splitlines() if line.startswith("ERROR")]
        raise ImportError(errors[-1] if errors else f"pip ended with {done.returncode}")
    partial_folder.rename(folder)
    return folder
