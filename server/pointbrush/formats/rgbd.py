"""Recordings of depth images: TUM RGB-D, 7-Scenes, ScanNet, and pairs of images (Kinect v2)."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.formats.depth_image import Cameras, cameras_of, depth_frame
from pointbrush.formats.image_pairs import colors_of, listed, moment_of
from pointbrush.formats.interpolation import NEAR, Pose
from pointbrush.formats.listing import FrameFile, Listing
from pointbrush.formats.options import Extras, ReadOptions
from pointbrush.formats.poses import Poses, pose_of, read_poses
from pointbrush.formats.timing import (
    natural_key,
    nearest,
    rate_of,
    stated_rate,
    times_of,
)
from pointbrush.frame import PointFrame

log = logging.getLogger(__name__)
IMAGES = (".png", ".tif", ".tiff", ".pgm", ".jpg", ".jpeg", ".bmp", ".ppm")
DEPTH_IMAGES = (".png", ".tif", ".tiff", ".pgm")
DEPTH_FOLDERS = ("depth", "depth_raw", "depths")
COLOR_FOLDERS = ("rgb", "color", "colour", "colors", "registered", "image", "images")
POSE_FOLDERS = ("pose", "poses")
TUM_SCALE = 5000.0


@dataclass(frozen=True, slots=True)
class Pair:
    """The images of one moment."""

    depth: Path
    color: Path | None
    time: float | None = None


def list_rgbd(folder: Path, poses_file: Path | None = None) -> Listing | None:
    """List the depth images of a folder with their colours as frames; None without such a layout.

    TUM RGB-D: ``depth.txt`` and ``rgb.txt`` list times and files, ``groundtruth.txt`` poses.
    Otherwise: a ``depth`` and a ``color`` (``rgb``) folder, or files named so, paired by name, by
    time, else by number; poses of a file ``.pose.txt`` each (7-Scenes), or a ``pose`` folder.
    Raises BadInputError when lists do not fit, or names of images do not tell pairs.
    """
    tum = (folder / "depth.txt").is_file() and (folder / "rgb.txt").is_file()
    pairs = _tum_pairs(folder) if tum else _paired(folder)
    if not pairs:
        return None
    times = [pair.time for pair in pairs if pair.time is not None]
    known = times if len(times) == len(pairs) else None
    poses = _poses(folder, pairs, known, poses_file)
    cameras = cameras_of(pairs[0].depth, TUM_SCALE if tum else None)
    frames = [
        FrameFile(
            pair.depth.name,
            partial(_read, pair, cameras),
            Extras(timestamp=pair.time, pose=poses.matrices[i] if poses else None),
        )
        for i, pair in enumerate(pairs)
    ]
    rate, stated = rate_of(known), stated_rate(folder)
    said = "depth.txt" if tum else "the times of the depth images"
    return Listing(
        "rgbd",
        frames,
        known,
        rate or stated,
        len(frames),
        order=f"by {said}" if known else "by number in the file names",
        rate_from=said if rate else "meta.json" if stated else "",
        poses_from=poses.source if poses else "",
    )


def _read(pair: Pair, cameras: Cameras, options: ReadOptions) -> Iterator[PointFrame]:
    yield depth_frame(pair.depth, pair.color, cameras, options)


# ── TUM RGB-D ────────────────────────────────────────────────────────────────────────────────


def _tum_pairs(folder: Path) -> list[Pair]:
    depths, colors = _timed(folder, "depth.txt"), _timed(folder, "rgb.txt")
    if not depths or not colors:
        raise BadInputError(f"{folder.name}: expected lines in depth.txt and rgb.txt, got none")
    places = nearest([time for time, _ in depths], [time for time, _ in colors], NEAR)
    pairs, alone = [], []
    for (time, depth), place in zip(depths, places, strict=True):
        if place is None:
            alone.append(depth)
        else:
            pairs.append(Pair(depth, colors[place][1], time))
    if not pairs:
        raise BadInputError(
            f"{folder.name}: expected depth and colour images within {NEAR} s, got none"
        )
    if alone:
        log.warning(
            "%s: %d of %d depth images are left out, as there is no colour image within %g s: %s",
            folder.name, len(alone), len(depths), NEAR, listed(alone),
        )  # fmt: skip
    return pairs


def _timed(folder: Path, name: str) -> list[tuple[float, Path]]:
    """Lines ``time file``, by time; raises BadInputError for other lines or absent files."""
    rows = []
    for number, line in enumerate((folder / name).read_text("utf-8", "replace").splitlines(), 1):
        words = line.split("#")[0].split()
        if not words:
            continue
        try:
            time, path = float(words[0]), folder / words[1]
        except (ValueError, IndexError):
            raise BadInputError(
                f"{name} line {number}: expected a time and a file, got another line"
            ) from None
        if not np.isfinite(time) or not path.resolve().is_relative_to(folder.resolve()):
            raise BadInputError(f"{name} line {number}: expected a file within {folder.name}")
        if not path.is_file():
            raise BadInputError(f"{name} line {number}: its file is absent")
        rows.append((time, path))
    return sorted(rows)


# ── pairs of images ──────────────────────────────────────────────────────────────────────────


def _paired(folder: Path) -> list[Pair]:
    inner = {path.name.lower(): path for path in folder.iterdir() if path.is_dir()}
    depth_folder = next((inner[name] for name in DEPTH_FOLDERS if name in inner), None)
    color_folder = next((inner[name] for name in COLOR_FOLDERS if name in inner), None)
    if depth_folder is not None:
        depths = _images(depth_folder, DEPTH_IMAGES)
        colors = _images(color_folder, IMAGES) if color_folder else []
    else:
        images = _images(folder, IMAGES)
        depths = [p for p in images if "depth" in p.stem.lower() and p.suffix.lower() != ".jpg"]
        colors = [p for p in images if re.search(r"rgb|colou?r", p.stem.lower())]
    if not depths:
        return []
    times = times_of(depths, depth_folder or folder)
    pairs = [
        Pair(depth, color, times[i] if times else None)
        for i, (depth, color) in enumerate(zip(depths, colors_of(depths, colors), strict=True))
    ]
    return sorted(pairs, key=lambda pair: pair.time or 0.0) if times else pairs


def _images(folder: Path, endings: tuple[str, ...]) -> list[Path]:
    found = (path for path in folder.iterdir() if path.suffix.lower() in endings)
    return sorted((path for path in found if not path.name.startswith(".")), key=natural_key)


# ── poses ────────────────────────────────────────────────────────────────────────────────────


def _poses(
    folder: Path, pairs: Sequence[Pair], times: list[float] | None, named: Path | None
) -> Poses | None:
    """``T_world_camera`` of each frame: of the named file, of a list, or of a file each."""
    names = [moment_of(pair.depth) or pair.depth.stem for pair in pairs]
    if named is not None:
        return read_poses(named, names, times)
    try:
        for name in ("groundtruth.txt", "poses.txt"):
            if (folder / name).is_file():
                return read_poses(folder / name, names, times)
        return _pose_files(folder, pairs)
    except BadInputError as error:
        log.warning("%s: the poses are not used: %s", folder.name, error)
        return None


def _pose_files(folder: Path, pairs: Sequence[Pair]) -> Poses | None:
    """Poses of a file of 16 numbers each; a frame whose numbers are not finite has none."""
    places = [place for name in POSE_FOLDERS if (place := folder / name).is_dir()]
    files = [path for place in places for path in place.glob("*.txt")]
    files += pairs[0].depth.parent.glob("*.pose.txt")
    by_moment = {moment_of(path): path for path in files}
    found = [by_moment.get(moment_of(pair.depth)) for pair in pairs]
    poses = [None if path is None else _pose_in(path) for path in found]
    known = [path for path, pose in zip(found, poses, strict=True) if path and pose is not None]
    if not known:
        return None
    if len(known) < len(poses):
        log.warning(
            "%s: %d of %d frames have no pose, or one that is not finite",
            folder.name, len(poses) - len(known), len(poses),
        )  # fmt: skip
    return Poses(poses, f"{known[0].name} …")


def _pose_in(path: Path) -> Pose | None:
    """The pose of a file; None for numbers that are not finite, which mark a lost camera."""
    words = path.read_text("utf-8", "replace").split()
    if any(re.fullmatch(r"[-+]?(inf|nan)", word, re.IGNORECASE) for word in words):
        return None
    return pose_of(path.name, words)
