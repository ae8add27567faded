"""Poses and pictures in files beside the frames of a folder."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from pathlib import Path

from pointbrush.errors import BadInputError
from pointbrush.formats.cameras.kitti_cameras import kitti_pictures
from pointbrush.formats.cameras.pictures import FILE as CAMERAS_FILE
from pointbrush.formats.cameras.pictures import PictureSource, read_cameras_file
from pointbrush.formats.geometry.poses import Poses, find_poses, named_file, read_poses
from pointbrush.formats.listing import INNER
from pointbrush.formats.options import ReadOptions
from pointbrush.formats.readers.feather import argoverse_poses
from pointbrush.formats.readers.nuscenes import (
    Tables,
    nuscenes_pictures,
    nuscenes_poses,
    read_tables,
)
from pointbrush.formats.registry import Format
from pointbrush.formats.tables.names import VIEWPOINT

log = logging.getLogger(__name__)


def find_tables(entry: Format, folder: Path) -> Tables | None:
    """Return nuScenes' tables beside sweeps; warn of damaged ones."""
    try:
        return read_tables(folder) if entry.name in ("nuscenes", "bin") else None
    except BadInputError as error:
        log.warning("%s: the tables are not used: %s", folder.name, error)
        return None


def pictures_beside(
    entry: Format,
    files: Sequence[Path],
    folder: Path,
    options: ReadOptions,
    tables: Tables | None,
) -> PictureSource | None:
    """Return camera pictures beside the frames; warn of pictures that do not fit a layout."""
    names = [path.name for path in files]
    for place in (folder, folder.parent) if folder.name.lower() in INNER else (folder,):
        if (place / CAMERAS_FILE).is_file():
            return read_cameras_file(place / CAMERAS_FILE, names, options.limits)
    try:
        if entry.name in ("nuscenes", "bin") and folder.parent.name in ("samples", "sweeps"):
            return nuscenes_pictures(tables, files, folder, options.limits)
        if entry.name in ("kitti", "bin"):
            return kitti_pictures(files, folder, options.limits)
    except BadInputError as error:
        log.warning("%s: the pictures are not used: %s", folder.name, error)
    return None


def poses_beside(
    entry: Format,
    files: Sequence[Path],
    folder: Path,
    times: list[float] | None,
    options: ReadOptions,
    tables: Tables | None,
) -> Poses | None:
    """Return poses beside the frames, or from a file that the user names.

    Poses of a KITTI layout and named ones must fit; a warning reports other ones that do not.
    """
    if options.chosen.poses in ("none", VIEWPOINT):
        return None
    names = [path.name for path in files]
    named = named_file(options)
    if named is not None:
        return read_poses(named, names, times, by_order=options.chosen.by_order)
    kitti = entry.name in ("kitti", "bin")
    try:
        if entry.name == "feather":
            return argoverse_poses(folder.parent.parent, times, options.limits)
        poses = nuscenes_poses(tables, files)
        if poses is not None:
            return poses
        by_order = options.chosen.by_order
        return find_poses(folder, names, times, above=kitti, by_order=by_order)
    except BadInputError as error:
        if kitti:
            raise
        log.warning("%s: the poses are not used: %s", folder.name, error)
        return None
