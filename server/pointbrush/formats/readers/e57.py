"""E57 (ASTM E2807-11): all scans of a file as one frame, each moved by its pose.

The container has checksummed pages, XML, and compressed vectors.  Offsets in the file are
physical (pages of 1024 bytes, the last 4 a CRC-32C); everything else is logical, with the
checksums taken out.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.geometry.poses import of_quaternion
from pointbrush.formats.options import Extras, ReadOptions, read_bytes, require_count
from pointbrush.formats.tables.columns import colors_of, frame_from_columns
from pointbrush.formats.tables.parsing import parse_xml
from pointbrush.frame import PointFrame

PAGE = 1024
PAYLOAD = 1020
"""Bytes of a page, and of its data before the checksum."""
HEADER = struct.Struct("<8sIIQQQQ")
# Bits are unpacked to bytes: this many values at a time bound the memory.
BLOCK = 1 << 18
DATA_PACKET = 1
Array = NDArray[Any]
Columns = dict[str, Array]
COLORS = ("red", "green", "blue")
# Colour of a scan without colours among scans with colours.
GREY = 128


@dataclass(frozen=True, slots=True)
class E57File:
    """``logical`` bytes of a file, and its XML."""

    name: str
    logical: memoryview
    root: ElementTree.Element

    def at(self, physical: int) -> int:
        """The logical offset of a physical one."""
        return physical // PAGE * PAYLOAD + min(physical % PAGE, PAYLOAD)


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a prototype: packing and meaning of its numbers."""

    name: str
    kind: str
    low: float
    high: float
    scale: float = 1.0
    offset: float = 0.0

    @property
    def bits(self) -> int:
        """Bits of a value in its stream; 0 for a constant or a text."""
        if self.kind in ("f4", "f8"):
            return int(self.kind[1]) * 8
        return (int(self.high) - int(self.low)).bit_length() if self.kind == "int" else 0


def open_e57(name: str, data: bytes) -> E57File:
    """Check every page and parse the XML; raises BadInputError for a damaged or cut off file."""
    if len(data) < HEADER.size or not data.startswith(b"ASTM-E57"):
        raise BadInputError(f"{name}: expected an E57 file starting with 'ASTM-E57'")
    _, _, _, length, xml_offset, xml_length, page = HEADER.unpack_from(data)
    if page != PAGE:
        raise BadInputError(f"{name}: expected pages of {PAGE} bytes, got {page}")
    if len(data) < length or len(data) % PAGE:
        raise BadInputError(
            f"{name}: expected {length} bytes in whole pages of {PAGE}, got {len(data)}; the file "
            "is cut off"
        )
    pages = np.frombuffer(data, np.uint8).reshape(-1, PAGE)
    wrong = np.flatnonzero(
        crc32c(pages[:, :PAYLOAD]) != pages[:, PAYLOAD:].copy().view(">u4")[:, 0]
    )
    if wrong.size:
        raise BadInputError(
            f"{name}: expected the checksum of each page to fit, {wrong.size} of {len(pages)} "
            f"pages are damaged (first at byte {int(wrong[0]) * PAGE})"
        )
    logical = memoryview(pages[:, :PAYLOAD].tobytes())
    start = xml_offset // PAGE * PAYLOAD + xml_offset % PAGE
    xml = bytes(logical[start : start + xml_length])
    if len(xml) != xml_length:
        raise BadInputError(f"{name}: expected {xml_length} bytes of XML, got {len(xml)}")
    return E57File(name, logical, _parse_xml(name, xml))


def _parse_xml(name: str, xml: bytes) -> ElementTree.Element:
    try:
        root = parse_xml(xml)
    except ValueError as error:
        raise BadInputError(f"{name}: expected XML, {error}") from None
    for element in root.iter():
        # Names of E57 itself; names of extensions keep their namespace and are ignored.
        element.tag = str(element.tag).removeprefix(
            "{http://www.astm.org/COMMIT/E57/2010-e57-v1.0}"
        )
    return root


@cache
def _crc_table() -> NDArray[np.uint32]:
    table = np.arange(256, dtype=np.uint32)
    for _ in range(8):
        table = np.where(table & 1, table >> 1 ^ np.uint32(0x82F63B78), table >> 1)
    return table


def crc32c(rows: NDArray[np.uint8]) -> NDArray[np.uint32]:
    """CRC-32C (Castagnoli) of each row."""
    table = _crc_table()
    crc = np.full(len(rows), 0xFFFFFFFF, np.uint32)
    for column in np.ascontiguousarray(rows.T):
        crc = table[(crc ^ column) & 255] ^ crc >> 8
    return ~crc


def number(name: str, element: ElementTree.Element | None, default: float) -> float:
    """The number an element holds; ``default`` for an absent or empty one."""
    return _value(name, None if element is None else element.text, default)


def _value(name: str, text: str | None, default: float) -> float:
    if text is None or not text.strip():
        return default
    try:
        return int(text) if text.strip().lstrip("+-").isdigit() else float(text)
    except ValueError:
        raise BadInputError(f"{name}: expected a number, got other text") from None


def prototype(name: str, points: ElementTree.Element) -> list[Field]:
    """The fields of a compressed vector, in the order of their streams."""
    fields = []
    for element in points.findall("prototype/*"):
        get, kind = element.get, element.get("type", "")
        if kind == "Float":
            packed = "f4" if get("precision") == "single" else "f8"
            low, high = _value(name, get("minimum"), -np.inf), _value(name, get("maximum"), np.inf)
            fields.append(Field(element.tag, packed, low, high))
        elif kind in ("Integer", "ScaledInteger"):
            low = _value(name, get("minimum"), -(2**63))
            high = _value(name, get("maximum"), 2**63 - 1)
            scale, offset = _value(name, get("scale"), 1.0), _value(name, get("offset"), 0.0)
            if not -(2**63) <= low <= high < 2**64 or int(high) - int(low) >= 2**64:
                raise BadInputError(
                    f"{name}: expected a range for '{element.tag}', got {low} to {high}"
                )
            scaled = (scale, offset) if kind == "ScaledInteger" else (1.0, 0.0)
            fields.append(Field(element.tag, "int", low, high, *scaled))
        else:
            fields.append(Field(element.tag, "text", 0, 0))
    return fields


def streams(file: E57File, points: ElementTree.Element, count: int) -> list[bytearray]:
    """The byte stream of each field, gathered from the packets of a compressed vector."""
    data = file.logical
    try:
        start = file.at(int(_value(file.name, points.get("fileOffset"), -1)))
        section, _, data_offset, _ = struct.unpack_from("<B7xQQQ", data, start)
        at = file.at(data_offset)
        if section != 1:
            raise BadInputError(f"{file.name}: expected a compressed vector, got section {section}")
        fields = prototype(file.name, points)
        gathered = [bytearray() for _ in fields]
        needed = [(count * field.bits + 7) // 8 for field in fields]
        while any(len(have) < need for have, need in zip(gathered, needed, strict=True)):
            kind, length, number_of_streams = struct.unpack_from("<BxHH", data, at)
            if kind == DATA_PACKET:
                _take_packet(file.name, data[at : at + length + 1], gathered, number_of_streams)
            at += length + 1
    except (struct.error, ValueError, OverflowError) as error:
        if isinstance(error, BadInputError):
            raise
        raise BadInputError(
            f"{file.name}: expected packets for {count} points, the data end early"
        ) from None
    return gathered


def _take_packet(name: str, packet: memoryview, gathered: list[bytearray], count: int) -> None:
    if count != len(gathered):
        raise BadInputError(f"{name}: expected {len(gathered)} streams in a packet, got {count}")
    lengths = struct.unpack_from(f"<{count}H", packet, 6)
    at = 6 + 2 * count
    if at + sum(lengths) > len(packet):
        raise BadInputError(f"{name}: expected streams within their packet, they are longer")
    for stream, length in zip(gathered, lengths, strict=True):
        stream += packet[at : at + length]
        at += length


def decode(name: str, field: Field, stream: bytearray, count: int) -> NDArray[Any]:
    """``count`` values of a field: floats as packed, integers scaled to float64."""
    if len(stream) * 8 < count * field.bits:
        raise BadInputError(
            f"{name}: expected {count} values of '{field.name}', the data end early"
        )
    if field.kind in ("f4", "f8"):
        return np.frombuffer(stream, f"<{field.kind}", count)
    if field.bits == 0:
        raw = np.zeros(count)
    elif field.bits in (8, 16, 32):
        raw = np.frombuffer(stream, f"<u{field.bits // 8}", count).astype(np.float64)
    else:
        raw = _unpack(np.frombuffer(stream, np.uint8), field.bits, count)
    return (raw + float(field.low)) * field.scale + field.offset


def _unpack(packed: NDArray[np.uint8], bits: int, count: int) -> NDArray[np.float64]:
    """Integers of any width, least significant bit first, one after the other."""
    values = np.empty(count)
    weights = np.uint64(1) << np.arange(bits, dtype=np.uint64)
    # A block is a multiple of 8 values, so that it starts at a byte.
    for first in range(0, count, BLOCK):
        number_of_values = min(BLOCK, count - first)
        start = first * bits // 8
        part = packed[start : start + (number_of_values * bits + 7) // 8]
        loose = np.unpackbits(part, count=number_of_values * bits, bitorder="little")
        values[first : first + number_of_values] = (
            loose.reshape(-1, bits).astype(np.uint64) @ weights
        )
    return values


def read_e57(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """One file as one frame: its scans one after the other, in the file's coordinates.

    Points that the scanner marked invalid are missing measurements: left out and counted.
    Raises BadInputError for damaged pages, XML or packets, TooLargeError beyond the limits.
    """
    file = open_e57(path.name, read_bytes(path))
    scans = file.root.findall("data3D/vectorChild")
    counts = [_count(file, scan) for scan in scans]
    require_count(path.name, sum(counts), options.limits)
    parts = [_columns(file, scan, count) for scan, count in zip(scans, counts, strict=True)]
    columns = _joined(parts)
    position = _pose(file, scans[0])[:3, 3] if len(scans) == 1 else None
    extras = Extras(viewpoint=position if position is not None and position.any() else None)
    yield frame_from_columns(path.name, columns, options, missing=True, extras=extras)


def _count(file: E57File, scan: Element) -> int:
    points = scan.find("points")
    text = "" if points is None else points.get("recordCount", "")
    if not (text.isascii() and text.isdigit()) or int(text[:18]) > 8 * len(file.logical):
        raise BadInputError(f"{file.name}: expected a recordCount that fits the file, got another")
    return int(text)


def _columns(file: E57File, scan: Element, count: int) -> Columns:
    points = scan.find("points")
    assert points is not None  # noqa: S101
    fields = prototype(file.name, points)
    packed = streams(file, points, count) if count else [bytearray() for _ in fields]
    values = {
        field.name: decode(file.name, field, stream, count)
        for field, stream in zip(fields, packed, strict=True)
        if field.kind != "text"
    }
    columns = dict(zip("xyz", _placed(file, scan, values), strict=True))
    limits = {field.name: (field.low, field.high) for field in fields}
    if {"colorRed", "colorGreen", "colorBlue"} <= set(values):
        columns |= _colors(file, scan, values, limits)
    if "intensity" in values:
        columns["intensity"] = values["intensity"].astype(np.float32)
    return columns | {
        field.name: values[field.name]
        for field in fields
        if field.name in values and not _is_held(field) and field.low != field.high
    }


def _is_held(field: Field) -> bool:
    """Return whether a PointFrame has the field: positions, intensity, 8-bit colours."""
    if field.name.startswith("color"):
        return (field.low, field.high) == (0, 255) or "Invalid" in field.name
    return field.name == "intensity" or field.name.startswith(("cartesian", "spherical"))


def _placed(file: E57File, scan: Element, values: Columns) -> Array:
    """(3, N) coordinates in the file's frame; NaN where invalid."""
    if {"cartesianX", "cartesianY", "cartesianZ"} <= set(values):
        xyz = np.stack([values[f"cartesian{axis}"] for axis in "XYZ"])
        state = values.get("cartesianInvalidState")
    elif {"sphericalRange", "sphericalAzimuth", "sphericalElevation"} <= set(values):
        radius, azimuth, elevation = (
            values[f"spherical{part}"].astype(np.float64)
            for part in ("Range", "Azimuth", "Elevation")
        )
        flat = radius * np.cos(elevation)
        xyz = np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), radius * np.sin(elevation)])
        state = values.get("sphericalInvalidState")
    else:
        raise BadInputError(
            f"{file.name}: expected cartesian or spherical coordinates, got {', '.join(values)}"
        )
    pose = _pose(file, scan)
    if not np.array_equal(pose, np.eye(4)):
        xyz = pose[:3, :3] @ xyz + pose[:3, 3:]
    if state is not None:
        xyz[:, state != 0] = np.nan
    return xyz


def _pose(file: E57File, scan: Element) -> NDArray[np.float64]:
    """``T_file_scan``."""
    name, find = file.name, scan.find
    quaternion = [number(name, find(f"pose/rotation/{part}"), 0.0) for part in "xyzw"]
    turn = quaternion if any(quaternion) else [0.0, 0.0, 0.0, 1.0]
    place = [number(name, find(f"pose/translation/{part}"), 0.0) for part in "xyz"]
    pose = of_quaternion(name, np.array([*place, *turn], np.float64))
    if not np.isfinite(pose).all():
        raise BadInputError(f"{name}: expected a finite pose, got {pose[:3, 3].tolist()}")
    return pose


def _colors(
    file: E57File, scan: Element, values: Columns, limits: dict[str, tuple[float, float]]
) -> Columns:
    """Return colours as uint8, scaled by the scan's limits, or else by the fields' ranges."""
    colors: Columns = {}
    for color in COLORS:
        name = f"color{color.capitalize()}"
        low, high = limits[name]
        low = number(file.name, scan.find(f"colorLimits/{name}Minimum"), low)
        high = number(file.name, scan.find(f"colorLimits/{name}Maximum"), high)
        channel = values[name]
        if np.isfinite([low, high]).all() and high > low and not (low == 0 and high == 255):
            channel = np.clip((channel - low) / (high - low), 0, 1) * 255
        colors[color] = channel
    stacked = np.stack([np.rint(colors[color]) for color in COLORS], axis=1)
    eight = colors_of(
        file.name, stacked.astype(np.int64) if np.isfinite(stacked).all() else stacked
    )
    return {color: eight[:, i] for i, color in enumerate(COLORS)}


def _joined(parts: list[Columns]) -> Columns:
    """Concatenate scans; fill in fields that only some of them have for the others."""
    names = list(dict.fromkeys(name for part in parts for name in part)) or list("xyz")
    joined: Columns = {}
    for name in names:
        filler, kind = (GREY, np.uint8) if name in COLORS else (np.nan, np.float32)
        filler = 0 if name == "intensity" else filler
        pieces = [
            part[name] if name in part else np.full(len(part["x"]), filler, kind) for part in parts
        ]
        joined[name] = np.concatenate(pieces) if pieces else np.empty(0, np.float32)
    return joined
