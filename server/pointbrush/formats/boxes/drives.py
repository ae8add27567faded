"""Boxes of data sets of drives in tables: Argoverse 2, nuScenes, Waymo."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.formats.boxes.attributes import of_dotted
from pointbrush.formats.boxes.conventions import box_by
from pointbrush.formats.boxes.documents import vector
from pointbrush.formats.boxes.figures import FrameBox, FrameBoxes
from pointbrush.formats.geometry.poses import of_quaternion
from pointbrush.formats.options import Limits, require_count
from pointbrush.formats.readers.feather import PLACE, read_table
from pointbrush.formats.readers.nuscenes import rigid, rows_by_token, tables_in, world_from_sensor
from pointbrush.geometry.oriented_box import AttributeValue

SIZES = ("length_m", "width_m", "height_m")
WORDS = ("category", "track_uuid")
_WAYMO = "[LiDARBoxComponent]"
WAYMO_BOX = (
    *(f"{_WAYMO}.box.center.{axis}" for axis in "xyz"),
    *(f"{_WAYMO}.box.size.{axis}" for axis in "xyz"),
    f"{_WAYMO}.box.heading",
)
WAYMO_TYPE = f"{_WAYMO}.type"
WAYMO_KEYS = ("key.frame_timestamp_micros", "key.laser_object_id")
WAYMO_TYPES = {0: "unknown", 1: "vehicle", 2: "pedestrian", 3: "sign", 4: "cyclist"}
SCANNER = "LIDAR_TOP"
"""Folder of nuScenes' sweeps, which define the coordinates of its boxes."""


def read_argoverse(path: Path) -> Iterator[FrameBoxes]:
    """Read ``annotations.feather``, a row for each object and sweep: cuboids in the vehicle's
    coordinates, as the sweeps are, by the time of their sweep.

    Raises BadInputError for another table, KeyError for one that lacks columns.
    """
    table = read_table(path, Limits(), words=WORDS)
    places = np.stack([np.asarray(table[name], np.float64) for name in PLACE], axis=1)
    sizes = np.stack([np.asarray(table[name], np.float64) for name in SIZES], axis=1)
    frames: dict[int, list[FrameBox]] = {}
    for row, time in enumerate(table["timestamp_ns"].tolist()):
        of_quaternion(f"{path.name} row {row}", places[row])
        name, key = (str(table[word][row]) for word in WORDS)
        turn = places[row][[6, 3, 4, 5]]
        box = box_by("argoverse", name, key, places[row][:3], sizes[row], turn)
        frames.setdefault(int(time), []).append(box)
    for time, boxes in sorted(frames.items()):
        yield FrameBoxes(None, tuple(boxes), time=time / 1e9)


def read_nuscenes_boxes(path: Path) -> Iterator[FrameBoxes]:
    """Read ``sample_annotation.json``, a row for each object and sample, by the other tables.

    The file's boxes are in world coordinates; they are returned in the coordinates of the scanner
    at the sample's key frame, by its time.  Raises BadInputError for missing tables, KeyError for
    rows that lack values.
    """
    tables = tables_in(path.parent)
    category, instance, attribute, visibility = (
        rows_by_token(table) if (table := path.with_name(f"{name}.json")).is_file() else {}
        for name in ("category", "instance", "attribute", "visibility")
    )
    samples: dict[str, list[FrameBox]] = {}
    for token, row in rows_by_token(path).items():
        rigid(row, f"{path.name} {token}")
        place, size = (vector(row[field], range(3)) for field in ("translation", "size"))
        turn, key = vector(row["rotation"], range(4)), str(row["instance_token"])
        name = str(category[instance[key]["category_token"]]["name"])
        attributes = _attributes(row, attribute, visibility)
        box = box_by("nuscenes", name, key, place, size, turn, attributes=attributes)
        samples.setdefault(row["sample_token"], []).append(box)
    for scan in tables.data:
        if scan.get("is_key_frame") and Path(str(scan.get("filename"))).parent.name == SCANNER:
            boxes = tuple(samples.get(scan["sample_token"], ()))
            found = FrameBoxes(None, boxes, time=float(scan["timestamp"]) / 1e6)
            yield found.moved_back(world_from_sensor(scan, tables.by_token))


def _attributes(
    row: Mapping[str, Any], attribute: Mapping[str, Any], visibility: Mapping[str, Any]
) -> dict[str, AttributeValue]:
    """Read the attributes of an annotation by their tables, ``vehicle.parked``; the level of its
    visibility is one of them."""
    tokens = row.get("attribute_tokens") or []
    attributes = dict(
        of_dotted(str(attribute[token]["name"])) for token in tokens if token in attribute
    )
    if (seen := str(row.get("visibility_token"))) in visibility:
        attributes["visibility"] = str(visibility[seen]["level"])
    return attributes


def read_waymo(path: Path) -> Iterator[FrameBoxes]:
    """Read the component ``lidar_box`` of the Waymo Open Dataset, version 2: upright boxes in the
    vehicle's coordinates, by the time of their frame.

    Raises BadInputError for another file, KeyError for one that lacks columns.
    """
    import pyarrow as pa
    from pyarrow import parquet

    try:
        wanted = [*WAYMO_KEYS, *WAYMO_BOX, WAYMO_TYPE]
        require_count(path.name, parquet.read_metadata(path).num_rows, Limits())
        rows = parquet.read_table(path, columns=wanted).to_pylist()
    except (pa.ArrowException, OSError) as error:
        reason = str(error).split("\n")[0][:120]
        raise BadInputError(f"{path.name}: expected a parquet table, {reason}") from None
    frames: dict[int, list[FrameBox]] = {}
    for row in rows:
        numbers = vector(row, WAYMO_BOX)
        name, key = WAYMO_TYPES.get(int(row[WAYMO_TYPE]), "unknown"), str(row[WAYMO_KEYS[1]])
        box = box_by("waymo", name, key, numbers[:3], numbers[3:6], numbers[6:])
        frames.setdefault(int(row[WAYMO_KEYS[0]]), []).append(box)
    for time, boxes in sorted(frames.items()):
        yield FrameBoxes(None, tuple(boxes), time=time / 1e6)
