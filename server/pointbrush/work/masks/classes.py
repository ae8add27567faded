"""Labels of the values of masks."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.labels import Label
from pointbrush.labels.classes.palette import Palette, default_color
from pointbrush.work.classifiers.naming import label_of

Classes = Mapping[int, int | str]
"""Label id, or name of a label or class, by value of a mask."""
MOST_NAMED = 20
"""Most labels that an error lists."""


def chosen_labels(
    palette: Palette, classes: Classes, *, create: bool = False
) -> tuple[NDArray[np.uint16], list[Label]]:
    """Return the label id of each value (65536,), and the labels to add for them.

    A class of the workspace without a label gets one; ``create``: an unknown name gets one, too.
    Raises BadInputError for an unknown label or class.
    """
    ids, added, free = np.zeros(1 << 16, np.uint16), list[Label](), palette.free_ids()
    known = {label.id for label in palette.labels} | {0}
    for value, label_or_class in classes.items():
        if isinstance(label_or_class, int):
            if label_or_class not in known:
                raise BadInputError(_unknown(palette, f"{label_or_class} for value {value}"))
            ids[value] = label_or_class
            continue
        label = _named(palette, [*palette.labels, *added], label_or_class)
        if label is None:
            name = palette.classes.meaning(label_or_class)
            if not (create or name in palette.classes.keys) or not palette.admits(name):
                raise BadInputError(_unknown(palette, f"{label_or_class[:60]!r} for value {value}"))
            number = free.take((name, name))
            label = Label(number, name, name, default_color(number))
            added.append(label)
        ids[value] = label.id
    return ids, added


def _named(palette: Palette, labels: list[Label], name: str) -> Label | None:
    """Return the label with a name, or the label of the class with this name."""
    same_name = next((label for label in labels if label.name == name), None)
    return same_name or label_of(palette.classes.meaning(name), labels)


def _unknown(palette: Palette, got: str) -> str:
    """Return the message about an unknown label or class."""
    names = [f"{label.id} {label.name!r}" for label in palette.labels[:MOST_NAMED]]
    listed = ", ".join(names) or "none yet"
    return f"classes: expected labels ({listed}) or classes of the workspace, got {got}"
