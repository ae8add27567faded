"""The label store as its documentation describes it: slow, in memory, obvious.

The state is never kept: every question replays the edits that are in force, in order.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

from pointbrush.errors import ConflictError, HiddenLabelError, LockedLabelError, NotFoundError

ACTIVE, UNDONE, DROPPED, KEPT, INERT = range(5)
Point = tuple[int, int]


class Mark(NamedTuple):
    label: int
    provenance: int


@dataclass
class Edit:
    author: str
    state: int = ACTIVE
    marks: dict[Point, Mark] = field(default_factory=dict)
    deleted: dict[Point, bool] = field(default_factory=dict)
    labels: dict[int, dict[str, Any]] = field(default_factory=dict)
    tracks: dict[tuple[int, int], Any] = field(default_factory=dict)
    boxes: dict[int, dict[str, Any] | None] = field(default_factory=dict)
    """Changes of boxes, None where one is removed; "new" where one begins anew."""

    @property
    def in_force(self) -> bool:
        return self.state in (ACTIVE, KEPT)


class Model:
    def __init__(self) -> None:
        self.edits: list[Edit] = []
        self.highest = 0

    # ── what a replay gives ──

    def top(self, layer: str) -> dict[Point, tuple[Any, Edit]]:
        return {
            point: (value, edit)
            for edit in self.edits
            if edit.in_force
            for point, value in getattr(edit, layer).items()
        }

    def palette(self) -> dict[int, dict[str, Any]]:
        merged: dict[int, dict[str, Any]] = {}
        for edit in self.edits:
            if edit.in_force:
                for label, fields in edit.labels.items():
                    merged.setdefault(label, {}).update(fields)
        return {n: f for n, f in merged.items() if f.get("exists") and "name" in f}

    def tracks(self) -> dict[tuple[int, int], Any]:
        palette = self.palette()
        found = {place: v for e in self.edits if e.in_force for place, v in e.tracks.items()}
        return {place: value for place, value in found.items() if place[1] in palette}

    def raw_boxes(self) -> dict[int, dict[str, Any]]:
        found: dict[int, dict[str, Any] | None] = {}
        for edit in self.edits:
            if edit.in_force:
                for box, change in edit.boxes.items():
                    old = found.get(box)
                    found[box] = change and _changed_box(old, change)
        return {box: state for box, state in found.items() if state and state["there"]}

    def boxes(self) -> dict[int, tuple[int, dict[int, float]]]:
        palette = self.palette()
        return {
            box: (state["label"], state["poses"])
            for box, state in self.raw_boxes().items()
            if state["label"] in palette
        }

    def raw(self) -> dict[Point, Mark]:
        return {point: mark for point, (mark, _) in self.top("marks").items()}

    def held(self) -> dict[Point, Mark]:
        return {point: mark for point, mark in self.raw().items() if mark.label}

    def visible(self, known: Any = None) -> dict[Point, tuple[int, int, bool]]:
        known = self.palette() if known is None else known
        deleted = {point: flag for point, (flag, _) in self.top("deleted").items()}
        shown: dict[Point, tuple[int, int, bool]] = {}
        raw = self.raw()
        for point in raw.keys() | deleted.keys():
            mark = raw.get(point, Mark(0, 0))
            if mark.label and mark.label not in known:
                mark = Mark(0, 0)
            if (*mark, deleted.get(point, False)) != (0, 0, False):
                shown[point] = (*mark, deleted.get(point, False))
        return shown

    def counts(self) -> dict[tuple[int, int], tuple[int, int]]:
        found: dict[tuple[int, int], tuple[int, int]] = {}
        for (frame, _), (label, provenance, deleted) in self.visible().items():
            if label and not deleted:
                points, painted = found.get((frame, label), (0, 0))
                found[frame, label] = (points + 1, painted + (provenance == 1))
        return found

    # ── edits ──

    def commit(self, edit: Edit) -> None:
        before = self.visible(), self.held()
        self.edits.append(edit)
        same = (self.visible(), self.held()) == before
        if same and not edit.labels and not edit.tracks and not edit.boxes:
            edit.state = INERT
            tops = (self.top("marks"), self.top("deleted"))
            mine = [(edit.marks, tops[0]), (edit.deleted, tops[1])]
            owners = {top[p][1].author for points, top in mine for p in points if p in top}
            if owners - {edit.author}:
                edit.state = ACTIVE
        if edit.state == ACTIVE:
            for other in self.edits:
                if other.author == edit.author and other.state == UNDONE:
                    other.state = DROPPED

    def write(
        self,
        author: str,
        points: list[Point],
        label: int | None,
        provenance: int | None,
        deleted: bool | None,
        only: str = "any",
        living: bool | None = None,
        tracks: dict[tuple[int, int], Any] | None = None,
        hidden: frozenset[int] | None = None,
    ) -> None:
        palette = self.palette()
        if label and label not in palette:
            raise NotFoundError
        if label and palette[label]["locked"]:
            raise LockedLabelError
        barred = (
            set()
            if hidden is None
            else hidden.union(n for n, fields in palette.items() if not fields["visible"])
        )
        if label and label in barred:
            raise HiddenLabelError
        if any(n not in palette for _, n in tracks or {}):
            raise NotFoundError
        shown, raw = self.visible(), self.raw()
        edit = Edit(author, tracks=dict(tracks or {}))
        for point in points:
            now = shown.get(point, (0, 0, False))
            if now[0] and palette[now[0]]["locked"]:
                continue
            if now[0] in barred:
                continue
            if only in ("labeled", "unlabeled") and bool(now[0]) != (only == "labeled"):
                continue
            if only == "not_painted" and now[1] == 1:
                continue
            if living is not None and now[2] == living:
                continue
            mark = raw.get(point, Mark(0, 0))
            if label is not None or provenance is not None:
                edit.marks[point] = Mark(
                    mark.label if label is None else label,
                    mark.provenance if provenance is None else provenance,
                )
            if deleted is not None:
                edit.deleted[point] = deleted
        self.commit(edit)

    def create(self, author: str, name: str, label: int | None) -> int:
        number = self.highest + 1 if label is None else label
        if number in self.palette():
            raise ConflictError
        fields = {"exists": True, "name": name, "locked": False, "visible": True}
        marks = {point: Mark(0, 0) for point, mark in self.raw().items() if mark.label == number}
        gone = self._boxes_of(number)
        self.commit(Edit(author, marks=marks, labels={number: fields}, boxes=gone))
        self.highest = max(self.highest, number)
        return number

    def change(self, author: str, label: int, **fields: Any) -> None:
        palette = self.palette()
        if label not in palette:
            raise NotFoundError
        news = {k: v for k, v in fields.items() if palette[label][k] != v}
        self.commit(Edit(author, labels={label: news} if news else {}))

    def delete(self, author: str, label: int) -> None:
        palette = self.palette()
        if label not in palette:
            raise NotFoundError
        if palette[label]["locked"]:
            raise LockedLabelError
        marks = {point: Mark(0, 0) for point, mark in self.raw().items() if mark.label == label}
        gone = self._boxes_of(label)
        self.commit(Edit(author, marks=marks, labels={label: {"exists": False}}, boxes=gone))

    def _boxes_of(self, label: int) -> dict[int, None]:
        return dict.fromkeys(n for n, box in self.raw_boxes().items() if box["label"] == label)

    def add_box(self, author: str, label: int, frame: int, x: float) -> None:
        self._require_unlocked(label)
        number = max((box for edit in self.edits for box in edit.boxes), default=0) + 1
        self.commit(
            Edit(author, boxes={number: {"new": True, "label": label, "poses": {frame: x}}})
        )

    def move_box(self, author: str, box: int, frame: int, x: float) -> None:
        there = self.boxes()
        if box not in there:
            raise NotFoundError
        self._require_unlocked(there[box][0])
        moved = there[box][1].get(frame) != x
        self.commit(Edit(author, boxes={box: {"poses": {frame: x}}} if moved else {}))

    def remove_box(self, author: str, box: int) -> None:
        there = self.boxes()
        if box not in there:
            raise NotFoundError
        self._require_unlocked(there[box][0])
        self.commit(Edit(author, boxes={box: None}))

    def _require_unlocked(self, label: int) -> None:
        palette = self.palette()
        if label not in palette:
            raise NotFoundError
        if palette[label]["locked"]:
            raise LockedLabelError

    # ── undo and redo ──

    def undo(self, author: str) -> None:
        mine = [e for e in self.edits if e.author == author and e.state == ACTIVE]
        if not mine:
            raise ConflictError
        palette, boxes = self.palette(), self.raw_boxes()
        self._turn(mine[-1], UNDONE)
        self._keep_used(author, palette, self._kept_boxes(mine[-1], boxes))

    def redo(self, author: str) -> None:
        mine = [e for e in self.edits if e.author == author and e.state == UNDONE]
        if not mine:
            raise ConflictError
        self._turn(mine[0], ACTIVE)
        self._keep_used(author, {}, {})

    def _kept_boxes(
        self, edit: Edit, before: dict[int, dict[str, Any]]
    ) -> dict[int, dict[str, Any] | None]:
        """Have boxes that somebody else has changed and not removed, as they were."""
        kept: dict[int, dict[str, Any] | None] = {}
        for box in edit.boxes.keys() & before.keys() - self.raw_boxes().keys():
            others = [
                other.boxes[box]
                for other in self.edits
                if other.in_force and other.author != edit.author and box in other.boxes
            ]
            if others and others[-1] is not None:
                kept[box] = {"new": True, **before[box]}
        return kept

    def _keep_used(
        self,
        author: str,
        before: dict[int, dict[str, Any]],
        boxes: dict[int, dict[str, Any] | None],
    ) -> None:
        """Have every label that points or boxes hold, but those that somebody deleted."""
        held = {mark.label for mark in self.held().values()}
        held |= {
            box["label"] for box in (*self.raw_boxes().values(), *filter(None, boxes.values()))
        }
        kept = {n: before.get(n) or self._last_made(n) for n in held - self.palette().keys()}
        labels = {n: {**fields, "exists": True} for n, fields in kept.items() if fields}
        self.edits.append(Edit(author, KEPT, labels=labels, boxes=boxes))

    def _last_made(self, label: int) -> dict[str, Any] | None:
        told = [edit for edit in self.edits if label in edit.labels]
        made = [edit for edit in told if edit.labels[label].get("exists")][-1]
        fields: dict[str, Any] = {}
        for edit in told:
            if edit.in_force or edit is made:
                fields.update(edit.labels[label])
        return fields if fields["exists"] else None

    def _turn(self, edit: Edit, state: int) -> None:
        palette = self.palette()
        before, was = self.visible(palette), edit.state
        boxes = self.raw_boxes()
        edit.state = state
        after = self.visible(palette)
        turned = self.raw_boxes()
        kept = self._kept_boxes(edit, boxes) if state == UNDONE else {}
        for box in edit.boxes.keys() - kept.keys():
            pair_of = boxes.get(box), turned.get(box)
            mine = {each["label"] for each in pair_of if each}
            if pair_of[0] != pair_of[1] and any(
                n in palette and palette[n]["locked"] for n in mine
            ):
                edit.state = was
                raise LockedLabelError
        for point in before.keys() | after.keys():
            pair = before.get(point, (0, 0, False)), after.get(point, (0, 0, False))
            labels = {pair[0][0], pair[1][0]} - {0}
            if pair[0] != pair[1] and any(palette[n]["locked"] for n in labels):
                edit.state = was
                raise LockedLabelError


def _changed_box(old: dict[str, Any] | None, change: dict[str, Any]) -> dict[str, Any]:
    """Do a change of a box; that of one which is not there shows only if it begins anew."""
    state = {"there": False, "poses": {}} if old is None or "new" in change else old
    fields = {name: value for name, value in change.items() if name not in ("new", "poses")}
    poses = {**state["poses"], **change.get("poses", {})}
    return {**state, **fields, "poses": poses, "there": state["there"] or "new" in change}
