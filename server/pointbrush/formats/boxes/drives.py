"""Boxes of data sets of drives, a table each: Argoverse 2 and nuScenes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pointbrush.formats.boxes.documents import vector
from pointbrush.formats.boxes.figures import Box, FrameBoxes
from pointbrush.formats.feather import PLACE, read_table
from pointbrush.formats.nuscenes import rigid, rows_by_token, tables_in, world_from_sensor
from pointbrush.formats.options import Limits
from pointbrush.formats.poses import of_quaternion

SIZES = ("length_m", "width_m", "height_m")
WORDS = ("category", "track_uuid")
SCANNER = "LIDAR_TOP"
"""Folder of nuScenes' sweeps, in whose coordinates its boxes come."""


def read_argoverse(path: Path) -> Iterator[FrameBoxes]:
    """Read ``annotations.feather``, a row for each object and sweep: cuboids in the vehicle's
    coordinates, as the sweeps are, by the time of their sweep.

    Raises BadInputError for another table, KeyError for one that lacks columns.
    """
    table = read_table(path, Limits(), words=WORDS)
    places = np.stack([np.asarray(table[name], np.float64) for name in PLACE], axis=1)
    sizes = np.stack([np.asarray(table[name], np.float64) for name in SIZES], axis=1)
    frames: dict[int, list[Box]] = {}
    for row, time in enumerate(table["timestamp_ns"].tolist()):
        pose = of_quaternion(f"{path.name} row {row}", places[row])
        name, key = (str(table[word][row]) for word in WORDS)
        box = Box(name, key, pose[:3, 3], sizes[row], pose[:3, :3])
        frames.setdefault(int(time), []).append(box)
    for time, boxes in sorted(frames.items()):
        yield FrameBoxes(None, tuple(boxes), time=time / 1e9)


def read_nuscenes_boxes(path: Path) -> Iterator[FrameBoxes]:
    """Read ``sample_annotation.json``, a row for each object and sample, by the other tables.

    The boxes are the world's; they come in the coordinates of the scanner at the sample's key
    frame, by its time.  Raises BadInputError for missing tables, KeyError for rows that lack
    values.
    """
    tables = tables_in(path.parent)
    category, instance = (
        rows_by_token(path.with_name(f"{name}.json")) for name in ("category", "instance")
    )
    samples: dict[str, list[Box]] = {}
    for token, row in rows_by_token(path).items():
        pose = rigid(row, f"{path.name} {token}")
        width, length, height = vector(row["size"], range(3))
        key = str(row["instance_token"])
        name = str(category[instance[key]["category_token"]]["name"])
        size = np.array([length, width, height])
        box = Box(name, key, pose[:3, 3], size, pose[:3, :3])
        samples.setdefault(row["sample_token"], []).append(box)
    for scan in tables.data:
        if scan.get("is_key_frame") and Path(str(scan.get("filename"))).parent.name == SCANNER:
            boxes = tuple(samples.get(scan["sample_token"], ()))
            found = FrameBoxes(None, boxes, time=float(scan["timestamp"]) / 1e6)
            yield found.moved_back(world_from_sensor(scan, tables.by_token))
