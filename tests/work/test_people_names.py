"""People get labels of the palette that have no points yet before new ones are made."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.labels import Label
from pointbrush.work.people.frames import PersonInFrame
from pointbrush.work.people.naming import name_people

BLUE = "#4c78ff"


def seen(first: int) -> list[PersonInFrame]:
    """A person of 10 points in frame 0."""
    return [PersonInFrame(0, np.arange(first, first + 10), 0.9, np.zeros(3), 2.0)]


def test_labels_of_people_without_points_are_used_before_new_ones() -> None:
    palette = [
        Label(1, "pin 1", color=BLUE, category="pin"),
        Label(2, "anna", color=BLUE, category="person"),
        Label(3, "ben", color=BLUE, category="person"),
        Label(4, "carl", color=BLUE, category="person", locked=True),
        Label(5, "dora", color=BLUE, category="person"),
    ]
    labels = np.zeros(60, np.uint16)
    labels[20:30] = 3

    def labels_of(frame: int, numbers: NDArray[np.int64]) -> NDArray[np.uint16]:
        return labels[numbers]

    people = [seen(first) for first in (0, 20, 30, 40)]
    named = name_people(people, palette, labels_of, lambda _: True, used={3})
    assert [(person.label.name, person.known) for person in named] == [
        ("anna", True),
        ("ben", True),
        ("dora", True),
        ("person 1", False),
    ]
