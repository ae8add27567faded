"""Damaged files of every format are read or refused in words, and end no process."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import pytest

from tests.formats.mutated_files import REFUSED, import_base, outcomes, warm
from tests.formats.mutation_bases import Base, bases

FILES = 4
"""Changed files of each family; `make torture` has more of them."""
SLOW = ("laz",)
"""Families that start a process for each file."""


@pytest.fixture(scope="module")
def families() -> dict[str, list[Base]]:
    warm()
    return bases()


def test_changed_files_are_read_or_refused(families: dict[str, list[Base]]) -> None:
    quick = {name: found for name, found in families.items() if name not in SLOW}
    found = list(outcomes(quick, range(FILES), set()))
    assert not [each for each in found if not each.sound]
    assert len({each.family for each in found if each.what != REFUSED}) == len(quick)


def _png(width: int, height: int) -> bytes:
    """A PNG that says its size and has no pixels."""
    content = b"IHDR" + struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + content + struct.pack(
        ">I", zlib.crc32(content)
    )  # fmt: skip


HUGE = b"1" + b"0" * 400
TINY = struct.pack("<4d", 0.0, 0.0, 0.0, 1.0), struct.pack("<4d", 0.0, 0.0, 0.0, 1e-320)
DAMAGED: dict[str, tuple[str, str, str, bytes | tuple[bytes, bytes]]] = {
    "an image of 900 million pixels": ("depth", "depth", "depth/0.png", _png(30_000, 30_000)),
    "a name with a null byte": ("depth", "tum", "rgb.txt", b"10.0 rgb/\0.png\n"),
    "a name that is too long": ("depth", "tum", "rgb.txt", b"10.0 " + b"x" * 400),
    "a number without an end": ("depth", "depth", "camera.json", b'{"fx": %s}' % HUGE),
    "brackets in brackets": ("pictures", "cameras.json", "r/cameras.json", b"[" * 100_000),
    "a quaternion of almost 0": ("pictures", "Image.bag", "Image.bag", TINY),
    "a name that is no UTF-8": (
        "feather",
        "uncompressed.feather",
        "uncompressed.feather",
        (b"intensity", b"\xb6ntensity"),
    ),
    "a class that is no UTF-8": (
        "boxes",
        "our argoverse2",
        "annotations.feather",
        (b"vehicle", b"\xb6ehicle"),
    ),
    "a mask that is none": ("labels", "our ply", "e/deleted/000000.npy", b"\x93NUMPY\x01\x00"),
}
"""Faults of readers: family, base, file, and its new content, or what is exchanged in it."""


@pytest.mark.parametrize("damage", DAMAGED)
def test_damage_is_refused_in_words(
    damage: str, families: dict[str, list[Base]], tmp_path: Path
) -> None:
    family, name, file, content = DAMAGED[damage]
    base = next(each for each in families[family] if each.name == name)
    new = content if isinstance(content, bytes) else base.files[file].replace(*content)
    assert new != base.files[file]
    assert import_base(base, dict(base.files) | {file: new}, tmp_path) == REFUSED
