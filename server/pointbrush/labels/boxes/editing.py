"""Reading and changing the boxes of a recording; each change is one edit of the journal."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from pointbrush.errors import ConflictError, NotFoundError
from pointbrush.geometry.oriented_box import OrientedBox
from pointbrush.labels.boxes import journal as box_journal
from pointbrush.labels.boxes.attributes import check_given
from pointbrush.labels.boxes.maps import box_of, change_of, fields_of
from pointbrush.labels.classes.taxonomy import Taxonomy
from pointbrush.labels.draft import Draft
from pointbrush.labels.journal import Entry
from pointbrush.labels.open_recordings import OpenRecordings
from pointbrush.labels.plans import SUMMARY_LIMIT, new_entry
from pointbrush.labels.types import Commit
from pointbrush.labels.writer import Writer


@dataclass(frozen=True, slots=True)
class BoxList:
    """Boxes ordered by id, and the revision of the recording."""

    boxes: tuple[OrientedBox, ...]
    revision: int


@dataclass(frozen=True, slots=True)
class Made:
    """A box after an edit, and the edit's commit."""

    box: OrientedBox
    commit: Commit


@dataclass(frozen=True, slots=True)
class BoxEdit:
    """Changes of an edit: boxes to set (id 0: a new box), and ids of boxes to remove."""

    put: Sequence[OrientedBox] = ()
    removed: Collection[int] = ()


Choose = Callable[[Mapping[int, OrientedBox]], BoxEdit]
"""Chooses changes from the current boxes by id when the edit commits."""


class Boxes:
    """Boxes of all recordings of a store; thread-safe.

    Every method raises NotFoundError for an unknown sequence, box, label or frame, BadInputError
    for invalid values, LockedLabelError for boxes of locked labels, and UnavailableError.
    """

    def __init__(self, open_recordings: OpenRecordings, writer: Writer, taxonomy: Taxonomy) -> None:
        """``taxonomy`` defines the attributes that requests may set."""
        self._open_recordings, self._writer, self._taxonomy = open_recordings, writer, taxonomy

    def listing(
        self,
        sequence: str,
        *,
        ids: Collection[int] | None = None,
        frame: int | None = None,
        label: int | None = None,
    ) -> BoxList:
        """Return all boxes, or only boxes of some ids, with a pose in ``frame``, or of a label."""
        with self._open_recordings.reading(sequence) as (connection, state):
            if frame is not None:
                state.frame_points(frame)
            found = box_journal.stored(
                connection, state.number, ids=ids, labels=None if label is None else [label]
            )
            known, revision = set(state.palette), state.revision
        boxes = box_journal.read_boxes(found, known)
        return BoxList(tuple(box for box in boxes if frame is None or frame in box.poses), revision)

    def get(self, sequence: str, box: int) -> OrientedBox:
        """Read one box."""
        found = self.listing(sequence, ids=[box]).boxes
        if not found:
            raise _unknown(box)
        return found[0]

    def add(
        self, sequence: str, author: str, box: OrientedBox, *, edit_id: str | None = None
    ) -> Made:
        """Add a box with the recording's next free id; its own ``id`` is ignored."""
        self._check(box.attributes, [pose.attributes for pose in box.poses.values()])

        def draw(draft: Draft) -> str:
            box_journal.put(draft, [replace(box, id=0)])
            return f"add a box of '{draft.palette[box.label].name}'"

        return self._made(sequence, author, draw, edit_id)

    def change(
        self,
        sequence: str,
        author: str,
        box: int,
        change: Mapping[str, Any],
        *,
        edit_id: str | None = None,
    ) -> Made:
        """Change ``size``, ``label``, ``attributes`` or ``poses``; see ``maps.change_of``."""
        poses = [pose for pose in change.get("poses", {}).values() if pose is not None]
        attributes = [pose.get("attributes", {}) for pose in poses]
        self._check(change.get("attributes", {}), attributes)
        apply = change_of(change)

        def draw(draft: Draft) -> str:
            old = _require(draft, box)
            box_journal.put(draft, [box_of(box, apply(fields_of(old)))])
            return f"change a box of '{draft.palette[old.label].name}'"

        return self._made(sequence, author, draw, edit_id, box)

    def remove(self, sequence: str, author: str, box: int, *, edit_id: str | None = None) -> Commit:
        """Remove a box."""

        def draw(draft: Draft) -> str:
            old = _require(draft, box)
            box_journal.put(draft, (), [box])
            return f"remove a box of '{draft.palette[old.label].name}'"

        return self._commit(sequence, author, draw, edit_id)

    def apply(
        self,
        sequence: str,
        author: str,
        choose: Choose,
        *,
        summary: str,
        edit_id: str | None = None,
        identity: str | None = None,
        kind: str = "box",
    ) -> Commit:
        """Change many boxes as one edit, chosen from the boxes at its commit.

        Attributes need not be defined, as imported files may have other attributes.
        ``commit.boxes`` has the ids of the changed boxes.  ``identity``: the import that the edit
        was made for.
        """

        def draw(draft: Draft) -> str:
            found = box_journal.stored(draft.connection, draft.state.number)
            now = {box.id: box for box in box_journal.read_boxes(found, draft.palette)}
            chosen = choose(now)
            unknown = [one for one in (*chosen.removed, *(b.id for b in chosen.put)) if one]
            for number in unknown:
                if number not in now:
                    raise _unknown(number)
            box_journal.put(draft, chosen.put, chosen.removed)
            return summary

        return self._commit(sequence, author, draw, edit_id, kind=kind, identity=identity)

    def _check(self, track: Mapping[str, Any], frames: Sequence[Mapping[str, Any]]) -> None:
        """Check the attributes of a box and of its poses against the taxonomy."""
        if track or any(frames):
            known = self._taxonomy.attributes()
            check_given(known, track, "track")
            for given in frames:
                check_given(known, given, "frame")

    def _commit(
        self,
        sequence: str,
        author: str,
        draw: Callable[[Draft], str],
        edit_id: str | None,
        *,
        kind: str = "box",
        identity: str | None = None,
    ) -> Commit:
        """Commit the changes that ``draw`` makes to a draft, with the summary that it returns."""
        entry = new_entry(edit_id, author, kind, "")

        def plan(draft: Draft) -> Entry:
            return replace(entry, summary=draw(draft)[:SUMMARY_LIMIT])

        return self._writer.commit(sequence, entry.id, plan, identity)

    def _made(
        self,
        sequence: str,
        author: str,
        draw: Callable[[Draft], str],
        edit_id: str | None,
        box: int | None = None,
    ) -> Made:
        """Commit a change of one box and return the box after the edit, also when it is retried."""
        commit = self._commit(sequence, author, draw, edit_id)
        ids = commit.boxes if box is None else [box]
        with self._open_recordings.reading(sequence) as (connection, state):
            folded = box_journal.fold(connection, state.number, ids, last=commit.revision)
        for number, fields in folded.items():
            if fields is not None:
                return Made(box_of(number, fields), commit)
        raise ConflictError(f"edit: expected a new id, {commit.edit} is another edit's")


def _require(draft: Draft, box: int) -> OrientedBox:
    """Read the box of an edit; raises NotFoundError."""
    found = box_journal.stored(draft.connection, draft.state.number, ids=[box])
    boxes = box_journal.read_boxes(found, draft.palette)
    if not boxes:
        raise _unknown(box)
    return boxes[0]


def _unknown(box: int) -> NotFoundError:
    return NotFoundError(f"box: expected the id of a box, got {box}")
