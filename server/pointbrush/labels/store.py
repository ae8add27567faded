"""The label store: palettes, annotations and their history, in one database."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any

from pointbrush.database import integrity
from pointbrush.database.class_names import ClassNames, read_names
from pointbrush.database.database import Database, Limits
from pointbrush.database.revisions import revisions
from pointbrush.database.schema import migrate
from pointbrush.labels import check, journal, plans, reading
from pointbrush.labels.blocks import CACHE_BYTES, BlockCache
from pointbrush.labels.boxes.editing import Boxes
from pointbrush.labels.classes import palette
from pointbrush.labels.classes.palette import Palette
from pointbrush.labels.classes.taxonomy import Taxonomy
from pointbrush.labels.draft import Changes
from pointbrush.labels.journal import Summary
from pointbrush.labels.open_recordings import OpenRecordings
from pointbrush.labels.plans import Choose, NewBoxes, Writes, new_entry
from pointbrush.labels.reading import View
from pointbrush.labels.recordings import Recordings
from pointbrush.labels.types import Commit, EditInfo, FrameValues, Label, Progress
from pointbrush.labels.versions import Moment, PastLabels, Versions
from pointbrush.labels.writer import Writer, require_import


class LabelStore:
    """All labels of a workspace; thread-safe.  Results of all methods are durable.

    Every method raises NotFoundError for an unknown sequence, frame or label, BadInputError for an
    invalid value, and UnavailableError if the disk is full or the database is unreachable; then
    nothing has changed, and a retry can succeed.
    """

    def __init__(
        self, url: str, *, cache_bytes: int = CACHE_BYTES, limits: Limits | None = None
    ) -> None:
        """Open ``sqlite:///path`` or ``postgresql://…`` and migrate its schema.

        ``cache_bytes`` bounds the memory for blocks of points.
        """
        self.database = Database(url, limits)
        try:
            migrate(self.database)
            self._open_recordings = OpenRecordings(self.database, BlockCache(cache_bytes))
        except BaseException:
            self.database.close()
            raise
        self._writer = Writer(self.database, self._open_recordings)
        self.taxonomy = Taxonomy(self.database, self._open_recordings)
        self.recordings = Recordings(self.database, self._open_recordings)
        self.boxes = Boxes(self._open_recordings, self._writer, self.taxonomy)
        self.versions = Versions(self.database)

    def seal(self) -> None:
        """Refuse edits from now on if the database is read-only; see ``Database``."""
        self.database.seal()

    def time_transactions(self, callback: Callable[[str, float], None]) -> None:
        """Set a callback for each transaction: "read" or "write", and its duration in seconds."""
        self.database.timed = callback

    def require_writable(self) -> None:
        """Raise ReadOnlyError if the database is read-only."""
        self.database.require_writable()

    def close(self) -> None:
        """Finish background work and close the connections."""
        self._open_recordings.close()
        self.database.close()

    def subscribe(self, listener: Callable[[Commit], None]) -> Callable[[], None]:
        """Call ``listener`` after every commit, in the order of the revisions, each once.

        It is called from any thread, also for commits of other processes on the same database.
        Returns a function that unsubscribes it.
        """
        unsubscribe = self._open_recordings.outbox.subscribe(listener)
        self._open_recordings.watcher.start()
        return unsubscribe

    def watch_sequences(self, listener: Callable[[str], None]) -> None:
        """Call ``listener`` with the id of each sequence that is added, deleted or replaced.

        Changes of other processes are noticed only if there is a subscriber to commits.
        """
        self._open_recordings.sequence_changed = listener

    def watch_classes(self, listener: Callable[[str], None]) -> None:
        """Call ``listener`` with the id of each open sequence after classes were renamed."""
        self._open_recordings.classes_renamed = listener

    # ── sequences ────────────────────────────────────────────────────────────────────────

    def require_import(self, sequence: str, identity: str) -> None:
        """Raise NotFoundError if the sequence was deleted, or another import has its id now."""
        with self._open_recordings.knowing(sequence) as state:
            require_import(state, identity)

    def revision(self, sequence: str) -> int:
        """Return the number of edits so far, including undos and redos."""
        with self._open_recordings.knowing(sequence) as state:
            return state.revision

    def changed(self, sequence: str, frame: int) -> int:
        """Return the revision of a frame's last change; 0: none so far."""
        with self._open_recordings.knowing(sequence) as state:
            state.frame_points(frame)
            return state.changed.get(frame, 0)

    def frame_changes(self, sequence: str) -> dict[int, int]:
        """Return the revision of the last change of each changed frame."""
        with self._open_recordings.knowing(sequence) as state:
            return dict(state.changed)

    # ── palette ──────────────────────────────────────────────────────────────────────────

    def palette(self, sequence: str) -> list[Label]:
        """Return the labels in their order."""
        with self._open_recordings.knowing(sequence) as state:
            return list(state.palette.values())

    def class_names(self) -> ClassNames:
        """Return the names of the workspace's classes."""
        with self.database.read() as connection:
            return read_names(connection)

    def label(self, sequence: str, label_id: int) -> Label:
        """Return a label; raises NotFoundError."""
        with self._open_recordings.knowing(sequence) as state:
            return palette.require(state.palette, label_id)

    def choosing(self, sequence: str) -> Palette:
        """Return the current palette, used to choose labels that an edit would add."""
        with self._open_recordings.reading(sequence) as (connection, state):
            return plans.palette_of(connection, state)

    def require_paintable(
        self, sequence: str, label: int, hidden: frozenset[int] | None = None
    ) -> None:
        """Raise NotFoundError, LockedLabelError or HiddenLabelError unless a label can be painted.

        ``hidden``: as of a Write.
        """
        self.view(sequence).require_paintable(label, hidden)

    def create_label(
        self,
        sequence: str,
        author: str,
        *,
        name: str,
        id: int | None = None,
        edit_id: str | None = None,
        distinct: bool = False,
        **fields: Any,
    ) -> Label:
        """Add a label (also ``category``, ``color``, …); raises ConflictError if ``id`` is taken.

        ``distinct``: a name or colour that another label has is replaced by a free one.
        """
        given = {"category": "", "color": None} | fields | {"name": name}
        number = None if id is None else palette.check_id(id)
        entry = new_entry(edit_id, author, "label", f"create label '{name}'")
        plan = plans.create(entry, number, palette.check_fields(given), distinct)
        commit = self._writer.commit(sequence, entry.id, plan)
        if commit.label:  # without another query, which could fail
            return commit.label
        with self._open_recordings.reading(sequence) as (connection, state):
            return palette.created_by(connection, state.number, commit.revision, state.classes)

    def update_label(
        self,
        sequence: str,
        author: str,
        label_id: int,
        *,
        edit_id: str | None = None,
        **fields: Any,
    ) -> Label:
        """Change ``name``, ``category``, ``color``, ``locked`` or ``visible``; None: no change."""
        given = palette.check_fields(fields)
        entry = new_entry(edit_id, author, "label", "change a label")
        plan = plans.change(entry, label_id, given)
        commit = self._writer.commit(sequence, entry.id, plan)
        if commit.label:  # it may be deleted from the current palette
            return commit.label
        with self._open_recordings.reading(sequence) as (connection, state):
            number, made = state.number, commit.revision
            label = palette.as_last_made(connection, number, label_id, state.classes, until=made)
        return palette.require({} if label is None else {label_id: label}, label_id)

    def arrange_labels(
        self, sequence: str, author: str, order: Sequence[int], *, edit_id: str | None = None
    ) -> Commit:
        """Reorder the palette by label ids, as one edit; the others follow.

        Raises BadInputError (a repeated id), NotFoundError.
        """
        entry = new_entry(edit_id, author, "label", "arrange labels")
        plan = plans.arrange(entry, [palette.check_id(number) for number in order])
        return self._writer.commit(sequence, entry.id, plan)

    def delete_label(
        self, sequence: str, author: str, label_id: int, *, edit_id: str | None = None
    ) -> Commit:
        """Delete a label; its points become unlabeled in the same edit.

        Raises LockedLabelError.
        """
        entry = new_entry(edit_id, author, "label", "delete a label")
        return self._writer.commit(sequence, entry.id, plans.remove(entry, label_id))

    def merge_labels(
        self,
        sequence: str,
        author: str,
        label_id: int,
        others: Sequence[int],
        *,
        edit_id: str | None = None,
    ) -> Commit:
        """Move the points of ``others`` in all frames to a label and delete them, as one edit.

        Raises LockedLabelError.
        """
        entry = new_entry(edit_id, author, "label", "merge labels")
        return self._writer.commit(sequence, entry.id, plans.merge(entry, label_id, others))

    # ── points ───────────────────────────────────────────────────────────────────────────

    def values(
        self, sequence: str, frame: int, first: int = 0, count: int | None = None
    ) -> FrameValues:
        """Return the annotation of points [first, first + count) of a frame, if they exist."""
        return self.view(sequence).values(frame, first, count)

    def view(self, sequence: str) -> View:
        """Return a view of the current labels for the many reads of a stroke."""
        with self._open_recordings.knowing(sequence):
            return View(self._open_recordings, sequence)

    def at(self, moment: Moment) -> PastLabels:
        """Return the labels of a recording as they were at a moment."""
        return PastLabels(self._open_recordings, moment)

    def begin(self, sequence: str, edit_id: str) -> Commit | View:
        """Return the commit of an existing edit, or else a view for making the edit."""
        return self._open_recordings.look_for(sequence, edit_id) or View(
            self._open_recordings, sequence
        )

    def runs(self, sequence: str, frame: int, size: int) -> Iterator[FrameValues]:
        """Yield the annotation of a whole frame in runs of ``size`` points of one revision.

        Commits wait until the last run is taken, so the caller should do little in between.
        """
        with self._open_recordings.reading(sequence) as (connection, state):
            for first in range(0, max(state.frame_points(frame), 1), size):
                yield reading.values(connection, state, frame, first, size)

    def counts(self, sequence: str) -> dict[tuple[int, int], tuple[int, int]]:
        """Return the number of points, and of painted points, by frame and label."""
        with self._open_recordings.knowing(sequence) as state:
            return reading.counts(state)

    def tracks(self, sequence: str) -> list[dict[str, Any]]:
        """Return the tracks as passed to ``apply``, by frame and label."""
        with self._open_recordings.reading(sequence) as (connection, state):
            return reading.tracks(connection, state)

    def apply(  # noqa: PLR0913 – the fields of an edit, by name
        self,
        sequence: str,
        *,
        edit_id: str | None,
        author: str,
        kind: str,
        writes: Writes | Choose,
        summary: Summary,
        tracks: Iterable[Mapping[str, Any]] | None = None,
        if_match: tuple[int, int] | None = None,
        identity: str | None = None,
        boxes: NewBoxes = (),
    ) -> Commit:
        """Commit one edit: its writes in order, its tracks, and its new boxes.

        Rules are evaluated on the state at the commit.  For an existing ``edit_id`` the first
        commit is returned, marked ``repeated``.  Each of ``tracks`` is a JSON map with at least
        ``frame`` and ``label``.  ``if_match``: a frame, and a revision since which it must not have
        changed.  ``writes`` are taken one by one while the sequence is locked, so that a generator
        can produce the writes of a frame larger than memory.  To add labels, ``writes`` is a
        function from the palette at the commit to the new labels and the writes.  ``identity``: of
        the import that the edit was made for.  ``summary`` can be a function of the numbers of
        changed points and frames.

        Raises LockedLabelError if the label to write is locked, HiddenLabelError if it is hidden
        and a write has ``hidden``, ConflictError if ``if_match`` does not hold, NotFoundError if
        another import has the id now.
        """
        entry = new_entry(edit_id, author, kind, summary)
        plan = plans.write(entry, writes, plans.check_tracks(tracks or ()), if_match, boxes)
        return self._writer.commit(sequence, entry.id, plan, identity, alone=False)

    # ── history ──────────────────────────────────────────────────────────────────────────

    def undo(
        self, sequence: str, author: str, edit_id: str | None = None, edit: str | None = None
    ) -> Commit:
        """Undo the author's last edit in force, or the one with the id ``edit``; later edits stay.

        Raises ConflictError when there is none, LockedLabelError.
        """
        entry = new_entry(edit_id, author, "undo", "undo")
        return self._writer.commit(sequence, entry.id, plans.take_back(entry, edit))

    def redo(
        self, sequence: str, author: str, edit_id: str | None = None, edit: str | None = None
    ) -> Commit:
        """Redo the edit of the author's last undo, or the one with the id ``edit``.

        Raises ConflictError when there is none, as after a new edit, LockedLabelError.
        """
        entry = new_entry(edit_id, author, "redo", "redo")
        return self._writer.commit(sequence, entry.id, plans.bring_back(entry, edit))

    def stacks(self, sequence: str, author: str) -> tuple[EditInfo | None, EditInfo | None]:
        """Return the next edits for the author's undo and redo."""
        with self._open_recordings.knowing(sequence) as state:
            return reading.stacks(self.database.look, state.number, author)

    def edits(
        self,
        sequence: str,
        *,
        before: int | None = None,
        after: int | None = None,
        limit: int = 100,
    ) -> list[EditInfo]:
        """Return at most 1,000 lines of the history below revision ``before``, newest first.

        With ``after``, return lines of later revisions, oldest first.
        """
        with self._open_recordings.reading(sequence) as (connection, state):
            return reading.history_lines(connection, state.number, before, limit, after)

    def changes(self, sequence: str) -> Iterator[tuple[EditInfo, Changes]]:
        """Yield the edits of a sequence, oldest first, with the points they changed."""
        last = 0
        while lines := self.edits(sequence, after=last, limit=reading.HISTORY_LIMIT):
            for line in lines:
                with self._open_recordings.reading(sequence) as (connection, state):
                    found = journal.changes_of(connection, state.number, line.revision)
                yield line, found
            last = lines[-1].revision

    def authors(self, sequence: str) -> set[str]:
        """Return the accounts that edited a sequence."""
        with self._open_recordings.reading(sequence) as (connection, state):
            return reading.authors(connection, state.number)

    def find(self, sequence: str, edit_id: str) -> Commit | None:
        """Return the commit of an edit by its id, marked ``repeated``, or None."""
        return self._open_recordings.look_for(sequence, edit_id)

    def since(self, sequence: str, revision: int) -> list[Commit]:
        """Return the commits after ``revision``; applied in order they give the current state.

        Raises GapError for too many commits, or a ``revision`` in the future.
        """
        with self._open_recordings.reading(sequence) as (connection, state):
            rows = reading.rows_to_resend(connection, state, revision)
            return [self._open_recordings.load(connection, state, row) for row in rows]

    # ── care ─────────────────────────────────────────────────────────────────────────────

    def sequences(self) -> dict[str, int]:
        """Return the revision of each known sequence."""
        with self.database.read() as connection:
            return {name: revision for name, (_, revision, _) in revisions(connection).items()}

    def progress(self, wanted: Collection[str] | None = None) -> dict[str, Progress]:
        """Count labelled frames and labels of ``wanted`` sequences at least; None: all."""
        with self.database.read() as connection:
            return reading.progress(connection, wanted)

    def having(self, edits: Mapping[str, str]) -> set[str]:
        """Return the sequences with the edit in their history that ``edits`` has for them."""
        with self.database.read() as connection:
            return reading.having(connection, edits)

    def require_answer(self) -> None:
        """Raise UnavailableError unless the database answers."""
        self.database.ping()

    def check(self, sequence: str) -> list[str]:
        """Return the differences of a sequence from its journal, one sentence each."""
        with self._open_recordings.reading(sequence) as (connection, state):
            return [finding.text for finding in check.check(connection, state)]

    def integrity(self) -> list[str]:
        """Return the faults of the database itself, one sentence each, after reading all of it."""
        return integrity.integrity(self.database)

    def rebuild_indexes(self) -> None:
        """Rebuild the database's indexes from its rows."""
        integrity.rebuild_indexes(self.database)

    def repair(self, sequence: str) -> tuple[list[str], list[str]]:
        """Rebuild tables that disagree with the journal; return repaired and irreparable faults.

        Stop other processes first, as they would continue with outdated state in memory.
        """
        return self._open_recordings.rebuild(sequence, check.repair)
