"""Numberings of classes: numbers of categories in an export's files."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass

from pointbrush.formats.tables.datasets import DATASETS, LAS, SCANNET, SEMANTIC_KITTI


@dataclass(frozen=True, slots=True)
class Numbering:
    """Numbers of classes in a kind of files.

    If the data set ``name`` is known, a class with an official name gets its official number, and
    no other class gets an official number.  Other classes have numbers from ``first`` to ``last``.
    ``dense``: they are counted in the order of the classes; otherwise a class has its number in the
    workspace if it is free, or the greatest free number.
    """

    name: str
    first: int
    last: int
    dense: bool = False

    def completed(self, known: Mapping[str, int], wanted: Mapping[str, int]) -> dict[str, int]:
        """Add numbers for classes of ``wanted`` without one; its values are preferred numbers."""
        numbers = dict(known)
        listed = official_numbers(self.name)
        taken = set(known.values())
        barred = {*taken, *listed.values()}
        for name, own in wanted.items():
            if name in numbers:
                continue
            number = listed.get(plain(name))
            if number is None or number in taken:
                number = self._free(barred, own)
            if number is not None:
                numbers[name] = number
                taken.add(number)
                barred.add(number)
        return numbers

    def _free(self, taken: Collection[int], own: int) -> int | None:
        if self.dense:
            following = max(taken, default=self.first - 1) + 1
            return following if following <= self.last else None
        if self.first <= own <= self.last and own not in taken:
            return own
        return next((n for n in range(self.last, self.first - 1, -1) if n not in taken), None)


KITTI_NUMBERS = Numbering(SEMANTIC_KITTI.name, 1, 65_535)
"""SemanticKITTI keeps a class in 16 bits, of which 0 is unlabeled."""
LAS_NUMBERS = Numbering(LAS.name, 64, 255)
"""ASPRS leaves 64 to 255 to users; its own classes keep their numbers."""
TRAINING_NUMBERS = Numbering("training", 0, 32_767, dense=True)
GREATEST = 65_535
"""Greatest number of a class in the files of other data sets."""
SCANNET_NUMBERS = Numbering(SCANNET.name, 41, GREATEST)
"""NYU40 numbers its classes 1 to 40; ScanNet-20 lists 20 of them."""
KNOWN_NUMBERINGS = (KITTI_NUMBERS, LAS_NUMBERS, TRAINING_NUMBERS, SCANNET_NUMBERS)


def numbering_of(dataset: str) -> Numbering:
    """Return the numbering of a data set's files; from 1 to GREATEST for an unknown one."""
    known = {numbering.name: numbering for numbering in KNOWN_NUMBERINGS}
    return known.get(dataset) or Numbering(dataset, 1, GREATEST)


def official_numbers(dataset: str) -> dict[str, int]:
    """Return the numbers of a known data set's classes by their ``plain`` names."""
    listed = DATASETS[dataset].classes.items() if dataset in DATASETS else ()
    return {plain(each.name): number for number, each in listed}


def plain(name: str) -> str:
    """Return the name of a class in lower case, with a space between words."""
    return re.sub(r"[\s_-]+", " ", name).strip().casefold()
