"""E57: pages, packed integers, poses, and several scans."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pointbrush.errors import BadInputError, TooLargeError
from pointbrush.formats import Limits, open_source, read
from pointbrush.formats.readers.e57 import HEADER, PAYLOAD, Field, crc32c, decode


def paged(logical: bytes) -> bytes:
    padded = logical + bytes(-len(logical) % PAYLOAD)
    rows = np.frombuffer(padded, np.uint8).reshape(-1, PAYLOAD)
    return b"".join(
        row.tobytes() + int(crc).to_bytes(4, "big")
        for row, crc in zip(rows, crc32c(rows), strict=True)
    )


def physical(logical: int) -> int:
    return logical // PAYLOAD * 1024 + logical % PAYLOAD


def packed_bits(values, bits: int) -> bytes:
    total = sum(int(value) << (i * bits) for i, value in enumerate(values))
    return total.to_bytes((len(values) * bits + 7) // 8, "little")


def packets(streams: list[bytes], step: int = 7) -> bytes:
    """Data packets with ``step`` bytes of each stream, as if buffers had been small."""
    out = b""
    while any(streams):
        parts, streams = [s[:step] for s in streams], [s[step:] for s in streams]
        body = struct.pack(f"<{len(parts)}H", *map(len, parts)) + b"".join(parts)
        body += bytes(-(len(body) + 6) % 4)
        out += struct.pack("<BBHH", 1, 0, len(body) + 5, len(parts)) + body
    return out


POSE = (
    "<pose><rotation><w>0</w><x>0</x><y>0</y><z>1</z></rotation>"
    "<translation><x>10</x><y>0</y><z>0</z></translation></pose>"
)


def e57(count: int = 3, *, record_count: object = None, pose: str = "") -> bytes:
    """A file with x in 13 bits scaled, y constant, z single floats, and colours."""
    x = packed_bits([(i * 1000) % 8192 for i in range(count)], 13)
    z = np.arange(count, dtype="<f4").tobytes()
    color = bytes(range(count))
    integer = 'type="Integer" minimum="0" maximum="255"'
    prototype = (
        '<cartesianX type="ScaledInteger" minimum="-100" maximum="8091" scale="0.5" offset="1"/>'
        '<cartesianY type="Integer" minimum="7" maximum="7"/>'
        '<cartesianZ type="Float" precision="single"/>'
        f"<colorRed {integer}/><colorGreen {integer}/><colorBlue {integer}/>"
    )
    return one_scan(
        packets([x, b"", z, color, color, color]), prototype, record_count or count, pose
    )


def one_scan(data: bytes, prototype: str, record_count: object, pose: str = "") -> bytes:
    """A file of one scan, whose points are the packets ``data``."""
    start = HEADER.size
    section = struct.pack("<B7xQQQ", 1, 32 + len(data), physical(start + 32), 0) + data
    xml = (
        '<?xml version="1.0"?><e57Root type="Structure" '
        'xmlns="http://www.astm.org/COMMIT/E57/2010-e57-v1.0"><data3D type="Vector">'
        f'<vectorChild type="Structure">{pose}<points type="CompressedVector" '
        f'fileOffset="{physical(start)}" recordCount="{record_count}"><prototype>{prototype}'
        "</prototype></points></vectorChild></data3D></e57Root>"
    ).encode()
    at = physical(start + len(section))
    body = section + xml
    length = len(paged(bytes(start) + body))
    header = HEADER.pack(b"ASTM-E57", 1, 0, length, at, len(xml), 1024)
    return paged(header + body)


def one(path, data, **kwargs):
    path.write_bytes(data)
    (frame,) = read(path, **kwargs)
    return frame


def test_the_checksum_is_crc_32c():
    assert crc32c(np.frombuffer(b"123456789", np.uint8)[None]).tolist() == [0xE3069283]


@given(st.integers(1, 63).flatmap(lambda b: st.tuples(st.just(b), st.lists(
    st.integers(0, min(2**b, 2**52) - 1), max_size=40))))  # fmt: skip
def test_integers_of_any_width(case):
    bits, values = case
    field = Field("a", "int", 0, 2**bits - 1)
    assert field.bits == bits
    packed = bytearray(packed_bits(values, bits))
    assert decode("a", field, packed, len(values)).tolist() == values


@pytest.mark.parametrize("count", [1, 3, 200])
def test_every_kind_of_field(tmp_path, count):
    frame = one(tmp_path / "a.e57", e57(count))
    raw = np.arange(count) * 1000 % 8192
    assert frame.xyz[:, 0].tolist() == ((raw - 100) * 0.5 + 1).tolist()
    assert frame.xyz[:, 1].tolist() == [7] * count
    assert frame.xyz[:, 2].tolist() == list(range(count))
    assert frame.rgb[:, 0].tolist() == list(range(count))


def test_the_pose_moves_the_points(tmp_path):
    still = one(tmp_path / "a.e57", e57())
    moved = one(tmp_path / "a.e57", e57(pose=POSE))
    assert np.allclose(moved.xyz, still.xyz * [-1, -1, 1] + [10, 0, 0])
    assert moved.viewpoint.tolist() == [10, 0, 0]


def test_damage_is_found(tmp_path):
    good = e57(200)
    for at in (100, 1500, len(good) - 1):
        bad = bytearray(good)
        bad[at] ^= 1
        with pytest.raises(BadInputError, match=r"1 of .* pages are damaged"):
            one(tmp_path / "a.e57", bytes(bad))
    for size in (0, 7, 47, 1024, len(good) - 1024, len(good) - 1):
        with pytest.raises(BadInputError, match=r"a\.e57: expected"):
            one(tmp_path / "a.e57", good[:size])


@pytest.mark.parametrize("count", ["-1", "many", "99999999999999", "1000"])
def test_counts_that_do_not_fit_raise(tmp_path, count):
    with pytest.raises(BadInputError, match=r"recordCount that fits|data end early"):
        one(tmp_path / "a.e57", e57(record_count=count))


def test_a_file_of_more_points_than_allowed_is_refused(tmp_path):
    (tmp_path / "a.e57").write_bytes(e57(200))
    with pytest.raises(TooLargeError, match="at most 100 points"):
        list(open_source([tmp_path / "a.e57"], limits=Limits(max_points=100)).frames)


def test_real_scans_agree_in_floats_and_integers(shared):
    floats, integers = (
        next(read(shared / "formats" / "e57" / f"e57__bunny{kind}.e57"))
        for kind in ("Float", "Int21")
    )
    assert np.abs(floats.xyz - integers.xyz).max() < 1e-6


def test_several_scans_with_different_fields(shared):
    (frame,) = read(shared / "formats" / "e57" / "PDAL__A_B_different_dims.e57")
    assert frame.rgb.tolist() == [[128, 128, 128], [74, 92, 54]]
    assert frame.intensity.tolist() == [pytest.approx(0.7596, abs=1e-4), 0]
