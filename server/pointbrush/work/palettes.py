"""Adding several labels: from a palette file, or the template of a dataset."""

from __future__ import annotations

import uuid
from collections import Counter
from collections.abc import Mapping, Sequence

from pointbrush.formats.tables.datasets import Dataset
from pointbrush.labels import Label, Write
from pointbrush.labels.classes.palette import Palette, default_color
from pointbrush.labels.classes.selection import require_allowed
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.values import labels as values
from pointbrush.values.labels import OfferedCategories, PaletteLabel


def counted_labels(store: WorkspaceStore, sequence: str) -> list[values.Label]:
    """Return the palette of a recording with the number of points of each label."""
    points: Counter[int] = Counter()
    for (_, label), (count, _) in store.counts(sequence).items():
        points[label] += count
    palette = store.palette(sequence)
    return [values.Label.of(label, points=points[label.id]) for label in palette]


def add_labels(
    store: WorkspaceStore, sequence: str, wanted: Sequence[PaletteLabel], author: str
) -> list[str]:
    """Add missing labels, by name and category, as one edit; return their names.

    Raises BadInputError for a category that the recording's project has not selected.
    """
    fresh = _fresh(store.choosing(sequence), wanted)

    def choose(palette: Palette) -> tuple[Sequence[Label], Mapping[int, Write]]:
        nonlocal fresh
        fresh = _fresh(palette, wanted)
        return fresh, {}

    if fresh:
        store.apply(
            sequence,
            edit_id=str(uuid.uuid4()),
            author=author,
            kind="label",
            writes=choose,
            summary=lambda *_: f"add {len(fresh)} labels",
        )
    return [label.name for label in fresh]


def _fresh(palette: Palette, wanted: Sequence[PaletteLabel]) -> list[Label]:
    """Return the labels of ``wanted`` that a palette does not have."""
    known = {(label.name, label.category) for label in palette.labels}
    ids, fresh = palette.free_ids(), []
    for each in wanted:
        called = (each.name, palette.classes.meaning(each.category))
        if called not in known:
            known.add(called)
            require_allowed(palette.allowed, called[1])
            number = ids.take(called)
            fresh.append(Label(number, *called, each.color or default_color(number)))
    return fresh


def add_template(store: WorkspaceStore, sequence: str, dataset: Dataset, author: str) -> list[str]:
    """Add a label for each class of a dataset; the classes keep their numbers in its files.

    Classes that the recording's project has not selected are left out.
    """
    palette, listed = store.choosing(sequence), dataset.classes
    words = {number: each.name for number, each in listed.items()}
    classes = {number: palette.classes.meaning(word) for number, word in words.items()}
    classes |= store.taxonomy.known_classes(dataset.name, words)
    classes = {number: name for number, name in classes.items() if palette.admits(name)}
    numbers = {name: number for number, name in classes.items()}
    store.taxonomy.learn(dataset.name, numbers, strict=False)
    wanted = [PaletteLabel(words[n], name, listed[n].color) for n, name in classes.items()]
    return add_labels(store, sequence, wanted, author)


def offered(store: WorkspaceStore, sequence: str) -> OfferedCategories:
    """Return the selection of the recording's project, or all categories."""
    selected = store.team.projects.selection(sequence)
    known = [each.name for each in store.taxonomy.entries()]
    names = (each for each in known if selected is None or each in selected)
    return OfferedCategories(selected is not None, tuple(names))
