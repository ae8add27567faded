"""Choosing labels of a palette for imported classes and instances.

Labels in the files of a recording and labels in separate files have the same rule: a label of a
pointbrush export is itself, an instance of a class is a label, points of a class without an
instance are one label.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from pointbrush.database.class_names import ClassNames
from pointbrush.errors import BadInputError
from pointbrush.formats.tables.datasets import ClassName
from pointbrush.labels import Label
from pointbrush.labels.classes.palette import HIGHEST, Called, Palette, default_color
from pointbrush.work.imports.naming import Key, Naming

MOST_NAMED = 20
"""Limit of categories named in a warning."""


@dataclass(frozen=True, eq=False)
class Chosen:
    """Labels of the palette for keys.

    ``ids``      the label of each key; 0: its category is excluded.
    ``fresh``    the new labels among them.
    ``unnamed``  class numbers without a name.
    ``classes``  the number of each category.
    ``left_out`` categories that the recording's project has not selected.
    """

    ids: Mapping[Key, int]
    fresh: Sequence[Label]
    unnamed: Sequence[int]
    classes: Mapping[str, int]
    left_out: Sequence[str] = ()

    @classmethod
    def of(cls, palette: Palette, keys: Iterable[Key], naming: Naming) -> Chosen:
        """Return a label for each key: one of its name and category, or a new one.

        Raises BadInputError if a palette cannot have so many labels.
        """
        meant = {key: _called(key, naming, palette.classes) for key in keys}
        categories = {key: called[1] for key, (called, _, _) in meant.items()}
        left_out = {key for key, category in categories.items() if not palette.admits(category)}
        require_few(categories.keys() - left_out)
        by_name: dict[Called, list[int]] = {}
        for label in palette.labels:
            by_name.setdefault((label.name, label.category), []).append(label.id)
        own_names = {i: _called((i, 0), naming, palette.classes)[0] for i in naming.own}
        reserved = {i for i, called in own_names.items() if i in by_name.get(called, ())}
        free_ids = palette.free_ids()
        ids: dict[Key, int] = dict.fromkeys(left_out, 0)
        fresh: list[Label] = []
        unnamed: set[int] = set()
        classes: dict[str, int] = {}
        for key in sorted(categories.keys() - left_out):
            called, color, wanted = meant[key]
            own = naming.own.get(key[0])
            if key[0] not in naming.names and own is None:
                unnamed.add(key[0])
            alike = by_name.setdefault(called, [])
            free = (each for each in alike if each not in reserved)
            known = wanted if own and wanted in alike else next(free, None)
            if own and known is not None:
                # Labels of an export that share a name stay distinct: each takes one of the
                # palette.
                alike.remove(known)
            if known is None:
                known = free_ids.take(called, wanted)
                if not own:
                    alike.append(known)
                made = Label(known, *called, color or default_color(known))
                if own:
                    made = replace(made, instance=own.instance)
                fresh.append(replace(made, instance=key[1]) if naming.dataset else made)
            ids[key] = known
            classes[called[1] or called[0]] = key[0]
        without = sorted({categories[key] for key in left_out})
        return cls(ids, fresh, sorted(unnamed), classes, without)

    def warnings(self) -> list[str]:
        """Return a sentence about the excluded categories, if any."""
        if not self.left_out:
            return []
        named = ", ".join(self.left_out[:MOST_NAMED])
        return [f"labels of categories that the project has not selected are left out: {named}"]


def require_few(keys: Collection[Key]) -> None:
    """Raise BadInputError if a palette cannot have labels for so many classes and objects."""
    if len(keys) > HIGHEST:
        raise BadInputError(
            f"labels: expected at most {HIGHEST:,} classes and objects, got {len(keys):,}"
        )


def _called(key: Key, naming: Naming, classes: ClassNames) -> tuple[Called, str, int]:
    """Return the name and category, colour and preferred id of a key."""
    number, instance = key
    if number in naming.own:
        label = naming.own[number]
        return (label.name, classes.meaning(label.category)), label.color, label.id
    given = naming.names.get(number, ClassName(f"class {number}"))
    category = naming.classes.get(number) or classes.meaning(given.name)
    if instance == 0:
        return (given.name, category), given.color, number
    # The class's colour would be equal for all instances, so they get separate colours.
    return (f"{given.name} {instance}", category), "", 0
