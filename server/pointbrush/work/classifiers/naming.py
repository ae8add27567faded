"""Classes and their labels in a palette."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.writers.labeled import category_of
from pointbrush.labels import Label


def classes_of(palette: Sequence[Label]) -> tuple[str, ...]:
    """Return the classes of a palette, in its order."""
    return tuple(dict.fromkeys(category_of(label) for label in palette))


def label_of(name: str, palette: Sequence[Label]) -> Label | None:
    """Return the label that a class is predicted as, or None.

    A label with the name of the class has precedence, then labels that are not instances.
    """
    of_class = [label for label in palette if category_of(label) == name]
    of_class.sort(key=lambda label: (label.name != name, bool(label.instance)))
    return of_class[0] if of_class else None


def numbers_of(palette: Sequence[Label], classes: Sequence[str]) -> NDArray[np.uint8]:
    """Return for each label id 0..65535 its class, from 1, or 0."""
    table = np.zeros(1 << 16, np.uint8)
    places = {name: number for number, name in enumerate(classes, 1)}
    for label in palette:
        table[label.id] = places.get(category_of(label), 0)
    return table
