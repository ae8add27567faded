"""Recordings of depth images: TUM RGB-D, 7-Scenes, ScanNet, and pairs of images (Kinect v2)."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.formats.cameras.depth_image import Cameras, cameras_of, depth_frame
from pointbrush.formats.cameras.image_pairs import (
    FoundPairs,
    Pair,
    find_depths,
    find_pairs,
    moment_of,
    streams_in,
)
from pointbrush.formats.geometry.interpolation import NEAR, Pose
from pointbrush.formats.geometry.poses import Poses, named_file, pose_of, read_poses
from pointbrush.formats.inside import file_in
from pointbrush.formats.listing import DepthFacts, FrameFile, Listing
from pointbrush.formats.options import Extras, ReadOptions
from pointbrush.formats.times.matching import FrameName, listed, matched, partners
from pointbrush.formats.times.time_order import order_by_time
from pointbrush.formats.times.timing import rate_of, stated_rate
from pointbrush.frame import PointFrame

log = logging.getLogger(__name__)
POSE_FOLDERS = ("pose", "poses")
TUM_SCALE = 5000.0


def list_rgbd(folder: Path, options: ReadOptions) -> Listing | None:
    """List the depth images of a folder with their colours as frames; None without such a layout.

    TUM RGB-D: ``depth.txt`` and ``rgb.txt`` list times and files, ``groundtruth.txt`` poses.
    Otherwise pairs as ``find_pairs`` finds them; poses of a file ``.pose.txt`` each (7-Scenes), or
    a ``pose`` folder.
    Raises BadInputError if lists do not fit, or if images cannot be paired by name.
    """
    tum = _has_lists(folder)
    found = _tum_pairs(folder) if tum else find_pairs(folder, options)
    if found is None:
        return None
    pairs, order = found.pairs, found.order
    known = [pair.time for pair in pairs if pair.time is not None] or None
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
    colored = sum(pair.color is not None for pair in pairs)
    return Listing(
        "rgbd",
        frames,
        known,
        rate or stated,
        len(frames),
        order=order.source,
        rate_from=order.times if rate else "meta.json" if stated else "",
        poses_from=poses.source if poses else "",
        depth=DepthFacts(
            f"{found.color}, {colored} of {len(pairs)} frames" if colored else "none",
            cameras.depth.source or f"assumed: {cameras.depth.assumed}",
            found.unused,
        ),
    )


def has_depth_images(folder: Path) -> bool:
    """Return whether a folder, or one of its folders, has the depth images of ``list_rgbd``."""
    return _has_lists(folder) or bool(find_depths(folder, *streams_in(folder)))


def _has_lists(folder: Path) -> bool:
    return (folder / "depth.txt").is_file() and (folder / "rgb.txt").is_file()


def _read(pair: Pair, cameras: Cameras, options: ReadOptions) -> Iterator[PointFrame]:
    yield depth_frame(pair.depth, pair.color, cameras, options)


# ── TUM RGB-D ────────────────────────────────────────────────────────────────────────────────


def _tum_pairs(folder: Path) -> FoundPairs:
    depths, colors = _timed(folder, "depth.txt"), _timed(folder, "rgb.txt")
    if not depths or not colors:
        raise BadInputError(f"{folder.name}: expected lines in depth.txt and rgb.txt, got none")
    order = order_by_time([time for time, _ in depths], "depth.txt", "by line in depth.txt")
    depths = [depths[place] for place in order.places]
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
    return FoundPairs(pairs, order, "rgb.txt")


def _timed(folder: Path, name: str) -> list[tuple[float, Path]]:
    """Read lines ``time file``; raises BadInputError for other lines or absent files."""
    rows = []
    for number, line in enumerate((folder / name).read_text("utf-8", "replace").splitlines(), 1):
        words = line.split("#")[0].split()
        if not words:
            continue
        try:
            time, path = float(words[0]), file_in(folder, words[1])
        except (ValueError, IndexError):
            raise BadInputError(
                f"{name} line {number}: expected a time and a file, got another line"
            ) from None
        if not np.isfinite(time) or path is None:
            raise BadInputError(f"{name} line {number}: expected a file within {folder.name}")
        rows.append((time, path))
    return rows


# ── poses ────────────────────────────────────────────────────────────────────────────────────


def _poses(
    folder: Path, pairs: Sequence[Pair], times: list[float] | None, options: ReadOptions
) -> Poses | None:
    """``T_world_camera`` of each frame: of the named file, of a list, or of a file each."""
    names, by_order = [moment_of(pair.depth).file for pair in pairs], options.chosen.by_order
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
    """Read poses from files of 16 numbers each; a frame without finite numbers has none."""
    places = [place for name in POSE_FOLDERS if (place := folder / name).is_dir()]
    files = [path for place in places for path in place.glob("*.txt")]
    files += pairs[0].depth.parent.glob("*.pose.txt")
    if not files:
        return None
    found = partners([moment_of(pair.depth) for pair in pairs], [moment_of(path) for path in files])
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
