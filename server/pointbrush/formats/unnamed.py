"""Columns without names: what each is, by their number and by what they hold."""

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
"""Rows that tell whether a column holds classes."""
UNIT = 0.01
"""Greatest distance from 1 of a normal's length."""
MOSTLY = 0.99
"""Share of rows that keep to it."""
LIKER = 0.15
"""Difference in correlation that tells which columns are colours."""
MANY_SHADES = 32
"""Different values of a column that is hardly a class."""


def unnamed(column: int) -> str:
    """Return the name of the field that a column without a name and a role becomes, from 0."""
    return f"column_{column + 1}"


def plain_columns(
    name: str, table: Array, options: ReadOptions, *, intensity_first: bool
) -> dict[str, Array]:
    """Columns of a table (N, 3 or more) that has no names: by their number and values.

    Where a person says their meanings, all of them, called by their numbers.
    x y z, then an intensity alone; or red green blue; or intensity red green blue, which is tried
    first with ``intensity_first``.  Others (normals, classes) are fields ``column_7`` and so on.
    A fourth column of few whole numbers in a file called after labels, as ``name`` says, is one.
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
    """Whether a column holds few whole numbers from 0 on, as classes are counted."""
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

    Red, green and blue go together more than an intensity goes with them.  Where that does not
    tell, a last column that runs over the range of a colour is one, and no class.
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
    """Mean correlation of neighbouring columns (N, 3); 0 where one of them is constant."""
    centred = columns - columns.mean(axis=0)
    spread = np.sqrt((centred**2).mean(axis=0))
    products = (centred[:, :-1] * centred[:, 1:]).mean(axis=0)
    scale = spread[:-1] * spread[1:]
    return float(np.mean(np.divide(products, scale, out=np.zeros(2), where=scale > 0)))


def _are_normals(values: NDArray[Any]) -> bool:
    """Return whether rows (N, 3) have length 1: colours that are fractions hardly all do."""
    length = np.linalg.norm(values.astype(np.float64), axis=1)
    return bool(np.mean(np.abs(length - 1) < UNIT) > MOSTLY)


def _are_colors(values: Array, *, whole: bool = True) -> bool:
    """Fractions 0..1, or numbers 0..255, ``whole`` ones where other columns could be meant.

    Normals have negative parts, so are not taken.
    """
    if values.dtype.kind == "f":
        values = values[np.isfinite(values).all(axis=1)]
    if len(values) == 0 or values.min() < 0:
        return False
    if values.max() <= 1:
        return not _are_normals(values)
    return bool(values.max() <= 255 and not (whole and np.any(values % 1)))
