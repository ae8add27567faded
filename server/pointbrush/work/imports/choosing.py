"""The palette's label for each class and instance of label files, and those that are new."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from pointbrush.formats.annotation import LabelFiles
from pointbrush.formats.datasets import ClassName
from pointbrush.labels import Label
from pointbrush.labels.palette import Called, Palette, default_color

Key = tuple[int, int]
"""Numbers of a class and of an instance, 0 for none."""


@dataclass(frozen=True, eq=False)
class Chosen:
    """Labels of the palette for keys of label files.

    ``ids``      the label of each key.
    ``fresh``    those of them that are new.
    ``unnamed``  class numbers without a name.
    ``classes``  the number of each category.
    """

    ids: Mapping[Key, int]
    fresh: Sequence[Label]
    unnamed: Sequence[int]
    classes: Mapping[str, int]

    @classmethod
    def of(cls, palette: Palette, keys: Iterable[Key], files: LabelFiles) -> Chosen:
        """Choose a label for each key: one of its name and category, or a new one."""
        by_name: dict[Called, list[int]] = {}
        for label in palette.labels:
            by_name.setdefault((label.name, label.category), []).append(label.id)
        reserved = {
            i for i, own in files.own.items() if i in by_name.get((own.name, own.category), ())
        }
        free_ids = palette.free_ids()
        ids: dict[Key, int] = {}
        fresh: list[Label] = []
        unnamed: set[int] = set()
        classes: dict[str, int] = {}
        for key in sorted(set(keys)):
            called, color, wanted = _called(key, files)
            own = files.own.get(key[0])
            if key[0] not in files.names and own is None:
                unnamed.add(key[0])
            alike = by_name.setdefault(called, [])
            free = (each for each in alike if each not in reserved)
            known = wanted if own and wanted in alike else next(free, None)
            if own and known is not None:
                # Labels of ours that share a name are several: each takes one of the palette.
                alike.remove(known)
            if known is None:
                known = free_ids.take(called, wanted)
                if not own:
                    alike.append(known)
                made = Label(known, *called, color or default_color(known))
                if own:
                    made = replace(made, instance=own.instance)
                fresh.append(replace(made, instance=key[1]) if files.dataset else made)
            ids[key] = known
            classes[called[1] or called[0]] = key[0]
        return cls(ids, fresh, sorted(unnamed), classes)


def _called(key: Key, files: LabelFiles) -> tuple[Called, str, int]:
    """Name and category, colour and wished id of a key."""
    number, instance = key
    if number in files.own:
        label = files.own[number]
        return (label.name, label.category), label.color, label.id
    given = files.names.get(number, ClassName(f"class {number}"))
    if instance == 0:
        return (given.name, given.name), given.color, number
    # A class's colour is of all its instances: they are told apart by colours of their own.
    return (f"{given.name} {instance}", given.name), "", 0
