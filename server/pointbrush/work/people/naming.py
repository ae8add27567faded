"""Labels of people over frames: an existing label, or a new one."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.writers.labeled import category_of
from pointbrush.labels import Label
from pointbrush.labels.classes.palette import default_color, free_name_and_color
from pointbrush.work.people.frames import PersonInFrame

CLASSES = ("person", "pedestrian", "people", "human")
"""Names of the class of people, the usual one first."""
FARTHEST_STEP = 0.6
"""Largest distance of a person between two searched frames, metres."""

LabelsOf = Callable[[int, NDArray[np.int64]], NDArray[np.uint16]]
"""Frame and numbers of points (n,) -> their labels (n,)."""


@dataclass(frozen=True, slots=True, eq=False)
class NamedPerson:
    """A person over frames; ``label``: the one that it gets, ``known``: the palette has it."""

    seen: tuple[PersonInFrame, ...]
    label: Label
    known: bool


def join_frames(found: Sequence[Sequence[PersonInFrame]]) -> list[list[PersonInFrame]]:
    """Return each person over the searched frames: the nearest pairs of two frames first."""
    people: list[list[PersonInFrame]] = []
    for seen in found:
        pairs = sorted(
            (float(np.linalg.norm(person[-1].place - each.place)), p, s)
            for p, person in enumerate(people)
            for s, each in enumerate(seen)
        )
        taken: dict[int, int] = {}
        for distance, p, s in pairs:
            if distance <= FARTHEST_STEP and s not in taken and p not in taken.values():
                taken[s] = p
        for s, each in enumerate(seen):
            if s in taken:
                people[taken[s]].append(each)
            else:
                people.append([each])
    return people


def class_among(labels: Collection[Label], admits: Callable[[str], bool]) -> str:
    """Return the class of new labels of people: that of a palette, or one that it admits."""
    known = {category_of(label).casefold(): category_of(label) for label in labels}
    used = [known[name] for name in CLASSES if name in known]
    return next((name for name in (*used, *CLASSES) if admits(name)), CLASSES[0])


def name_people(
    people: Sequence[Sequence[PersonInFrame]], palette: Sequence[Label], labels_of: LabelsOf,
    admits: Callable[[str], bool], used: Collection[int],
) -> list[NamedPerson]:  # fmt: skip
    """Return people with their labels.

    A person gets the label that most of their points have, else a label of people that is not in
    ``used``, the labels with points, else a new one.  Ids of new labels are 0.
    """
    known = {label.id: label for label in palette if category_of(label).casefold() in CLASSES}
    category, others, found = class_among(palette, admits), list(palette), list[NamedPerson]()
    free = {i for i, label in known.items() if label.visible and not label.locked} - set(used)
    taken: set[int] = set()
    for seen in people:
        number = _usual(seen, labels_of, set(known) - taken)
        label = known.get(number or min(free - taken, default=0))
        if label is None:
            fields = {"name": f"{category} 1", "color": default_color(len(others) + 1)}
            new = Label(0, category=category, **free_name_and_color(fields, others))
            others.append(new)
            found.append(NamedPerson(tuple(seen), new, False))
        else:
            taken.add(label.id)
            found.append(NamedPerson(tuple(seen), label, True))
    return found


def _usual(seen: Sequence[PersonInFrame], labels_of: LabelsOf, known: set[int]) -> int:
    """Return the known label that most points of a person have in a frame, or 0."""
    for each in seen:
        found, counts = np.unique(labels_of(each.frame, each.numbers), return_counts=True)
        most = int(found[counts.argmax()]) if len(found) else 0
        if most in known and 2 * counts.max() > len(each.numbers):
            return most
    return 0
