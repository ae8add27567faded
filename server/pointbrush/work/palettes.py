"""Several labels at once: a palette file, or the template of a dataset."""

from __future__ import annotations

import uuid
from collections.abc import Sequence
from dataclasses import dataclass

from pointbrush.formats.datasets import Dataset
from pointbrush.labels import Label, LabelStore
from pointbrush.labels.palette import default_color


@dataclass(frozen=True, slots=True)
class NamedLabel:
    """A label that has no id yet; ``color`` None: one of its own."""

    name: str
    category: str = ""
    color: str | None = None


def add_labels(
    store: LabelStore, sequence: str, wanted: Sequence[NamedLabel], author: str
) -> list[str]:
    """Add those that are not there by name and category, as one edit; returns their names."""
    palette = store.palette(sequence)
    known = {(label.name, label.category) for label in palette}
    following = max((label.id for label in palette), default=0) + 1
    fresh = []
    for each in wanted:
        if (each.name, each.category) in known:
            continue
        known.add((each.name, each.category))
        color = each.color or default_color(following)
        fresh.append(Label(following, each.name, each.category, color))
        following += 1
    if fresh:
        store.apply(
            sequence,
            edit_id=str(uuid.uuid4()),
            author=author,
            kind="label",
            writes=(),
            summary=f"add {len(fresh)} labels",
            labels=fresh,
        )
    return [label.name for label in fresh]


def add_template(store: LabelStore, sequence: str, dataset: Dataset, author: str) -> list[str]:
    """Add a label for each class of a dataset; the classes keep their numbers in its files."""
    store.taxonomy.learn(
        dataset.name, {each.name: number for number, each in dataset.classes.items()}, strict=False
    )
    wanted = [NamedLabel(each.name, each.name, each.color) for each in dataset.classes.values()]
    return add_labels(store, sequence, wanted, author)
