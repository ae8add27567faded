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
from pointbrush.formats.interpolation import NEAR, Pose
from pointbrush.formats.listing import FrameFile, Listing
from pointbrush.formats.matching import FrameName, listed, matched, partners
from pointbrush.formats.options import Extras, ReadOptions
from pointbrush.formats.poses import Poses, named_file, pose_of, read_poses
from pointbrush.formats.timing import (
    natural_key,
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
_KINDS = re.compile(r"depth|rgb|colou?rs?|registered|images?|img|pose|raw")
"""Words of a file name that tell what its image is of, and not when."""


@dataclass(frozen=True, slots=True)
class Pair:
    """The images of one moment."""

    depth: Path
    color: Path | None
    time: float | None = None


def list_rgbd(folder: Path, options: ReadOptions) -> Listing | None:
    """List the depth images of a folder with their colours as frames; None without such a layout.

    TUM RGB-D: ``depth.txt`` and ``rgb.txt`` list times and files, ``groundtruth.txt`` poses.
    Otherwise: a ``depth`` and a ``color`` (``rgb``) folder, or files named so, matched to each
    other; poses of a file ``.pose.txt`` each (7-Scenes), or a ``pose`` folder.
    Raises BadInputError when lists do not fit, or names of images do not tell pairs.
    """
    tum = (folder / "depth.txt").is_file() and (folder / "rgb.txt").is_file()
    pairs = _tum_pairs(folder) if tum else _paired(folder, options.chosen.by_order)
    if not pairs:
        return None
    times = [pair.time for pair in pairs if pair.time is not None]
    known = times if len(times) == len(pairs) else None
    poses = _poses(folder, pairs, known, options)
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
    of_depth, of_color = ([FrameName("", time) for time, _ in rows] for rows in (depths, colors))
    places = matched(of_depth, of_color)
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
            folder.name, len(alone), len(depths), NEAR, listed([path.name for path in alone]),
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


def _paired(folder: Path, by_order: bool) -> list[Pair]:
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
        for i, (depth, color) in enumerate(
            zip(depths, _colors(depths, colors, by_order), strict=True)
        )
    ]
    return sorted(pairs, key=lambda pair: pair.time or 0.0) if times else pairs


def _moment(path: Path) -> FrameName:
    """The name of an image without its kind: the same for all files of a moment."""
    moment = _KINDS.sub("", path.stem.lower()).strip("._- ")
    return FrameName(f"{moment or path.stem}{path.suffix}")


def _colors(
    depths: Sequence[Path], colors: Sequence[Path], by_order: bool
) -> Sequence[Path | None]:
    """Find the colour image of each depth image; those without a partner are told in warnings.

    Raises BadInputError as ``partners``.
    """
    if not colors:
        return [None] * len(depths)
    moments = [[_moment(path) for path in paths] for paths in (depths, colors)]
    found = partners(*moments, by_order=by_order)
    alone = [path.name for path, place in zip(depths, found, strict=True) if place is None]
    if alone:
        log.warning(
            "%d of %d depth images have no colour: %s", len(alone), len(depths), listed(alone)
        )
    unused = [path.name for place, path in enumerate(colors) if place not in found]
    if unused:
        log.warning(
            "%d of %d colour images have no depth image and are left out: %s",
            len(unused), len(colors), listed(unused),
        )  # fmt: skip
    return [None if place is None else colors[place] for place in found]


def _images(folder: Path, endings: tuple[str, ...]) -> list[Path]:
    found = (path for path in folder.iterdir() if path.suffix.lower() in endings)
    return sorted((path for path in found if not path.name.startswith(".")), key=natural_key)


# ── poses ────────────────────────────────────────────────────────────────────────────────────


def _poses(
    folder: Path, pairs: Sequence[Pair], times: list[float] | None, options: ReadOptions
) -> Poses | None:
    """``T_world_camera`` of each frame: of the named file, of a list, or of a file each."""
    names, by_order = [_moment(pair.depth).file for pair in pairs], options.chosen.by_order
    named = named_file(options)
    if named is not None:
        return read_poses(named, names, times, by_order=by_order)
    try:
        for name in ("groundtruth.txt", "poses.txt"):
            if (folder / name).is_file():
                return read_poses(folder / name, names, times, by_order=by_order)
        return _pose_files(folder, pairs)
    except BadInputError as error:
        log.warning("%s: the poses are not used: %s", folder.name, error)
        return None


def _pose_files(folder: Path, pairs: Sequence[Pair]) -> Poses | None:
    """Poses of a file of 16 numbers each; a frame whose numbers are not finite has none."""
    places = [place for name in POSE_FOLDERS if (place := folder / name).is_dir()]
    files = [path for place in places for path in place.glob("*.txt")]
    files += pairs[0].depth.parent.glob("*.pose.txt")
    if not files:
        return None
    found = partners([_moment(pair.depth) for pair in pairs], [_moment(path) for path in files])
    poses = [None if place is None else _pose_in(files[place]) for place in found]
    if lost := sum(pose is None for pose in poses):
        log.warning(
            "%s: %d of %d frames have no pose, or one that is not finite",
            folder.name, lost, len(poses),
        )  # fmt: skip
    return Poses(poses, f"{files[0].name} …") if lost < len(poses) else None


def _pose_in(path: Path) -> Pose | None:
    """The pose of a file; None for numbers that are not finite, which mark a lost camera."""
    words = path.read_text("utf-8", "replace").split()
    if any(re.fullmatch(r"[-+]?(inf|nan)", word, re.IGNORECASE) for word in words):
        return None
    return pose_of(path.name, words)
