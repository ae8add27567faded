"""Labels that the values of masks stand for."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.labels import Label
from pointbrush.labels.classes.palette import Palette, default_color
from pointbrush.work.classifiers.naming import label_of

Classes = Mapping[int, int | str]
"""Label id, or name of a label or class, of values of masks."""
MOST_NAMED = 20
"""Limit of names in an error."""


def chosen_labels(
    palette: Palette, classes: Classes, *, create: bool = False
) -> tuple[NDArray[np.uint16], list[Label]]:
    """Return the label id of each value (65536,), and the labels to add for them.

    A class of the workspace without a label gets one; ``create``: other names get one, too.
    Raises BadInputError for an unknown label or class.
    """
    ids, added, free = np.zeros(1 << 16, np.uint16), list[Label](), palette.free_ids()
    known = {label.id for label in palette.labels} | {0}
    for value, meant in classes.items():
        if isinstance(meant, int):
            if meant not in known:
                raise BadInputError(_unknown(palette, f"{meant} for value {value}"))
            ids[value] = meant
            continue
        label = _named(palette, [*palette.labels, *added], meant)
        if label is None:
            name = palette.classes.meaning(meant)
            if not (create or name in palette.classes.keys) or not palette.admits(name):
                raise BadInputError(_unknown(palette, f"{meant[:60]!r} for value {value}"))
            number = free.take((name, name))
            label = Label(number, name, name, default_color(number))
            added.append(label)
        ids[value] = label.id
    return ids, added


def _named(palette: Palette, labels: list[Label], name: str) -> Label | None:
    """Return the label with a name, or that of a class."""
    own = next((label for label in labels if label.name == name), None)
    return own or label_of(palette.classes.meaning(name), labels)


def _unknown(palette: Palette, got: str) -> str:
    names = [f"{label.id} {label.name!r}" for label in palette.labels[:MOST_NAMED]]
    listed = ", ".join(names) or "none yet"
    return f"classes: expected labels ({listed}) or classes of the workspace, got {got}"
