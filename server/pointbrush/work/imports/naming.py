"""Numbers of classes and instances in imported files, and their names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.tables.datasets import SEMANTIC_KITTI, ClassName
from pointbrush.formats.tables.palette import SourceLabel
from pointbrush.labels import LabelStore

Key = tuple[int, int]
"""Numbers of a class and of an instance, 0 for none."""


@dataclass(frozen=True, eq=False)
class Naming:
    """Meaning of the numbers of labels; picklable.

    ``names``: classes by number.  ``own``: labels by id, for numbers of a pointbrush palette.
    ``dataset``: the dataset that defines the numbers, "" if unknown.  ``classes``: names of the
    workspace's classes by the dataset's numbers.
    """

    names: Mapping[int, ClassName] = field(default_factory=dict)
    own: Mapping[int, SourceLabel] = field(default_factory=dict)
    dataset: str = ""
    classes: Mapping[int, str] = field(default_factory=dict)

    def in_workspace(self, store: LabelStore) -> Naming:
        """Return a copy with the names of the workspace's classes."""
        words = {number: each.name for number, each in self.names.items()}
        return replace(self, classes=store.taxonomy.known_classes(self.dataset, words))


def keys_of(
    category: NDArray[np.int64], instance: NDArray[np.int64]
) -> tuple[tuple[Key, ...], NDArray[np.int64]]:
    """Return the sorted keys of points (n,), and the index of the key of each point (n,)."""
    packed, which = np.unique(category << 32 | instance, return_inverse=True)
    keys = tuple((int(key) >> 32, int(key) & 0xFFFFFFFF) for key in packed)
    return keys, which.astype(np.int64)


def learn_numbers(store: LabelStore, naming: Naming, classes: Mapping[str, int]) -> None:
    """Store the numbers of categories in their dataset, except conflicting ones.

    ``classes``: numbers of the dataset by category.
    """
    if naming.dataset:
        store.taxonomy.learn(naming.dataset, classes, strict=False)
    exported = {
        label.category or label.name: label.packed & 0xFFFF
        for label in naming.own.values()
        if label.packed is not None
    }
    if exported:
        store.taxonomy.learn(SEMANTIC_KITTI.name, exported, strict=False)
