"""Conversion of a file's named columns to a PointFrame."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.options import ColorRange, Extras, ReadOptions
from pointbrush.formats.tables.column_roles import name_left_out, roles, with_meanings
from pointbrush.formats.tables.label_values import instances_of, number_of
from pointbrush.frame import PointFrame

Array = NDArray[Any]
log = logging.getLogger(__name__)

LABELS = ("label", "instance")
"""Roles and names of columns for labels in exports."""
CARLA = {"CosAngle", "ObjIdx", "ObjTag"}
"""Fields of CARLA's semantic lidar."""


def frame_from_columns(
    name: str,
    columns: Mapping[str, Array],
    options: ReadOptions,
    *,
    missing: bool = False,
    zeros: bool = False,
    extras: Extras | None = None,
) -> PointFrame:
    """Build a frame from columns of equal length, by their names.

    Coordinates are x, y and z, or ``xyz`` as an array (N, 3).
    ``missing``: NaN and infinite points are absent measurements of this format, and are left out
    and counted.  Otherwise they raise, unless ``options.drop_invalid``.  Several points at 0 0 0
    are absent measurements, too, unless the format uses them as positions: ``zeros``.

    Raises BadInputError when x, y or z is absent, points are not finite, or colours or labels
    are out of range; messages start with ``name``.
    """
    columns = with_meanings(name, columns, options)
    found = roles(columns)
    xyz = _coordinates(name, columns, found)
    keep = finite_points(name, xyz, missing=missing or options.drop_invalid)
    keep = keep if zeros else without_zeros(xyz, keep)
    rgb = _rgb(name, columns, found, keep, options.colors)
    name_left_out(name, columns, found)
    parts = {role: columns[found[role]] for role in found if role not in "xyz"}
    instance = None
    if "instance" in parts:
        instance = instances_of(name, _take(parts["instance"], keep))
    intensity = None
    if "intensity" in parts:
        intensity = intensity_of(_take(parts["intensity"], keep))
    extras, known = extras or Extras(), options.known
    other = _other(columns, found, keep, intensity, rgb)
    if options.columns_found is not None:
        options.columns_found(_described(columns, found, other, rgb is not None))
    return PointFrame(
        xyz=_take(xyz, keep),
        rgb=rgb,
        intensity=intensity,
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


def _coordinates(name: str, columns: Mapping[str, Array], found: Mapping[str, str]) -> Array:
    """Return coordinates (N, 3); raise BadInputError if there are none."""
    whole = columns.get("xyz")
    if set(columns) >= CARLA:
        log.warning(
            "%s: CARLA's axes are left-handed: the recording is mirrored, y is to the right; "
            "negate y in its points, poses and boxes first", name,
        )  # fmt: skip
    if whole is not None and whole.ndim == 2:
        return whole
    if all(axis in found for axis in "xyz"):
        return _stack(name, [columns[found[axis]] for axis in "xyz"])
    raise BadInputError(
        f"{name}: expected the fields x, y and z, got {', '.join(columns) or 'no fields'}"
    )


def _described(
    columns: Mapping[str, Array],
    found: Mapping[str, str],
    other: Mapping[str, Array],
    has_colors: bool,
) -> dict[str, str]:
    """Return the role of each column, "kept", or "" for a column that is left out."""
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
    intensity: NDArray[np.float32] | None,
    rgb: NDArray[np.uint8] | None,
) -> dict[str, Array]:
    """Return the numeric columns that have no field in a PointFrame.

    Labels and instances become labels of a workspace.  Their columns are kept as fields as well,
    unless they have the names that exports use for labels.
    """
    held = {found[axis] for axis in "xyz" if axis in found} | {"xyz"}
    exact: dict[str, Array] = {}
    if intensity is not None:
        exact[found["intensity"]] = intensity
    colors = ("red", "green", "blue")
    if rgb is not None and all(color in found for color in colors):
        exact |= {found[color]: rgb[:, i] for i, color in enumerate(colors)}
    elif rgb is not None:
        held.add(found["rgb"])
    if "label" in found:
        held |= {role for role in LABELS if found.get(role) == role}
    other = {}
    for name, values in columns.items():
        if name in held or values.ndim != 1 or values.dtype.kind not in "fiu":
            continue
        values = _take(values, keep)
        if name not in exact or not _is_same(values, exact[name]):
            # Few formats have floats of 16 bits.
            kind = np.float32 if values.dtype == np.float16 else values.dtype.newbyteorder("=")
            other[name] = np.ascontiguousarray(values, kind)
    return other


def _is_same(values: Array, held: Array) -> bool:
    """Return whether a column's values follow from the frame's intensities or colours."""
    if np.array_equal(values, held):
        return True
    if values.dtype.kind == "f":
        # The PointFrame holds float64 values with the digits of float32.
        given = held / 255 if held.dtype == np.uint8 else held
        return bool(np.allclose(values, given, rtol=1e-6, atol=0))
    return values.dtype == np.uint16 and np.array_equal(values, held.astype(np.uint16) * 257)


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
    """Return indices of the points without 0 0 0 if it occurs twice or more: beams without echo."""
    zero = xyz[:, 0] == 0
    zero &= xyz[:, 1] == 0
    zero &= xyz[:, 2] == 0
    if np.count_nonzero(zero) < 2:
        return keep
    return np.flatnonzero(~zero) if keep is None else keep[~zero[keep]]


def colors_of(name: str, values: Array, colors: ColorRange | None = None) -> NDArray[np.uint8]:
    """(N, 3) colours of any number type as uint8.

    uint8 stays.  16-bit colours are scaled unless none exceeds 255 (many writers leave 8-bit
    values in 16-bit fields).  Floats are 0..1 when none exceeds 1, else 0..255.  ``colors``: the
    range for the whole recording.
    Raises BadInputError for negative, NaN or larger values, UndecidedColorsError if ``colors`` has
    no range for the type.
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
