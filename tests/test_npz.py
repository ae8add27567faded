"""Archives of arrays from outside are refused in words before anything uses them."""

from __future__ import annotations

import io
import zipfile
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.exchange.npz import checked, read_npz

MOST = 1 << 20


def archive(**arrays: NDArray[Any]) -> bytes:
    out = io.BytesIO()
    np.savez_compressed(out, **arrays)  # type: ignore[arg-type]  # numpy's stub takes no mapping
    return out.getvalue()


def with_member(content: bytes) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as made:
        made.writestr("a.npy", content)
    return out.getvalue()


def with_header(shape: tuple[int, ...]) -> bytes:
    out = io.BytesIO()
    header = {"descr": "<f8", "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(out, header)  # type: ignore[arg-type]
    return with_member(out.getvalue() + bytes(64))


def test_arrays_come_back_writable() -> None:
    given = {"a": np.arange(12.0).reshape(3, 4), "b": np.array("word"), "c": np.empty((0, 3), "i4")}
    found = read_npz(archive(**given), MOST)
    assert {name: found[name].tolist() for name in found} == {
        name: array.tolist() for name, array in given.items()
    }
    assert found["a"].flags.writeable
    order = read_npz(archive(a=np.asfortranarray(given["a"])), MOST)["a"]
    assert order.flags.c_contiguous
    assert order.tolist() == given["a"].tolist()


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "archive"),
        (archive(a=np.zeros(10))[:-30], "archive"),
        (archive(a=np.zeros(MOST)), "unpacked bytes"),
        (archive(a=np.array([{}], object)), "objects"),
        (with_member(b"rubbish"), "expected a .npy array"),
        (with_header((1 << 40,)), "bytes of float64"),
        (with_header((3,)), "bytes of float64"),
        (with_header((-8,)), "bytes of float64"),
    ],
)
def test_other_bytes_are_refused_before_memory_is_taken(data: bytes, reason: str) -> None:
    with pytest.raises(BadInputError, match=reason):
        read_npz(data, MOST)


@pytest.mark.parametrize(
    ("array", "reason"),
    [
        (np.zeros((2, 3), np.float64), "expected a float32"),
        (np.zeros((3, 2), np.float32), "expected a float32"),
        (np.zeros(3, np.float32), "expected a float32"),
        (np.full((1, 3), np.nan, np.float32), "got nan"),
        (np.full((1, 3), np.inf, np.float32), "got inf"),
        (np.full((1, 3), 2, np.float32), "from 0 to 1, got 2.0 to 2.0"),
    ],
)
def test_arrays_out_of_bounds_are_refused(array: NDArray[Any], reason: str) -> None:
    with pytest.raises(BadInputError, match=reason):
        checked({"a": array}, "a", np.float32, (None, 3), 0, 1)
