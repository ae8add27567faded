"""Feather tables of points, as in Argoverse 2: x, y, z, intensity, laser_number…"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.formats.geometry.interpolation import interpolated
from pointbrush.formats.geometry.poses import Poses, of_quaternion
from pointbrush.formats.options import Limits, ReadOptions, require_count
from pointbrush.formats.tables.columns import frame_from_columns

POSES = "city_SE3_egovehicle.feather"
MOUNTS = "calibration/egovehicle_SE3_sensor.feather"
STAMP = "timestamp_ns"
PLACE = ("tx_m", "ty_m", "tz_m", "qx", "qy", "qz", "qw")


def read_feather(path: Path, options: ReadOptions) -> Any:
    """One file as one frame; coordinates of half precision become float32.

    Raises BadInputError for a file that is no table of numbers, TooLargeError.
    """
    columns = read_table(path, options.limits)
    half = {name: v.astype(np.float32) for name, v in columns.items() if v.dtype == np.float16}
    yield frame_from_columns(path.name, columns | half, options)


def read_table(path: Path, limits: Limits, words: Sequence[str] = ()) -> dict[str, NDArray[Any]]:
    """Read the columns of numbers, and the columns ``words`` of any type.

    Raises NotFoundError, BadInputError, TooLargeError.
    """
    import pyarrow as pa
    from pyarrow import feather

    if not path.is_file():
        raise NotFoundError(f"{path}: expected a file, it does not exist")
    try:
        with pa.memory_map(str(path)) as source:
            # The header states the number of rows before any is unpacked.
            reader = pa.ipc.open_file(source)
            rows = sum(reader.get_batch(i).num_rows for i in range(reader.num_record_batches))
        require_count(path.name, rows, limits)
        table = feather.read_table(path, memory_map=False)
        # Names and words are decoded here, and may be invalid text.
        return {
            name: column.to_numpy()
            for name, column in zip(table.column_names, table.columns, strict=True)
            if name in words or _is_number(column.type)
        }
    except (pa.ArrowException, OSError, ValueError) as error:
        if isinstance(error, BadInputError):
            raise
        reason = str(error).split("\n")[0][:120]
        raise BadInputError(f"{path.name}: expected a feather table, {reason}") from None


def _is_number(kind: Any) -> bool:
    import pyarrow as pa

    return bool(pa.types.is_integer(kind) or pa.types.is_floating(kind))


def argoverse_poses(log: Path, times: Sequence[float] | None, limits: Limits) -> Poses | None:
    """Poses of the vehicle at the ``times`` of frames, seconds, of an Argoverse 2 log.

    Raises BadInputError for a table without poses, or one of other times.
    """
    path = log / POSES
    if times is None or not path.is_file():
        return None
    table = read_table(path, limits)
    if not {STAMP, *PLACE} <= table.keys():
        raise BadInputError(f"{path.name}: expected columns {STAMP}, {', '.join(PLACE)}")
    places = np.stack([np.asarray(table[column], np.float64) for column in PLACE], axis=1)
    poses = [of_quaternion(f"{path.name} row {row}", place) for row, place in enumerate(places)]
    stamps = [time / 1e9 for time in table[STAMP].tolist()]
    return Poses(interpolated(path.name, stamps, poses, times), POSES)
