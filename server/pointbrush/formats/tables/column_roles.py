"""Roles of columns by their names in various programs.

Names of PLY properties, PCD and LAS fields, CSV headers and structured NumPy arrays differ by
program; one table here lists the known ones.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Iterable, Mapping
from typing import Any

from numpy.typing import NDArray

from pointbrush.formats.options import ReadOptions
from pointbrush.formats.tables.corrections import LEFT_OUT, meanings

Array = NDArray[Any]
log = logging.getLogger(__name__)

ROLES: dict[str, tuple[str, ...]] = {
    "x": (
        *("x", "px", "posx", "pos_x", "position_x", "point_x", "//x", "#x", "x_m", "easting"),
        *("points_m_xyz:0", "points:0", "points_0", "x_coord", "coord_x", "x_coordinate"),
    ),
    "y": (
        *("y", "py", "posy", "pos_y", "position_y", "point_y", "y_m", "northing"),
        *("points_m_xyz:1", "points:1", "points_1", "y_coord", "coord_y", "y_coordinate"),
    ),
    "z": (
        *("z", "pz", "posz", "pos_z", "position_z", "point_z", "z_m", "elevation", "height"),
        *("points_m_xyz:2", "points:2", "points_2", "z_coord", "coord_z", "z_coordinate"),
    ),
    "red": ("red", "r", "diffuse_red", "scalar_red", "color_red", "rf", "colorred"),
    "green": ("green", "g", "diffuse_green", "scalar_green", "color_green", "gf", "colorgreen"),
    "blue": ("blue", "b", "diffuse_blue", "scalar_blue", "color_blue", "bf", "colorblue"),
    "rgb": ("rgb", "rgba"),
    "intensity": (
        *("intensity", "scalar_intensity", "intensities", "reflectance", "scalar_reflectance"),
        *("reflectivity", "remission", "scalar_scalar_intensity", "i"),
    ),
    "label": (
        *("label", "scalar_label", "labels", "label_id", "semantic", "semantic_label"),
        *("sem_label", "class_id", "scalar_scalar_label", "class", "scalar_class", "segment"),
        *("scalar_segment", "semantic_class", "objtag", "obj_tag", "object_tag", "sem_class"),
    ),
    "instance": (
        *("instance", "scalar_instance", "instance_id", "instance_label", "ins_label"),
        *("object_id", "scalar_scalar_instance", "objidx", "obj_idx", "object_index"),
        *("treeid", "tree_id", "object"),
    ),
}
UNIT = re.compile(r"[\s_/]*(?:\[[^\]]*\]|\([^)]*\)|(?<=[\s/_])(?:mm|cm|dm|m|km|ft|in))$", re.ASCII)
"""End of a column's name that is its unit: ``x [m]``, ``y(mm)``, ``z / m``, ``x_cm``."""
MEASURED = ("x", "y", "z", "intensity")
"""Roles of columns that may have a unit."""
LIKE_LABELS = re.compile(
    r"label|class|segm|semantic|instance|category|annot|obj(ect)?_?(id|tag|idx)|^tag$", re.ASCII
)
"""Names of fields that look like labels."""


def roles(names: Iterable[str]) -> dict[str, str]:
    """Return the name in the file for each role; the earliest synonym in ROLES wins.

    Names without their units take the roles that no full name takes.
    """
    by_lower: dict[str, str] = {}
    for name in names:
        by_lower.setdefault(name.strip().strip("\"'").lower(), name)
    without_unit: dict[str, str] = {}
    for lower, name in by_lower.items():
        without_unit.setdefault(UNIT.sub("", lower), name)
    found: dict[str, str] = {}
    for role, synonyms in ROLES.items():
        tables = (by_lower, without_unit) if role in MEASURED else (by_lower,)
        named = (table[each] for table in tables for each in synonyms if each in table)
        if name := next(named, ""):
            found[role] = name
    return found


def unit_of(name: str) -> str:
    """Return the unit at the end of a column's name, "" without one."""
    match = UNIT.search(name.strip().strip("\"'").lower())
    return match[0].strip(" /_[()]") if match else ""


def name_left_out(name: str, columns: Iterable[str], found: Mapping[str, str]) -> None:
    """Warn of fields of file ``name`` that look like labels if none is read as labels."""
    if "label" in found:
        return
    instance = columns.get(found.get("instance", "")) if isinstance(columns, Mapping) else None
    if instance is not None and instance.any():
        log.warning(
            "%s: the instances of %s have no classes: they are kept as a field and make no labels; "
            "columns %s=label makes each one a label", name, found["instance"], found["instance"],
        )  # fmt: skip
    used = set(found.values())
    left = [
        column
        for column in columns
        if column not in used
        and LIKE_LABELS.search(column.strip().lower())
        and (not isinstance(columns, Mapping) or columns[column].any())
    ]
    if left:
        log.warning(
            "%s: these fields look like labels, but are not read as labels: %s; to read one, set "
            "columns to %s=label",
            name, ", ".join(left), left[0],
        )  # fmt: skip


def with_meanings(
    name: str, columns: Mapping[str, Array], options: ReadOptions
) -> Mapping[str, Array]:
    """Return the columns renamed to the meanings that the user gave, without left-out ones."""
    if not options.chosen.columns:
        return columns
    meaning = meanings(list(columns), options.chosen.columns, name)
    # A meaning that the user gave to one column replaces another column of that name.
    renamed = {new for old, new in meaning.items() if new != old}
    return {
        meaning[old]: values
        for old, values in columns.items()
        if meaning[old] != LEFT_OUT and not (meaning[old] == old and old in renamed)
    }


def role_columns(name: str, columns: Mapping[str, Array], options: ReadOptions) -> set[str]:
    """Return the names in the file of the columns with a role."""
    chosen = options.chosen.columns
    meaning = meanings(list(columns), chosen, name) if chosen else {each: each for each in columns}
    wanted = set(roles(meaning.values()).values())
    return {column for column, means in meaning.items() if means in wanted}
