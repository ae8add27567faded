"""Conversion of columns of labels and instances to numbers of 16 bits."""

from __future__ import annotations

import logging
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError

Array = NDArray[Any]
log = logging.getLogger(__name__)

NO_LABEL = (-1, -100, 65535, 4294967295)
"""Numbers that mark "none" in labels and instances."""
GREATEST_INSTANCE = 65535
MOST_LISTED = 8
"""Most numbers in the list of a warning."""


def number_of(name: str, what: str, values: Array, greatest: int) -> NDArray[np.uint16]:
    """Labels or instances as uint16; NaN and ``NO_LABEL`` mark "none" and become 0.

    Raises BadInputError for fractions and for numbers outside 0..greatest.
    """
    if values.dtype.kind == "f":
        # Half precision has no numbers up to 65535.
        values = values.astype(np.promote_types(values.dtype, np.float32), copy=False)
        values = np.where(np.isnan(values), 0, values)
        fractions = np.flatnonzero((values != np.rint(values)) | np.isinf(values))
        if fractions.size:
            at = int(fractions[0])
            raise BadInputError(f"{name}: expected whole {what}s, got {values[at]} at point {at}")
    elif values.dtype.kind not in "uib":
        raise BadInputError(f"{name}: expected {what}s as numbers, got {values.dtype}")
    values = without_marks(values)
    if len(values) and (values.min() < 0 or values.max() > greatest):
        raise BadInputError(
            f"{name}: expected {what}s 0 to {greatest}, got {values.min():g} to {values.max():g}"
        )
    return values.astype(np.uint16)


def without_marks(values: Array) -> Array:
    """Labels or instances with 0 for the numbers that mark "none"."""
    marks = [mark for mark in NO_LABEL if mark >= 0 or values.dtype.kind in "fi"]
    marked = np.isin(values, marks)
    return np.where(marked, 0, values) if marked.any() else values


def instances_of(name: str, values: Array) -> NDArray[np.uint16] | None:
    """Return instance numbers as uint16, or None if no point has one.

    Numbers beyond 16 bits (a no-data value, the id of a database) become 0, with a warning that
    lists them.
    """
    if values.dtype.kind in "fiu":
        values = without_marks(np.where(np.isnan(values), 0, values))
        outside = (values < 0) | (values > GREATEST_INSTANCE)
        if outside.any():
            numbers = np.unique(values[outside])
            listed = ", ".join(f"{number:.10g}" for number in numbers[:MOST_LISTED])
            log.warning(
                "%s: expected instance numbers 0 to %d; %d points of %d other numbers (%s%s) have "
                "no instance", name, GREATEST_INSTANCE, np.count_nonzero(outside), len(numbers),
                listed, ", …" * (len(numbers) > MOST_LISTED),
            )  # fmt: skip
            values = np.where(outside, 0, values)
            if not values.any():
                return None
    return number_of(name, "instance", values, GREATEST_INSTANCE)
