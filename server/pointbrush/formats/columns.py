"""Named columns as files have them, turned into a PointFrame.

Names of PLY properties, PCD and LAS fields, CSV headers and structured NumPy arrays differ by
program; one table here says which are understood.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.corrections import LEFT_OUT, meanings
from pointbrush.formats.options import ColorRange, Extras, ReadOptions
from pointbrush.frame import PointFrame

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
        *("treeid", "tree_id"),
    ),
}
LIKE_LABELS = re.compile(
    r"label|class|segm|semantic|instance|category|annot|obj(ect)?_?(id|tag|idx)|^tag$", re.ASCII
)
"""Names of fields that look like labels."""
NO_LABEL = (-1, -100, 65535, 4294967295)
"""Numbers that mark "none" in labels and instances."""
CARLA = {"CosAngle", "ObjIdx", "ObjTag"}
"""Fields of CARLA's semantic lidar."""
GREATEST_INSTANCE = 65535
TOLD = 8
"""Numbers that a warning lists."""


def roles(names: Iterable[str]) -> dict[str, str]:
    """Role → the name in the file that plays it; the earliest synonym in ROLES wins."""
    by_lower: dict[str, str] = {}
    for name in names:
        by_lower.setdefault(name.strip().strip("\"'").lower(), name)
    found: dict[str, str] = {}
    for role, synonyms in ROLES.items():
        for synonym in synonyms:
            if synonym in by_lower:
                found[role] = by_lower[synonym]
                break
    return found


def name_left_out(name: str, columns: Iterable[str], found: Mapping[str, str]) -> None:
    """Say which fields look like labels and are not read as such."""
    if "label" in found:
        return
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
            "%s: the fields %s are left out; columns %s=label reads one as labels",
            name, ", ".join(left), left[0],
        )  # fmt: skip


def frame_from_columns(
    name: str,
    columns: Mapping[str, Array],
    options: ReadOptions,
    *,
    missing: bool = False,
    extras: Extras | None = None,
) -> PointFrame:
    """Build a frame from columns of equal length, by their names.

    Coordinates are x, y and z, or ``xyz`` as an array (N, 3).
    ``missing``: NaN and infinite points are absent measurements of this format, and are left out
    and counted.  Otherwise they raise, unless ``options.drop_invalid``.

    Raises BadInputError when x, y or z is absent, points are not finite, or colours or labels
    are out of range; messages start with ``name``.
    """
    columns = with_meanings(name, columns, options)
    found = roles(columns)
    whole = columns.get("xyz")
    if whole is not None and whole.ndim == 2:
        xyz = whole
    elif all(axis in found for axis in "xyz"):
        xyz = _stack(name, [columns[found[axis]] for axis in "xyz"])
    else:
        raise BadInputError(
            f"{name}: expected the fields x, y and z, got {', '.join(columns) or 'no fields'}"
        )
    if set(columns) >= CARLA:
        log.warning(
            "%s: CARLA's axes are left-handed: the recording is mirrored, y is to the right; turn "
            "the sign of y in its points, poses and boxes before", name,
        )  # fmt: skip
    keep = finite_points(name, xyz, missing=missing or options.drop_invalid)
    if missing:
        keep = without_zeros(xyz, keep)
    rgb = _rgb(name, columns, found, keep, options.colors)
    name_left_out(name, columns, found)
    parts = {role: columns[found[role]] for role in found if role not in "xyz"}
    instance, whole_instance = None, False
    if "instance" in parts:
        instance, whole_instance = _instances(name, _take(parts["instance"], keep))
        if "label" not in parts and instance is not None:
            log.warning(
                "%s: the instances of %s have no classes and make no labels; columns %s=label "
                "makes each one a label", name, found["instance"], found["instance"],
            )  # fmt: skip
    extras, known = extras or Extras(), options.known
    other = _other(columns, found, keep, whole_instance)
    if options.columns_found is not None:
        options.columns_found(_described(columns, found, other, rgb is not None))
    return PointFrame(
        xyz=_take(xyz, keep),
        rgb=rgb,
        intensity=intensity_of(_take(parts["intensity"], keep)) if "intensity" in parts else None,
        label=number_of(name, "label", _take(parts["label"], keep), 65534)
        if "label" in parts
        else None,
        instance=instance,
        dropped=0 if keep is None else len(xyz) - len(keep),
        pose=known.pose if extras.pose is None else extras.pose,
        viewpoint=extras.viewpoint,
        timestamp=known.timestamp if extras.timestamp is None else extras.timestamp,
        camera=extras.camera,
        pixel=None if extras.pixel is None else _take(extras.pixel, keep),
        other=other,
        rows=keep,
    )


def with_meanings(
    name: str, columns: Mapping[str, Array], options: ReadOptions
) -> Mapping[str, Array]:
    """Columns by what a person says they are; those that are to be left out are not among them."""
    if not options.chosen.columns:
        return columns
    meaning = meanings(list(columns), options.chosen.columns, name)
    # What a column is said to be, no other one is.
    said = {new for old, new in meaning.items() if new != old}
    return {
        meaning[old]: values
        for old, values in columns.items()
        if meaning[old] != LEFT_OUT and not (meaning[old] == old and old in said)
    }


def label_columns(name: str, columns: Mapping[str, Array], options: ReadOptions) -> set[str]:
    """Names in the file of the columns that are read as labels and instances."""
    chosen = options.chosen.columns
    meaning = meanings(list(columns), chosen, name) if chosen else {each: each for each in columns}
    found = roles(meaning.values())
    wanted = {found.get("label"), found.get("instance")}
    return {column for column, means in meaning.items() if means in wanted}


def _described(
    columns: Mapping[str, Array],
    found: Mapping[str, str],
    other: Mapping[str, Array],
    has_colors: bool,
) -> dict[str, str]:
    """Return the role of each column, "kept", or "" where it is left out."""
    by_column = {column: role for role, column in found.items()}
    if not has_colors:
        by_column = {c: r for c, r in by_column.items() if r not in ("red", "green", "blue", "rgb")}
    return {
        column: by_column.get(column, "xyz" if column == "xyz" else "kept" * (column in other))
        for column in columns
    }


def _other(
    columns: Mapping[str, Array],
    found: Mapping[str, str],
    keep: NDArray[np.int64] | None,
    whole_instance: bool,
) -> dict[str, Array]:
    """Fields of numbers that a PointFrame has no place for, in the source's order."""
    used = {name for role, name in found.items() if role != "instance" or whole_instance} | {"xyz"}
    if all(role in found for role in ("red", "green", "blue")):
        used -= {found["rgb"]} if "rgb" in found else set()
    return {
        name: np.ascontiguousarray(_take(values, keep))
        for name, values in columns.items()
        if name not in used and values.ndim == 1 and values.dtype.kind in "fiu"
    }


def finite_points(name: str, xyz: Array, *, missing: bool) -> NDArray[np.int64] | None:
    """Indices of the finite points, None when all are; raises BadInputError unless ``missing``."""
    # One reduction per axis; isfinite over (N, 3) would make a second array of that size.
    finite = np.isfinite(xyz[:, 0])
    finite &= np.isfinite(xyz[:, 1])
    finite &= np.isfinite(xyz[:, 2])
    if finite.all():
        return None
    bad = np.flatnonzero(~finite)
    if not missing:
        raise BadInputError(
            f"{name}: expected finite coordinates, got {bad.size} of {len(xyz)} points with NaN "
            f"or infinity (first at point {bad[0]}); --drop-invalid leaves them out"
        )
    return np.flatnonzero(finite)


def without_zeros(xyz: Array, keep: NDArray[np.int64] | None) -> NDArray[np.int64] | None:
    """Indices of the points that are not 0 0 0: several of those are beams without an echo."""
    zero = xyz[:, 0] == 0
    zero &= xyz[:, 1] == 0
    zero &= xyz[:, 2] == 0
    if np.count_nonzero(zero) < 2:
        return keep
    return np.flatnonzero(~zero) if keep is None else keep[~zero[keep]]


def colors_of(name: str, values: Array, colors: ColorRange | None = None) -> NDArray[np.uint8]:
    """(N, 3) colours of any number type as uint8.

    uint8 stays.  16-bit colours are scaled unless none exceeds 255 (many writers leave 8-bit
    values in 16-bit fields).  Floats are 0..1 when none exceeds 1, else 0..255.  ``colors`` is
    what holds for the whole recording.
    Raises BadInputError for negative, NaN or larger values, UndecidedColorsError where ``colors``
    does not tell.
    """
    if values.dtype == np.uint8:
        return np.asarray(values, np.uint8)
    if values.dtype == np.int8:
        return values.astype(np.uint8)
    if len(values) == 0:
        return np.zeros((0, 3), np.uint8)
    low, high = values.min(), values.max()
    if values.dtype.kind in "ui":
        greatest = 255 if colors is None else colors.whole_for(int(high))
        if low >= 0 and high <= 255 and greatest == 255:
            return values.astype(np.uint8)
        if low >= 0 and high <= 65535:
            return ((values.astype(np.uint32) * 255 + 32767) // 65535).astype(np.uint8)
        raise BadInputError(f"{name}: expected colours 0 to 65535, got {low} to {high}")
    one = 1 if colors is None or not low >= 0 else colors.real_for(float(high))
    if low >= 0 and high <= 1 and one == 1:
        return np.asarray(np.rint(values * 255), np.uint8)
    if low >= 0 and high <= 255:
        return np.asarray(np.rint(values), np.uint8)
    if low >= 0 and high <= 65535 and not np.any(values % 1):
        return colors_of(name, values.astype(np.uint32), colors)
    raise BadInputError(f"{name}: expected colours 0 to 1 or 0 to 255, got {low:g} to {high:g}")


def unpack_rgb(values: Array) -> NDArray[np.uint8]:
    """(N, 3) uint8 from colours packed as 0xAARRGGBB in a 4-byte integer, or in a float's bits."""
    if values.dtype.kind == "f":
        packed = np.ascontiguousarray(values, dtype=np.float32).view(np.uint32)
    else:
        packed = (values.astype(np.int64) & 0xFFFFFFFF).astype(np.uint32)
    return np.stack([packed >> 16 & 255, packed >> 8 & 255, packed & 255], axis=1).astype(np.uint8)


def number_of(name: str, what: str, values: Array, greatest: int) -> NDArray[np.uint16]:
    """Labels or instances as uint16; NaN and ``NO_LABEL`` mark "none" and become 0.

    Raises BadInputError for fractions and for numbers outside 0..greatest.
    """
    if values.dtype.kind == "f":
        # Of half precision, whose numbers end before 65535.
        values = values.astype(np.promote_types(values.dtype, np.float32), copy=False)
        values = np.where(np.isnan(values), 0, values)
        fractions = np.flatnonzero((values != np.rint(values)) | np.isinf(values))
        if fractions.size:
            at = int(fractions[0])
            raise BadInputError(f"{name}: expected whole {what}s, got {values[at]} at point {at}")
    elif values.dtype.kind not in "uib":
        raise BadInputError(f"{name}: expected {what}s as numbers, got {values.dtype}")
    values = without_marks(values)
    if len(values) and (values.min() < 0 or values.max() > greatest):
        raise BadInputError(
            f"{name}: expected {what}s 0 to {greatest}, got {values.min():g} to {values.max():g}"
        )
    return values.astype(np.uint16)


def without_marks(values: Array) -> Array:
    """Labels or instances with 0 for the numbers that mark "none"."""
    marks = [mark for mark in NO_LABEL if mark >= 0 or values.dtype.kind in "fi"]
    marked = np.isin(values, marks)
    return np.where(marked, 0, values) if marked.any() else values


def _instances(name: str, values: Array) -> tuple[NDArray[np.uint16] | None, bool]:
    """Instance numbers as uint16, None where no point has one, and whether all are kept.

    Numbers that 16 bits do not hold (a no-data value, the id of a database) become 0, with a
    warning that lists them.
    """
    if values.dtype.kind in "fiu":
        values = without_marks(np.where(np.isnan(values), 0, values))
        outside = (values < 0) | (values > GREATEST_INSTANCE)
        if outside.any():
            numbers = np.unique(values[outside])
            listed = ", ".join(f"{number:.10g}" for number in numbers[:TOLD])
            log.warning(
                "%s: expected instance numbers 0 to %d; %d points of %d other numbers (%s%s) have "
                "no instance", name, GREATEST_INSTANCE, np.count_nonzero(outside), len(numbers),
                listed, ", …" * (len(numbers) > TOLD),
            )  # fmt: skip
            values = np.where(outside, 0, values)
            if not values.any():
                return None, False
            return number_of(name, "instance", values, GREATEST_INSTANCE), False
    return number_of(name, "instance", values, GREATEST_INSTANCE), True


def intensity_of(values: Array) -> NDArray[np.float32]:
    """Intensity as float32; a value that is not finite becomes 0."""
    with np.errstate(over="ignore"):
        intensity = values.astype(np.float32)
    intensity[~np.isfinite(intensity)] = 0
    return intensity


def _take(values: Array, keep: NDArray[np.int64] | None) -> Array:
    return values if keep is None else values[keep]


def _stack(name: str, axes: list[Array]) -> Array:
    lengths = {len(axis) for axis in axes}
    if len(lengths) != 1:
        raise BadInputError(f"{name}: expected x, y and z of one length, got {sorted(lengths)}")
    # float32 holds float32 and integers of 16 bits exactly; everything else needs float64.
    small = all(axis.dtype.kind in "fiu" and np.can_cast(axis.dtype, np.float32) for axis in axes)
    xyz = np.empty((len(axes[0]), 3), np.float32 if small else np.float64)
    for column, axis in enumerate(axes):
        if axis.dtype.kind not in "fiub":
            raise BadInputError(f"{name}: expected numbers as coordinates, got {axis.dtype}")
        xyz[:, column] = axis
    return xyz


def _rgb(
    name: str,
    columns: Mapping[str, Array],
    found: dict[str, str],
    keep: NDArray[np.int64] | None,
    colors: ColorRange | None,
) -> NDArray[np.uint8] | None:
    if all(role in found for role in ("red", "green", "blue")):
        parts = [_take(columns[found[role]], keep) for role in ("red", "green", "blue")]
        if len({part.dtype for part in parts} - {np.dtype(np.int8), np.dtype(np.uint8)}) == 0:
            parts = [np.ascontiguousarray(part).view(np.uint8) for part in parts]
        return colors_of(name, np.stack(parts, axis=1), colors)
    if "rgb" in found:
        values = _take(columns[found["rgb"]], keep)
        if values.ndim == 1:
            return unpack_rgb(values)
        return colors_of(name, values[:, :3], colors)
    return None
