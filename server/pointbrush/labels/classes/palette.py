"""The palette: check a label's fields, find free names and colours, fold the journal."""

from __future__ import annotations

import colorsys
import json
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count
from typing import Any

from sqlalchemy import Connection, select, true

from pointbrush.database.class_names import ClassNames
from pointbrush.database.schema import IN_FORCE, edit_labels, edits
from pointbrush.errors import BadInputError, ConflictError, NotFoundError
from pointbrush.labels.types import Label
from pointbrush.names import composed, require_visible

HIGHEST = 65_534
"""The greatest label id; 65535 means *deleted* on the wire."""
NAME_LIMIT = 200
CATEGORY_LIMIT = 256
"""Characters of the name of a class, which a label may get by a rename."""
MOST_INSTANCE = 65_535
"""The greatest number of an instance: SemanticKITTI keeps it in 16 bits."""
FIELDS: dict[str, type] = {
    "name": str, "category": str, "color": str, "locked": bool, "visible": bool,
    "instance": int, "position": int,
}  # fmt: skip
_COLOR = re.compile(r"#[0-9a-fA-F]{6}")
_GOLDEN = 0.618033988749895
_NUMBERED = re.compile(r"(.*?)\s*(\d{0,9})", re.DOTALL)


Called = tuple[str, str]
"""Name and category of a label."""


@dataclass(frozen=True, slots=True)
class Palette:
    """The palette at the commit of an edit, used to choose labels to add.

    ``labels``   in their order.
    ``given``    name and category by id, for all ids ever assigned, including undone edits.
    ``highest``  the greatest id ever assigned.
    ``allowed``  categories that labels may have, None: all.
    ``classes``  names of all classes.
    """

    labels: Sequence[Label]
    given: Mapping[int, Called]
    highest: int
    allowed: frozenset[str] | None = None
    classes: ClassNames = field(default_factory=ClassNames)

    def admits(self, category: str) -> bool:
        """Return whether a new label may have a category."""
        return self.allowed is None or category in self.allowed

    def free_ids(self) -> FreeIds:
        """Return ids for new labels."""
        return FreeIds(self)


class FreeIds:
    """Distinct ids for the new labels of one edit.

    Undo and redo can restore points with an earlier label's id, so an id is reused only for a label
    of the same name and category.
    """

    def __init__(self, palette: Palette) -> None:
        self._taken = {label.id for label in palette.labels}
        self._given = palette.given
        self._highest = max([palette.highest, *self._taken])
        self._before: dict[Called, list[int]] = {}
        for number, called in sorted(palette.given.items(), reverse=True):
            self._before.setdefault(called, []).append(number)

    def take(self, called: Called, wished: int = 0) -> int:
        """Return the ``wished`` id, the id of an earlier label of this name, or the next one.

        Raises ConflictError if no id is left.
        """
        number = wished if self._fits(wished, called) else self._repeated(called) or self._next()
        self._taken.add(number)
        self._highest = max(self._highest, number)
        return number

    def _fits(self, number: int, called: Called) -> bool:
        free = 1 <= number <= HIGHEST and number not in self._taken
        return free and self._given.get(number, called) == called

    def _repeated(self, called: Called) -> int:
        before = self._before.get(called, [])
        while before:
            if self._fits(number := before.pop(), called):
                return number
        return 0

    def _next(self) -> int:
        if self._highest < HIGHEST:
            return self._highest + 1
        for known in (self._taken | self._given.keys(), self._taken):
            for number in range(1, HIGHEST + 1):
                if number not in known:
                    return number
        raise ConflictError(f"label: expected at most {HIGHEST} labels, got more")


def check_fields(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Return the ``fields`` that are not None, checked; raises BadInputError."""
    given = {name: value for name, value in fields.items() if value is not None}
    for name, value in given.items():
        _check_kind(name, value)
    given |= {name: composed(given[name]) for name in ("name", "category") if name in given}
    if not 0 <= given.get("instance", 0) <= MOST_INSTANCE:
        raise BadInputError(
            f"label instance: expected 0 to {MOST_INSTANCE}, got {given['instance']}"
        )
    if not 0 <= given.get("position", 0) <= HIGHEST:
        raise BadInputError(f"label position: expected 0 to {HIGHEST}, got {given['position']}")
    if "name" in given and not given["name"].strip():
        raise BadInputError("label name: expected some text, got none")
    if "color" in given and not _COLOR.fullmatch(given["color"]):
        raise BadInputError(f"label color: expected #rrggbb, got {given['color']!r}")
    if "color" in given:
        given["color"] = given["color"].lower()
    return given


def _check_kind(name: str, value: object) -> None:
    """Raise BadInputError unless labels have a field ``name`` of the type of ``value``."""
    kind = FIELDS.get(name)
    if kind is None:
        raise BadInputError(f"label: expected fields {', '.join(FIELDS)}, got {name!r}")
    if not isinstance(value, kind):
        raise BadInputError(f"label {name}: expected {kind.__name__}, got {type(value).__name__}")
    limit = CATEGORY_LIMIT if name == "category" else NAME_LIMIT
    if isinstance(value, str) and len(value) > limit:
        raise BadInputError(f"label {name}: expected at most {limit} characters, got {len(value)}")
    if isinstance(value, str) and name in ("name", "category"):
        require_visible(f"label {name}", value)


def check_id(label_id: int) -> int:
    """Return ``label_id`` if it is a valid id; raises BadInputError."""
    if isinstance(label_id, bool) or not isinstance(label_id, int):
        raise BadInputError(f"label id: expected an integer, got {type(label_id).__name__}")
    if not 1 <= label_id <= HIGHEST:
        raise BadInputError(f"label id: expected 1 to {HIGHEST}, got {label_id}")
    return label_id


def in_order(palette: Iterable[Label]) -> list[Label]:
    """Return labels in the palette's order: by position, then labels without one by id."""
    return sorted(palette, key=lambda one: (one.position is None, one.position or 0, one.id))


def default_color(label_id: int) -> str:
    """Return a colour for an id; hues at steps of the golden ratio stay distinct the longest."""
    hue = (0.58 + label_id * _GOLDEN) % 1.0
    lightness = (0.58, 0.66, 0.5)[label_id % 3]
    red, green, blue = colorsys.hls_to_rgb(hue, lightness, 0.78)
    return f"#{round(red * 255):02x}{round(green * 255):02x}{round(blue * 255):02x}"


LABEL_EDITS = edit_labels.join(
    edits,
    (edits.c.sequence == edit_labels.c.sequence) & (edits.c.revision == edit_labels.c.revision),
)
"""Changes of labels, each with its edit."""


def require(palette: Mapping[int, Label], label_id: int) -> Label:
    """Return the label with this id; raises NotFoundError."""
    if label_id not in palette:
        raise NotFoundError(f"label: expected the id of a label, got {label_id}")
    return palette[label_id]


def fields_of(label: Label) -> dict[str, Any]:
    """Return all fields of an existing label, as stored in the journal."""
    fields = {name: getattr(label, name) for name in FIELDS}
    return {"exists": True, **{k: value for k, value in fields.items() if value is not None}}


def fold(
    connection: Connection, number: int, label_ids: Iterable[int], classes: ClassNames
) -> dict[int, Label | None]:
    """Fold the changes of each label by the edits in force; None: it does not exist."""
    wanted = list(label_ids)
    rows = connection.execute(
        select(edit_labels.c.label, edit_labels.c.fields)
        .select_from(LABEL_EDITS)
        .where(edit_labels.c.sequence == number, edit_labels.c.label.in_(wanted))
        .where(edits.c.state.in_(IN_FORCE))
        .order_by(edit_labels.c.revision)
    )
    merged: dict[int, dict[str, Any]] = {label_id: {} for label_id in wanted}
    for label_id, fields in rows:
        merged[label_id].update(json.loads(fields))
    return {label_id: _label(label_id, fields, classes) for label_id, fields in merged.items()}


def as_last_made(
    connection: Connection,
    number: int,
    label_id: int,
    classes: ClassNames,
    until: int | None = None,
) -> Label | None:
    """Fold the changes of a label by the edits in force and its last creation.

    None: it was deleted since.  ``until``: the last edit to fold.
    """
    last = edit_labels.c.revision <= until if until is not None else true()
    rows = connection.execute(
        select(edit_labels.c.fields, edits.c.state)
        .select_from(LABEL_EDITS)
        .where(edit_labels.c.sequence == number, edit_labels.c.label == label_id, last)
        .order_by(edit_labels.c.revision)
    )
    versions = [(json.loads(fields), state in IN_FORCE) for fields, state in rows]
    made = max((at for at, (fields, _) in enumerate(versions) if fields.get("exists")), default=0)
    merged: dict[str, Any] = {}
    for at, (fields, in_force) in enumerate(versions):
        if in_force or at == made:
            merged.update(fields)
    return _label(label_id, merged, classes)


def given_ids(connection: Connection, number: int, classes: ClassNames) -> dict[int, Called]:
    """Read the last name and class of the label of each id ever assigned."""
    rows = connection.execute(
        select(edit_labels.c.label, edit_labels.c.fields)
        .where(edit_labels.c.sequence == number)
        .order_by(edit_labels.c.revision)
    )
    called: dict[int, Called] = {}
    for label_id, fields in rows:
        before = called.get(label_id, ("", ""))
        given = classes.read(json.loads(fields))
        called[label_id] = given.get("name", before[0]), given.get("category", before[1])
    return called


def created_by(connection: Connection, number: int, revision: int, classes: ClassNames) -> Label:
    """Return the label that an edit created; raises NotFoundError if it created none."""
    row = connection.execute(
        select(edit_labels.c.label, edit_labels.c.fields).where(
            edit_labels.c.sequence == number, edit_labels.c.revision == revision
        )
    ).first()
    label = None if row is None else _label(row.label, json.loads(row.fields), classes)
    if label is None:
        raise NotFoundError(f"label: expected revision {revision} to have made one")
    return label


def _label(label_id: int, fields: dict[str, Any], classes: ClassNames) -> Label | None:
    exists = fields.pop("exists", False)
    return Label(label_id, **classes.read(fields)) if exists and "name" in fields else None


def free_name_and_color(fields: Mapping[str, Any], others: Collection[Label]) -> dict[str, Any]:
    """Return ``name`` and ``color`` of ``fields``, changed where one of ``others`` has them."""
    names = {label.name.strip().casefold() for label in others}
    colors = {label.color for label in others}
    return {
        "name": _free_name(fields["name"], names),
        "color": _free_color(fields["color"], colors),
    }


def _free_name(name: str, taken: Collection[str]) -> str:
    """Return ``name``, with its number increased if it is taken: "pin 2" for "pin" or "pin 1"."""
    if name.strip().casefold() not in taken:
        return name
    numbered = _NUMBERED.fullmatch(name.strip())
    base, digits = numbered.groups() if numbered else (name, "")
    for number in count(int(digits or 1) + 1):
        end = f" {number}" if base else str(number)
        found = base[: NAME_LIMIT - len(end)] + end
        if found.casefold() not in taken:
            return found
    raise AssertionError("numbers do not end")


def _free_color(color: str, taken: Collection[str]) -> str:
    """Return ``color``, or the first free default colour if it is taken."""
    if color not in taken:
        return color
    return next(
        (found for i in range(1, HIGHEST) if (found := default_color(i)) not in taken), color
    )
