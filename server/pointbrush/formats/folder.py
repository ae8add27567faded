"""Frames of a recording among the files of a folder, their order and times."""

from __future__ import annotations

import logging
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path

import numpy as np

from pointbrush.errors import BadInputError, TooLargeError
from pointbrush.formats.beside import find_tables, pictures_beside, poses_beside
from pointbrush.formats.cameras.image_pairs import folders_in
from pointbrush.formats.cameras.rgbd import has_depth_images, list_rgbd
from pointbrush.formats.listing import FrameFile, Listing
from pointbrush.formats.options import Extras, ReadOptions
from pointbrush.formats.readers.feather import POSES as ARGOVERSE_POSES
from pointbrush.formats.readers.kitti import find_label
from pointbrush.formats.registry import Format, advice, format_by_name, format_named, format_of
from pointbrush.formats.ros.listing import list_bags
from pointbrush.formats.tables.datasets import SEMANTIC_KITTI
from pointbrush.formats.times.timing import (
    TIME_FILES,
    assumed_rate,
    in_order,
    order_of,
    rate_of,
    stated_rate,
    times_of,
)
from pointbrush.frame import PointFrame

log = logging.getLogger(__name__)

# Text and binary files beside frames that are not frames.
SIDECARS = {
    *TIME_FILES,
    *("poses.txt", "calib.txt", "calibration.txt", "rgb.txt", "depth.txt", "groundtruth.txt"),
    *("associations.txt", "accelerometer.txt", "license.txt", "licence.txt", "readme.txt"),
    *("camera.txt", "intrinsics.txt", "imu.txt", "imu.csv", "poses.csv", "tracks.csv"),
    *("requirements.txt", "labels.txt", "classes.txt", "calib_cam_to_cam.txt", "log.txt"),
    *("city_se3_egovehicle.feather", "annotations.feather"),
    *("calib_velo_to_cam.txt", "calib_imu_to_velo.txt", "provenance.npy", "label.npy"),
}


NO_SENSOR = re.compile("^(raw|npz)$|label|annot|segm|mask|predict|result|truth")
"""Names of folders with a second format of the recording, or with other data per point."""
PROFILES = "sick_points"
"""Folder with the profiles of KITTI-360's second scanner, which are no clouds."""
NO_CLOUDS = (
    "profiles of KITTI-360's SICK scanner, of two coordinates a point; velodyne_points is read"
)
ARGOVERSE_SCANS = "sensors/lidar"
"""Folder of the scans in a log of Argoverse 2, among other tables."""


def list_folder(folder: Path, format: str | None, options: ReadOptions) -> Listing:
    """List the recording in a folder, from its point files or images, or from its only subfolder
    with such files.  Files with weak endings (notes.txt) are used only without other files.

    Raises BadInputError for none, for several formats, or for several recordings.
    """
    if _has_profiles(folder):
        raise BadInputError(f"{folder.name}: expected clouds of points, got {NO_CLOUDS}")
    scans = folder / ARGOVERSE_SCANS
    if (folder / ARGOVERSE_POSES).is_file() and scans.is_dir():
        return list_folder(scans, format, options)
    for weakly in (False, True):
        found = _directly(folder, format, options, weakly)
        if found is not None:
            _warn_of_others(folder, None, format, options, images=found.depth is None)
            return found
        inside = _subfolder(folder, format, options, weakly)
        if inside is not None:
            _warn_of_others(folder, inside, format, options)
            return list_folder(inside, format, options)
    files = _files(folder, options)
    seen = ", ".join(sorted({path.suffix or path.name for path in files})[:8]) or "no files"
    seen += advice(_below(folder))
    raise BadInputError(f"{folder.name}: expected a folder with point cloud files, got {seen}")


def _below(folder: Path) -> Iterator[Path]:
    """Return the files of a folder and of its subfolders."""
    return (path for pattern in ("*", "*/*") for path in sorted(folder.glob(pattern)))


def _directly(
    folder: Path, format: str | None, options: ReadOptions, weakly: bool
) -> Listing | None:
    """List the folder's own files: point files, else images."""
    chosen = _point_files(folder, _files(folder, options), format, weakly, options)
    if chosen:
        return list_files(chosen, format, folder, options)
    return list_rgbd(folder, options) if _reads_images(format) else None


def frames_among(files: Sequence[Path], options: ReadOptions) -> list[Path]:
    """Return the files without files about the frames: times, poses, calibration."""
    poses = options.chosen.poses_file
    named = None if poses is None else poses.absolute()
    return [
        path for path in files if path.name.lower() not in SIDECARS and path.absolute() != named
    ]


def _reads_images(format: str | None) -> bool:
    return format is None or format_named(format).name == "rgbd"


def _files(folder: Path, options: ReadOptions) -> list[Path]:
    files: list[Path] = []
    for path in folder.iterdir():
        if path.is_file() and not path.name.startswith("."):
            files.append(path)
            if len(files) > options.limits.max_files:
                raise TooLargeError(
                    f"{folder.name}: expected at most {options.limits.max_files} files, got more"
                )
    return in_order(files)


def _point_files(
    folder: Path, files: list[Path], format: str | None, weakly: bool, options: ReadOptions
) -> list[Path]:
    """The frames among the files of a folder; raises BadInputError for several formats."""
    candidates = frames_among(files, options)
    if format is not None:
        wanted = format_named(format)
        if wanted.name == "rgbd":
            return []
        endings = wanted.extensions or (".bin",)
        # XYZRGB records often have the ending .bin instead of their own.
        endings += (".bin",) if wanted.name == "xyzrgb" else ()
        return [path for path in candidates if path.name.lower().endswith(endings)]
    found = [(path, entry) for path in candidates if (entry := format_by_name(path)) is not None]
    sure = [(path, entry) for path, entry in found if path.suffix.lower() not in entry.weak]
    found = sure or (found if weakly else [])
    names = Counter(entry.name for _, entry in found)
    if len(names) > 1:
        listed = " and ".join(f"{count} {name}" for name, count in names.most_common())
        raise BadInputError(
            f"{folder.name}: expected files of one format, got {listed} files; "
            "name the format to read"
        )
    return [path for path, _ in found]


def _warn_of_others(
    folder: Path,
    taken: Path | None,
    format: str | None,
    options: ReadOptions,
    *,
    images: bool = True,
) -> None:
    """Warn of folders with points or depth images that are not read, such as another sensor's."""
    others = []
    for place in folders_in(folder):
        if _has_profiles(place):
            log.warning("%s: %s is left out: %s", folder.name, PROFILES, NO_CLOUDS)
        elif place != taken and not NO_SENSOR.search(place.name.lower()):
            with suppress(BadInputError):
                others += [place.name] * _has_points(place, format, options, False, images)
    if others:
        log.warning(
            "%s: %s read; left out, as points of another sensor: %s; import these by the path of "
            "their folder, as %s/%s", folder.name,
            "its own files are" if taken is None else f"the folder {taken.name} is",
            ", ".join(others), folder.name, others[0],
        )  # fmt: skip


def _has_profiles(folder: Path) -> bool:
    return PROFILES in (folder.name, folder.parent.name) and any(folder.rglob("*.bin"))


def _subfolder(folder: Path, format: str | None, options: ReadOptions, weakly: bool) -> Path | None:
    """Return the subfolder to read instead of a folder without points."""
    inner = folders_in(folder)
    by_name = {path.name.lower(): path for path in inner}
    if "raw" in by_name and _reads_raw(by_name["raw"], format, options, weakly, "npz" in by_name):
        return by_name["raw"]
    for name in ("npz", "velodyne", "velodyne_points", "data", "sequences", "sensors", "lidar"):
        if name in by_name and _has_points(by_name[name], format, options, weakly):
            return by_name[name]
    holding = [path for path in inner if _has_points(path, format, options, weakly)]
    if len(holding) > 1:
        listed = ", ".join(path.name for path in holding[:8])
        raise BadInputError(
            f"{folder.name}: expected one recording, got {len(holding)} folders with point clouds "
            f"({listed}); import them one by one, or as sensors of one recording with an "
            "extrinsics.json that has their mounts"
        )
    return holding[0] if holding else None


def _reads_raw(
    raw: Path, format: str | None, options: ReadOptions, weakly: bool, has_npz: bool
) -> bool:
    """Return whether ``raw`` is of a format with a known layout; its .npz may hold anything."""
    chosen = _point_files(raw, _files(raw, options), format, weakly, options)
    if not chosen:
        return not has_npz and _has_points(raw, format, options, weakly)
    entry = format_by_name(chosen[0])
    anything = entry is None or entry.name in ("text", "npy", "npz")
    return not (has_npz and anything)


def _has_points(
    folder: Path,
    format: str | None,
    options: ReadOptions,
    weakly: bool,
    images: bool = True,
    depth: int = 4,
) -> bool:
    if _point_files(folder, _files(folder, options), format, weakly, options):
        return True
    if images and _reads_images(format) and has_depth_images(folder):
        return True
    inner = (path for path in folder.iterdir() if path.is_dir() and not path.is_symlink())
    return depth > 0 and any(
        _has_points(path, format, options, weakly, images, depth - 1) for path in inner
    )


def list_files(
    files: Sequence[Path], format: str | None, folder: Path, options: ReadOptions
) -> Listing:
    """List files as the frames of a recording, in the given order or by a timestamp file.

    Raises BadInputError for several formats, or a timestamp file that does not fit.
    """
    entry = _format_of(files, format)
    whole = len(files) > 1 or {path.name for path in _files(folder, options)} <= {
        files[0].name,
        *SIDECARS,
    }
    # A frame without echoes among frames with some.
    empty = [len(files) > 1 and entry.headless and not path.stat().st_size for path in files]
    if all(empty):
        empty = [False] * len(files)
    times = times_of(files, folder) if whole else None
    order = order_of(files, folder, times)
    ordered = [files[i] for i in order.places]
    if entry.bag is not None:
        return list_bags(entry, entry.bag, ordered, options)
    tables = find_tables(entry, folder) if whole else None
    has_poses = whole or options.chosen.poses_file is not None
    poses = poses_beside(entry, files, folder, times, options, tables) if has_poses else None
    frames = [
        FrameFile(
            files[i].name,
            partial(_empty if empty[i] else entry.read, files[i]),
            Extras(
                timestamp=times[i] if times else None,
                pose=poses.matrices[i] if poses else None,
            ),
        )
        for i in order.places
    ]
    pictures = pictures_beside(entry, ordered, folder, options, tables) if whole else None
    times = [times[i] for i in order.places] if times else None
    rate, stated = rate_of(times), stated_rate(folder)
    return Listing(
        entry.name,
        frames,
        times,
        rate or stated,
        len(files),
        order=order.source,
        rate_from=order.times if rate else "meta.json" if stated else "",
        assumed_fps=assumed_rate(entry.name, folder),
        poses_from=poses.source if poses else "",
        pictures=pictures,
        # A .label file has SemanticKITTI's classes in any folder.
        dataset=SEMANTIC_KITTI.name if entry.headless and any(map(find_label, files)) else "",
    )


def _format_of(files: Sequence[Path], format: str | None) -> Format:
    """Return the named format, or the format of all files; raise BadInputError for several."""
    entries = [format_named(format) if format else format_of(path) for path in files]
    names = sorted({entry.name for entry in entries})
    if len(names) > 1:
        raise BadInputError(f"path: expected files of one format, got {' and '.join(names)}")
    return entries[0]


def _empty(path: Path, options: ReadOptions) -> Iterator[PointFrame]:  # noqa: ARG001 – a reader
    """Yield a frame without points."""
    known = options.known
    yield PointFrame(np.empty((0, 3), np.float32), pose=known.pose, timestamp=known.timestamp)
