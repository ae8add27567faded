"""Meanings of columns without names, by their number and values."""

from __future__ import annotations

import logging
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.options import ReadOptions

Array = NDArray[Any]
log = logging.getLogger(__name__)
LABELED = re.compile(r"label|annot|segm|semantic", re.IGNORECASE)
"""Names of files of points with labels."""
SAMPLE = 100_000
"""Rows that are checked for classes in a column."""
UNIT = 0.01
"""Greatest distance from 1 of a normal's length."""
MOSTLY = 0.99
"""Least share of rows with this length."""
LIKER = 0.15
"""Least difference in correlation between colour columns and other columns."""
MANY_SHADES = 32
"""Number of different values from which on a column is not a class."""


def unnamed(column: int) -> str:
    """Return the field name of a column without name and role; columns are counted from 0."""
    return f"column_{column + 1}"


def plain_columns(
    name: str, table: Array, options: ReadOptions, *, intensity_first: bool
) -> dict[str, Array]:
    """Return the columns of a table (N, 3 or more) without names, by their number and values.

    If the user gave their meanings, return all columns, named by their numbers.
    x y z, then an intensity alone; or red green blue; or intensity red green blue, which is tried
    first with ``intensity_first``.  Others (normals, classes) are fields ``column_7`` and so on.
    A fourth column of few whole numbers is a label if the file's ``name`` contains such a word.
    """
    width = table.shape[1]
    if options.chosen.columns:
        return {str(i): table[:, i] for i in range(width)}
    names = ["x", "y", "z"]
    after = width >= 7 and _are_colors(table[:, 4:7])
    before = width >= 6 and _are_colors(table[:, 3:6], whole=width > 6)
    if width in (4, 5):
        named_so = LABELED.search(name) is not None and _are_classes(table[:, 3])
        names += ["label" if named_so else "intensity"]
    elif after and (intensity_first or not before or _ends_in_colors(table)):
        names += ["intensity", "red", "green", "blue"]
    elif before:
        names += ["red", "green", "blue"]
    names += map(unnamed, range(len(names), width))
    _name_classes(name, table, names)
    return {column: table[:, i] for i, column in enumerate(names)}


def _are_classes(values: Array) -> bool:
    """Return whether a column has few whole numbers from 0 on, like classes."""
    shades = np.unique(values[:SAMPLE])
    whole = bool(np.isfinite(shades).all() and (shades >= 0).all() and not np.any(shades % 1))
    return whole and 1 < len(shades) <= MANY_SHADES


def _name_classes(name: str, table: Array, names: list[str]) -> None:
    """Warn of columns without a name that may be classes."""
    like = [
        i
        for i, column in enumerate(names)
        if column in ("intensity", unnamed(i)) and _are_classes(table[:, i])
    ]
    if like:
        meanings = ["label" if i == like[0] else old for i, old in enumerate(names)]
        log.warning(
            "%s: column %s holds few whole numbers and is kept as %s; if it has classes, import "
            "with columns %s", name, like[0] + 1, names[like[0]], ",".join(meanings),
        )  # fmt: skip


def _ends_in_colors(table: Array) -> bool:
    """Return whether columns 5 to 7 are the colours where columns 4 to 6 could be.

    Red, green and blue correlate with each other more than with an intensity.  If this does not
    decide, a last column that covers the range of a colour is a colour, not a class.
    """
    rows = table[np.isfinite(table[:, 3:7]).all(axis=1), 3:7].astype(np.float64)
    if len(rows) < 3:
        return False
    first, last = _likeness(rows[:, :3]), _likeness(rows[:, 1:])
    if abs(first - last) > LIKER:
        return last > first
    high = rows[:, 1:].max()
    return len(np.unique(rows[:, 3])) > MANY_SHADES and bool(rows[:, 3].max() > high / 4)


def _likeness(columns: NDArray[np.float64]) -> float:
    """Return the mean correlation of neighbouring columns (N, 3); 0 if one of them is constant."""
    centred = columns - columns.mean(axis=0)
    spread = np.sqrt((centred**2).mean(axis=0))
    products = (centred[:, :-1] * centred[:, 1:]).mean(axis=0)
    scale = spread[:-1] * spread[1:]
    return float(np.mean(np.divide(products, scale, out=np.zeros(2), where=scale > 0)))


def _are_normals(values: NDArray[Any]) -> bool:
    """Return whether rows (N, 3) have length 1, which colours as fractions hardly ever have."""
    length = np.linalg.norm(values.astype(np.float64), axis=1)
    return bool(np.mean(np.abs(length - 1) < UNIT) > MOSTLY)


def _are_colors(values: Array, *, whole: bool = True) -> bool:
    """Return whether values are fractions 0..1, or numbers 0..255, with ``whole`` only integers.

    Normals have negative components and do not match.
    """
    if values.dtype.kind == "f":
        values = values[np.isfinite(values).all(axis=1)]
    if len(values) == 0 or values.min() < 0:
        return False
    if values.max() <= 1:
        return not _are_normals(values)
    return bool(values.max() <= 255 and not (whole and np.any(values % 1)))
