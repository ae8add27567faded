"""NumPy .npy and .npz: plain (N, 3..), structured, or one array per field.  No pickles."""

from __future__ import annotations

import lzma
import zipfile
import zlib
from collections.abc import Collection, Iterator, Mapping
from itertools import chain
from pathlib import Path
from typing import Any, BinaryIO, cast

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, NotFoundError, TooLargeError
from pointbrush.formats.options import Extras, ReadOptions, require_count
from pointbrush.formats.readers.unnamed import plain_columns
from pointbrush.formats.tables.column_roles import name_left_out
from pointbrush.formats.tables.columns import frame_from_columns
from pointbrush.formats.tables.table import Table
from pointbrush.frame import PointFrame

Array = NDArray[Any]

POINTS = (
    *("xyz", "points", "pc", "point_cloud", "pointcloud", "cloud", "positions", "coords"),
    *("coord", "coordinates", "coordinate", "position", "pos", "vertices"),
)
COLORS = ("rgb", "colors", "colours", "color", "rgba", "colour")
INTENSITIES = ("intensity", "intensities", "reflectance", "remission", "strength")
LABELS = (
    *("label", "labels", "semantic", "semantic_label", "segment", "semantic_gt", "sem_label"),
    *("segment20", "semantic_gt20", "segment200", "semantic_gt200"),
)
INSTANCES = ("instance", "instances", "instance_id", "instance_label", "instance_gt")
FACTS: Mapping[str, tuple[int, ...]] = {"pose": (4, 4), "viewpoint": (3,), "timestamp": ()}
"""Arrays of a frame's facts, and their shapes."""
KNOWN_ARRAYS = frozenset((*POINTS, *COLORS, *INTENSITIES, *LABELS, *INSTANCES, *FACTS, *"xyz"))
"""Arrays of an archive that have a meaning; others of a number a point are further fields."""
# A table of points is not wider: other arrays are.
MAX_WIDTH = 16
_NPY_ROWS = 1 << 20
READ_ERRORS = (
    *(ValueError, EOFError, OSError, KeyError, RuntimeError, OverflowError),
    *(zipfile.BadZipFile, zlib.error, lzma.LZMAError),
)


def read_npy(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """One .npy file: a table as ``plain_columns`` reads it, or named fields.

    Raises BadInputError for another shape, a truncated file or a pickle.
    """
    array = read_array(path, options)
    columns = _columns_of(path.name, "array", array, options)
    yield frame_from_columns(path.name, columns, options)


def read_npz(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """One .npz file: points under ``xyz`` (or ``points``, ``pc``…) with further arrays beside.

    Known beside them: rgb, intensity, label, instance (N,), ``pose`` (4, 4) T_world_frame,
    ``timestamp`` and ``viewpoint``.  ``deleted`` points are not left out: they are points.
    Raises BadInputError for missing points, other shapes, a truncated file or a pickle.
    """
    shapes = _shapes_of_zip(path, options)
    lengths = {shape[0] for key, shape in shapes.items() if key in KNOWN_ARRAYS and shape}
    arrays: dict[str, Array] = {}
    archive = _load(path)
    if isinstance(archive, np.ndarray):
        raise BadInputError(f"{path.name}: expected an archive of arrays, got a single array")
    with archive:
        for key in archive.files:
            wanted = key in KNOWN_ARRAYS or len(archive.files) == 1
            if not wanted and not _is_column(shapes.get(key, ()), lengths):
                continue
            try:
                arrays[key] = np.asarray(archive[key])
            except READ_ERRORS:
                raise BadInputError(
                    f"{path.name}: expected a whole array '{key}', it is damaged"
                ) from None
        keys = ", ".join(archive.files) or "no arrays"
    points = _first(arrays, POINTS)
    if points is None and len(archive.files) == 1 and not {"x", "y", "z"} & set(arrays):
        points = next(iter(arrays))
    if points is None and not {"x", "y", "z"} <= set(arrays):
        raise BadInputError(f"{path.name}: expected an array 'xyz' or 'points', got {keys}")
    columns = (
        {axis: arrays[axis].reshape(-1) for axis in "xyz"}
        if points is None
        else _columns_of(path.name, points, arrays[points], options)
    )
    count = len(columns["x"]) if "x" in columns else len(next(iter(columns.values())))
    require_count(path.name, count, options.limits)
    further = {
        key: array
        for key, array in arrays.items()
        if key not in KNOWN_ARRAYS and _is_column(array.shape, {count})
    }
    columns = {key: array.reshape(-1) for key, array in further.items()} | columns
    columns |= _beside(path.name, arrays, count)
    name_left_out(path.name, [key for key in archive.files if key not in (points, *columns)], {})
    yield frame_from_columns(path.name, columns, options, extras=_extras(path.name, arrays))


def _is_column(shape: tuple[int, ...], lengths: Collection[int]) -> bool:
    """Whether an array has a number for each of as many points as one of ``lengths``."""
    return len(shape) in (1, 2) and shape[0] in lengths and shape[1:] in ((), (1,))


def _load(path: Path) -> Any:
    try:
        return np.load(path, allow_pickle=False, max_header_size=1 << 20)
    except FileNotFoundError:
        raise NotFoundError(f"{path}: expected a file, it does not exist") from None
    except READ_ERRORS:
        raise BadInputError(f"{path.name}: expected a NumPy file, got another or a part") from None


def read_array(path: Path, options: ReadOptions) -> Array:
    """Read an .npy file after a check that it holds as many bytes as its header claims.

    Raises NotFoundError, BadInputError, TooLargeError.
    """
    try:
        with path.open("rb") as file:
            _require_array(path.name, file, path.stat().st_size, options)
    except FileNotFoundError:
        raise NotFoundError(f"{path}: expected a file, it does not exist") from None
    return np.asarray(_load(path))


def _require_array(name: str, file: Any, size: int, options: ReadOptions) -> tuple[int, ...]:
    """Check the header of an array; return its shape."""
    if size == 0:
        raise BadInputError(f"{name}: expected a NumPy array, got an empty file (0 bytes)")
    try:
        version = np.lib.format.read_magic(file)
        reader = (
            np.lib.format.read_array_header_1_0
            if version == (1, 0)
            else np.lib.format.read_array_header_2_0
        )
        shape, _, dtype = reader(file, max_header_size=1 << 20)
    # The header is Python text that NumPy hands to Python's parser: errors of any kind.
    except Exception:
        # … which may quote the file.
        raise BadInputError(f"{name}: expected a NumPy array, got another header") from None
    if dtype.hasobject:
        raise BadInputError(f"{name}: expected an array of numbers, got Python objects (a pickle)")
    count = 1
    for length in shape:
        count *= int(length)
    if any(length < 0 for length in shape):
        raise BadInputError(f"{name}: expected a shape of 0 or more, got {shape}")
    left = size - file.tell()
    if count * dtype.itemsize > left:
        raise BadInputError(
            f"{name}: expected {count * dtype.itemsize} bytes of data for shape {shape} {dtype}, "
            f"got {left}; the file is cut off"
        )
    if shape:
        require_count(name, int(shape[0]), options.limits)
    return tuple(map(int, shape))


def _shapes_of_zip(path: Path, options: ReadOptions) -> dict[str, tuple[int, ...]]:
    """Check the entries of an archive; return the shapes of its arrays by name."""
    shapes: dict[str, tuple[int, ...]] = {}
    try:
        size = path.stat().st_size
        if size == 0:
            raise BadInputError(f"{path.name}: expected NumPy arrays, got an empty file (0 bytes)")
        with zipfile.ZipFile(path) as archive:
            for entry in archive.infolist():
                ratio = options.limits.max_archive_ratio * 10
                if entry.file_size > max(entry.compress_size, 64) * ratio:
                    raise TooLargeError(
                        f"{path.name}: expected '{entry.filename}' to unpack to less than {ratio} "
                        f"times its {entry.compress_size} bytes, got {entry.file_size}"
                    )
                if entry.filename.endswith(".npy"):
                    with archive.open(entry) as file:
                        where = f"{path.name}: '{entry.filename}'"
                        shape = _require_array(where, file, entry.file_size, options)
                    shapes[entry.filename.removesuffix(".npy")] = shape
        return shapes
    except FileNotFoundError:
        raise NotFoundError(f"{path}: expected a file, it does not exist") from None
    except BadInputError:
        raise
    except READ_ERRORS:
        raise BadInputError(
            f"{path.name}: expected a NumPy archive (.npz), got another file or a damaged one"
        ) from None


def _first(arrays: Mapping[str, Array], keys: tuple[str, ...]) -> str | None:
    return next((key for key in keys if key in arrays), None)


def _columns_of(name: str, key: str, array: Array, options: ReadOptions) -> dict[str, Array]:
    if array.dtype.names:
        flat = array.reshape(-1)
        columns: dict[str, Array] = {}
        for field in array.dtype.names:
            if flat[field].ndim == 1:
                columns[field] = flat[field]
            elif flat[field].ndim == 2 and field in POINTS and flat[field].shape[1] == 3:
                columns |= {axis: flat[field][:, i] for i, axis in enumerate("xyz")}
            elif flat[field].ndim == 2 and field in COLORS:
                columns["rgb"] = flat[field]
        return columns
    if array.ndim == 3 and array.shape[2] <= MAX_WIDTH:
        array = array.reshape(-1, array.shape[2])
    wide = array.shape[1] if array.ndim == 2 else 0
    if not 3 <= wide <= MAX_WIDTH or array.dtype.kind not in "fiu":
        raise BadInputError(
            f"{name}: expected '{key}' as (N, 3) to (N, {MAX_WIDTH}) numbers, got {array.shape} "
            f"{array.dtype}"
        )
    if array.dtype == np.float16:
        array = array.astype(np.float32)
    return plain_columns(name, array, options, intensity_first=True)


def _beside(name: str, arrays: Mapping[str, Array], count: int) -> dict[str, Array]:
    columns: dict[str, Array] = {}
    for role, keys in (("intensity", INTENSITIES), ("label", LABELS), ("instance", INSTANCES)):
        key = _first(arrays, keys)
        if key is not None:
            if arrays[key].size != count:
                raise BadInputError(
                    f"{name}: expected '{key}' with {count} values, got {arrays[key].shape}"
                )
            columns[role] = arrays[key].reshape(-1)
    key = _first(arrays, COLORS)
    if key is not None:
        color = arrays[key].reshape(-1, arrays[key].shape[-1]) if arrays[key].ndim > 1 else None
        if color is None or len(color) != count or color.shape[1] not in (3, 4):
            raise BadInputError(
                f"{name}: expected '{key}' as ({count}, 3) colours, got {arrays[key].shape}"
            )
        columns["rgb"] = color
    return columns


def _extras(name: str, arrays: Mapping[str, Array]) -> Extras:
    found: dict[str, Array] = {}
    for key, shape in FACTS.items():
        if key in arrays:
            value = arrays[key]
            numeric = value.dtype.kind in "fiu"
            if not numeric or value.size != int(np.prod(shape)) or not np.isfinite(value).all():
                raise BadInputError(
                    f"{name}: expected '{key}' as {shape} finite numbers, got {value.shape} "
                    f"{value.dtype}"
                )
            found[key] = value.astype(np.float64).reshape(shape)
    return Extras(
        pose=found.get("pose"),
        viewpoint=found.get("viewpoint"),
        timestamp=float(found["timestamp"]) if "timestamp" in found else None,
    )


def write_npz(out: BinaryIO, arrays: Mapping[str, Table | Array]) -> None:
    """Write arrays, and tables of one column, as a compressed .npz."""
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, values in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                if isinstance(values, Table):
                    write_column(cast(BinaryIO, member), values)
                else:
                    np.lib.format.write_array(member, values, allow_pickle=False)


def write_column(out: BinaryIO, table: Table) -> None:
    """Write a table of one column, whose rows may be arrays, as .npy."""
    blocks: Iterator[Array] = (
        np.ascontiguousarray(*columns.values()) for columns in table.blocks()
    )
    first = next(blocks)
    descr = np.lib.format.dtype_to_descr(first.dtype)
    shape = (table.count, *first.shape[1:])
    header = {"descr": descr, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(out, header)
    blocks = chain([first], blocks)
    del first  # may be large
    for block in blocks:
        for start in range(0, len(block), _NPY_ROWS):
            out.write(block[start : start + _NPY_ROWS].tobytes())
