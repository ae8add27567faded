"""Fields of a LAS point beside coordinates, intensity and colour, so that exports give them back.

Names are those of laspy; fields of a few bits are columns of their own.  Layout: LAS 1.4 R15.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.las_header import LasHeader

Array = NDArray[Any]
MOST_RECORDS = 64 << 20
"""Bytes of the records after the points (EVLRs) that are kept."""
_LEGACY_BYTES = {
    "scan_angle_rank": ("i1", 16), "user_data": ("u1", 17), "point_source_id": ("<u2", 18),
}  # fmt: skip
_BYTES = {
    "classification": ("u1", 16), "user_data": ("u1", 17), "scan_angle": ("<i2", 18),
    "point_source_id": ("<u2", 20), "gps_time": ("<f8", 22),
}  # fmt: skip
_LEGACY_BITS = {
    "return_number": (14, 0, 3), "number_of_returns": (14, 3, 3),
    "scan_direction_flag": (14, 6, 1), "edge_of_flight_line": (14, 7, 1),
    "classification": (15, 0, 5), "synthetic": (15, 5, 1), "key_point": (15, 6, 1),
    "withheld": (15, 7, 1),
}  # fmt: skip
_BITS = {
    "return_number": (14, 0, 4), "number_of_returns": (14, 4, 4), "synthetic": (15, 0, 1),
    "key_point": (15, 1, 1), "withheld": (15, 2, 1), "overlap": (15, 3, 1),
    "scanner_channel": (15, 4, 2), "scan_direction_flag": (15, 6, 1),
    "edge_of_flight_line": (15, 7, 1),
}  # fmt: skip
_WAVE = {
    "wavepacket_index": "u1", "wavepacket_offset": "<u8", "wavepacket_size": "<u4",
    "return_point_wave_location": "<f4", "x_t": "<f4", "y_t": "<f4", "z_t": "<f4",
}  # fmt: skip
_GPS = {1: 20, 3: 20, 4: 20, 5: 20}
_WAVE_AT = {4: 28, 5: 34, 9: 30, 10: 38}
_NIR_AT = {8: 36, 10: 36}
COLORS = ("red", "green", "blue")


def wide(color: str) -> str:
    """Name of the column that keeps a colour's 16 bits."""
    return f"{color}_16"


def further_fields(header: LasHeader, rows: Array) -> dict[str, Array]:
    """Columns (n,) of point records that a PointFrame has no place for, in the record's order."""
    raw = rows.view(np.dtype((np.void, header.record)))
    byte = np.ndarray((len(rows), header.record), np.uint8, raw, 0, (rows.strides[0], 1))
    legacy = header.point_format < 6
    columns: dict[str, Array] = {}
    for name, (at, shift, bits) in (_LEGACY_BITS if legacy else _BITS).items():
        columns[name] = byte[:, at] >> shift & ((1 << bits) - 1)
    plain = dict(_LEGACY_BYTES if legacy else _BYTES)
    if header.point_format in _GPS:
        plain["gps_time"] = ("<f8", _GPS[header.point_format])
    if header.point_format in _NIR_AT:
        plain["nir"] = ("<u2", _NIR_AT[header.point_format])
    at = _WAVE_AT.get(header.point_format, 0)
    for name, kind in _WAVE.items() if at else ():
        plain[name] = (kind, at)
        at += np.dtype(kind).itemsize
    plain |= {name: (f"<{kind}", at) for name, (at, kind) in header.further.items()}
    for name, (kind, at) in plain.items():
        size = np.dtype(kind).itemsize
        columns[name] = np.ascontiguousarray(byte[:, at : at + size]).view(kind).reshape(-1)
    if "red" in (rows.dtype.names or ()):
        for color in COLORS:
            # 8 bits times 257 are told by the eight; others are kept whole.
            if not np.array_equal(rows[color], (rows[color] >> 8) * np.uint16(257)):
                columns[wide(color)] = np.ascontiguousarray(rows[color])
    return columns


def read_records(path: Path, header: LasHeader) -> bytes:
    """The file without its points: header and VLRs, then the EVLRs, where they are not huge."""
    with path.open("rb") as file:
        start = file.read(header.offset)
        evlrs = b""
        if header.version >= (1, 4) and len(start) >= 247:
            at, count = struct.unpack_from("<QI", start, 235)
            size = path.stat().st_size
            if count and header.offset <= at < size and size - at <= MOST_RECORDS:
                file.seek(at)
                evlrs = file.read()
    return struct.pack("<Q", len(start)) + start + evlrs


def split_records(content: bytes) -> tuple[bytes, bytes]:
    """The two parts of ``read_records``."""
    (length,) = struct.unpack_from("<Q", content)
    return content[8 : 8 + length], content[8 + length :]
