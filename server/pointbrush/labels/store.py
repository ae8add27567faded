"""The label store: palettes, annotations and their history, in one database."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any

from pointbrush.labels import check, integrity, palette, plans, reading
from pointbrush.labels.accounts import Accounts, SignIns, Tokens
from pointbrush.labels.blocks import CACHE_BYTES, BlockCache
from pointbrush.labels.boxes import Boxes
from pointbrush.labels.class_names import ClassNames, read_names
from pointbrush.labels.database import Database, Limits
from pointbrush.labels.guards import Guards
from pointbrush.labels.headset_reports import HeadsetReports
from pointbrush.labels.job_records import JobRecords
from pointbrush.labels.journal import Told
from pointbrush.labels.own_keys import OwnKeys
from pointbrush.labels.palette import Palette
from pointbrush.labels.people import People
from pointbrush.labels.plans import Choose, NewBoxes, Writes, new_entry
from pointbrush.labels.reading import View
from pointbrush.labels.recordings import Recordings
from pointbrush.labels.reviews import Reviews
from pointbrush.labels.schema import migrate
from pointbrush.labels.sessions import Sessions
from pointbrush.labels.signing_keys import SigningKeys
from pointbrush.labels.state import revisions
from pointbrush.labels.taxonomy import Taxonomy
from pointbrush.labels.team import Team
from pointbrush.labels.types import Commit, EditInfo, FrameValues, Label, Progress
from pointbrush.labels.writer import Writer, require_import


class LabelStore:
    """All labels of a workspace; thread-safe.  Whatever it answers is on the disk.

    Every method raises NotFoundError for an unknown sequence, frame or label, BadInputError for
    a value that cannot be, and UnavailableError when the disk is full or the database away: then
    nothing has changed, and trying again can work.
    """

    def __init__(
        self, url: str, *, cache_bytes: int = CACHE_BYTES, limits: Limits | None = None
    ) -> None:
        """Open ``sqlite:///path`` or ``postgresql://…`` and bring its schema up to date.

        ``cache_bytes`` bounds the memory for blocks of points.
        """
        self.database = Database(url, limits)
        try:
            migrate(self.database)
            self._sessions = Sessions(self.database, BlockCache(cache_bytes))
        except BaseException:
            self.database.close()
            raise
        self._writer = Writer(self.database, self._sessions)
        self.tokens = Tokens(self.database)
        self.people = People(self.tokens)
        self.accounts = Accounts(self.database)
        self.sign_ins = SignIns(self.database)
        self.signing_keys = SigningKeys(self.database)
        self.own_keys = OwnKeys(self.database)
        self.headset_reports = HeadsetReports(self.database)
        self.taxonomy = Taxonomy(self.database, self._sessions)
        self.recordings = Recordings(self.database, self._sessions)
        self.reviews = Reviews(self.database)
        self.boxes = Boxes(self._sessions, self._writer, self.taxonomy)
        self.team = Team(self.database, self._sessions)
        self.guards = Guards(self.database)
        self.jobs = JobRecords(self.database, self.guards.owner)

    def seal(self) -> None:
        """Refuse edits from now on, where the database may not be written: see ``Database``."""
        self.database.seal()

    def time_transactions(self, told: Callable[[str, float], None]) -> None:
        """Tell each transaction's kind, "read" or "write", and the seconds that it took."""
        self.database.timed = told

    def require_writable(self) -> None:
        """Raise ReadOnlyError where no edit can be made."""
        self.database.require_writable()

    def close(self) -> None:
        """Finish background work and close the connections."""
        self.guards.close()
        self._sessions.close()
        self.database.close()

    def subscribe(self, listener: Callable[[Commit], None]) -> Callable[[], None]:
        """Call ``listener`` after every commit, in the order of the revisions, each once.

        It is called from any thread, also for commits of other processes on the same database.
        Returns what undoes it.
        """
        unsubscribe = self._sessions.outbox.subscribe(listener)
        self._sessions.watcher.start()
        return unsubscribe

    def watch_sequences(self, listener: Callable[[str], None]) -> None:
        """Call ``listener`` with the id of each sequence that came, went or became another.

        It is told of other processes' changes, as far as somebody has subscribed to commits.
        """
        self._sessions.came_or_went = listener

    def watch_classes(self, listener: Callable[[str], None]) -> None:
        """Call ``listener`` with the id of each open sequence after classes were renamed."""
        self._sessions.classes_renamed = listener

    # ── sequences ────────────────────────────────────────────────────────────────────────

    def require_import(self, sequence: str, identity: str) -> None:
        """Raise NotFoundError when the sequence has gone, or another import has its id by now."""
        with self._sessions.knowing(sequence) as state:
            require_import(state, identity)

    def revision(self, sequence: str) -> int:
        """The number of edits so far, undos and redos among them."""
        with self._sessions.knowing(sequence) as state:
            return state.revision

    def changed(self, sequence: str, frame: int) -> int:
        """The revision of a frame's last change; 0: none so far."""
        with self._sessions.knowing(sequence) as state:
            state.frame_points(frame)
            return state.changed.get(frame, 0)

    def frame_changes(self, sequence: str) -> dict[int, int]:
        """For each frame that was ever changed, the revision of its last change."""
        with self._sessions.knowing(sequence) as state:
            return dict(state.changed)

    # ── palette ──────────────────────────────────────────────────────────────────────────

    def palette(self, sequence: str) -> list[Label]:
        """The labels, in their order."""
        with self._sessions.knowing(sequence) as state:
            return list(state.palette.values())

    def class_names(self) -> ClassNames:
        """Return the names of the workspace's classes."""
        with self.database.read() as connection:
            return read_names(connection)

    def label(self, sequence: str, label_id: int) -> Label:
        """One label; raises NotFoundError."""
        with self._sessions.knowing(sequence) as state:
            return palette.require(state.palette, label_id)

    def choosing(self, sequence: str) -> Palette:
        """Return the palette of now, for saying what labels an edit would add."""
        with self._sessions.reading(sequence) as (connection, state):
            return plans.palette_of(connection, state)

    def require_paintable(
        self, sequence: str, label: int, hidden: frozenset[int] | None = None
    ) -> None:
        """Raise NotFoundError, LockedLabelError or HiddenLabelError unless it may be painted with.

        ``hidden``: as of a Write.
        """
        self.view(sequence).require_paintable(label, hidden)

    def create_label(
        self,
        sequence: str,
        author: str,
        *,
        name: str,
        category: str = "",
        color: str | None = None,
        id: int | None = None,
        edit_id: str | None = None,
        distinct: bool = False,
        **fields: Any,
    ) -> Label:
        """Add a label (also ``locked``, ``visible``); ConflictError when ``id`` is taken.

        ``distinct``: a name or colour that another label has gives way to a free one.
        """
        given = fields | {"name": name, "category": category, "color": color}
        number = None if id is None else palette.check_id(id)
        entry = new_entry(edit_id, author, "label", f"create label '{name}'")
        plan = plans.create(entry, number, palette.check_fields(given), distinct)
        commit = self._writer.commit(sequence, entry.id, plan)
        if commit.label:  # without another look at a database that may have gone away meanwhile
            return commit.label
        with self._sessions.reading(sequence) as (connection, state):
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
        """Change ``name``, ``category``, ``color``, ``locked`` or ``visible``; None keeps."""
        given = palette.check_fields(fields)
        entry = new_entry(edit_id, author, "label", "change a label")
        plan = plans.change(entry, label_id, given)
        commit = self._writer.commit(sequence, entry.id, plan)
        if commit.label:  # and not the palette of now, from which it may be gone already
            return commit.label
        with self._sessions.reading(sequence) as (connection, state):
            number, made = state.number, commit.revision
            label = palette.as_last_made(connection, number, label_id, state.classes, until=made)
        return palette.require({} if label is None else {label_id: label}, label_id)

    def arrange_labels(
        self, sequence: str, author: str, order: Sequence[int], *, edit_id: str | None = None
    ) -> Commit:
        """Put the palette in an order of label ids, as one edit; the others follow.

        Raises BadInputError (an id twice), NotFoundError.
        """
        entry = new_entry(edit_id, author, "label", "arrange labels")
        plan = plans.arrange(entry, [palette.check_id(number) for number in order])
        return self._writer.commit(sequence, entry.id, plan)

    def delete_label(
        self, sequence: str, author: str, label_id: int, *, edit_id: str | None = None
    ) -> Commit:
        """Remove a label; its points become unlabeled in the same edit.

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
        """Give the points of ``others`` in all frames to a label and remove them, as one edit.

        Raises LockedLabelError.
        """
        entry = new_entry(edit_id, author, "label", "merge labels")
        return self._writer.commit(sequence, entry.id, plans.merge(entry, label_id, others))

    # ── points ───────────────────────────────────────────────────────────────────────────

    def values(
        self, sequence: str, frame: int, first: int = 0, count: int | None = None
    ) -> FrameValues:
        """Annotation of points [first, first + count) of a frame, as far as it has them."""
        return self.view(sequence).values(frame, first, count)

    def view(self, sequence: str) -> View:
        """Return a view of the labels as of now, which a stroke asks again and again."""
        with self._sessions.knowing(sequence):
            return View(self._sessions, sequence)

    def begin(self, sequence: str, edit_id: str) -> Commit | View:
        """The commit of an edit that is there already, or else a view for making it."""
        return self._sessions.look_for(sequence, edit_id) or View(self._sessions, sequence)

    def runs(self, sequence: str, frame: int, size: int) -> Iterator[FrameValues]:
        """Annotation of a whole frame in runs of ``size`` points, all of one revision.

        Nobody can commit before the last one is taken: do little in between.
        """
        with self._sessions.reading(sequence) as (connection, state):
            for first in range(0, max(state.frame_points(frame), 1), size):
                yield reading.values(connection, state, frame, first, size)

    def counts(self, sequence: str) -> dict[tuple[int, int], tuple[int, int]]:
        """For each frame and label that has any: points, and painted ones among them."""
        with self._sessions.knowing(sequence) as state:
            return reading.counts(state)

    def tracks(self, sequence: str) -> list[dict[str, Any]]:
        """The tracks as they were given to ``apply``, by frame and label."""
        with self._sessions.reading(sequence) as (connection, state):
            return reading.tracks(connection, state)

    def apply(
        self,
        sequence: str,
        *,
        edit_id: str | None,
        author: str,
        kind: str,
        writes: Writes | Choose,
        summary: Told,
        tracks: Iterable[Mapping[str, Any]] | None = None,
        if_match: tuple[int, int] | None = None,
        identity: str | None = None,
        boxes: NewBoxes = (),
    ) -> Commit:
        """Commit one edit: its writes in order, its tracks, and its new boxes.

        Rules are evaluated on the state that the edit commits on.  An ``edit_id`` that is there
        already gives its first commit again, ``repeated``.  Each of ``tracks`` is a JSON map
        with at least ``frame`` and ``label``.  ``if_match``: a frame, and a revision since
        which it must not have changed.
        ``writes`` are taken one by one while the sequence is locked: those of a frame larger than
        memory come as they are made.  Writes with labels that are new come from a function of the
        palette that the edit commits on, which gives these labels beside them.
        ``identity``: of the import that the edit was made for.
        ``summary`` may be made of the numbers of points and of frames that the edit changes.

        Raises LockedLabelError when the label to write is locked, HiddenLabelError when it is
        hidden and that matters to a write, ConflictError when ``if_match`` does not hold,
        NotFoundError when another import has the id by now.
        """
        entry = new_entry(edit_id, author, kind, summary)
        plan = plans.write(entry, writes, plans.check_tracks(tracks or ()), if_match, boxes)
        return self._writer.commit(sequence, entry.id, plan, identity, alone=False)

    # ── history ──────────────────────────────────────────────────────────────────────────

    def undo(self, sequence: str, author: str, edit_id: str | None = None) -> Commit:
        """Take back the author's last edit that is in force, as if it had never been.

        Raises ConflictError when there is none, LockedLabelError.
        """
        entry = new_entry(edit_id, author, "undo", "undo")
        return self._writer.commit(sequence, entry.id, plans.take_back(entry))

    def redo(self, sequence: str, author: str, edit_id: str | None = None) -> Commit:
        """Put the edit of the author's last undo back where it was; a new edit ends that.

        Raises ConflictError when there is none, LockedLabelError.
        """
        entry = new_entry(edit_id, author, "redo", "redo")
        return self._writer.commit(sequence, entry.id, plans.bring_back(entry))

    def stacks(self, sequence: str, author: str) -> tuple[EditInfo | None, EditInfo | None]:
        """Return the edits that the author's undo, and redo, would take."""
        with self._sessions.knowing(sequence) as state:
            return reading.stacks(self.database.look, state.number, author)

    def edits(
        self,
        sequence: str,
        *,
        before: int | None = None,
        after: int | None = None,
        limit: int = 100,
    ) -> list[EditInfo]:
        """The history, newest first, from below revision ``before``; at most 1,000 lines.

        With ``after`` the lines of later revisions than that, oldest first.
        """
        with self._sessions.reading(sequence) as (connection, state):
            return reading.history_lines(connection, state.number, before, limit, after)

    def authors(self, sequence: str) -> set[str]:
        """The accounts that edited a sequence."""
        with self._sessions.reading(sequence) as (connection, state):
            return reading.authors(connection, state.number)

    def find(self, sequence: str, edit_id: str) -> Commit | None:
        """The commit of an edit by its id, ``repeated``, or None."""
        return self._sessions.look_for(sequence, edit_id)

    def since(self, sequence: str, revision: int) -> list[Commit]:
        """The commits after ``revision``; applying them in order gives the state of now.

        Raises GapError when there are too many, or ``revision`` lies in the future.
        """
        with self._sessions.reading(sequence) as (connection, state):
            rows = reading.rows_to_resend(connection, state, revision)
            return [self._sessions.load(connection, state, row) for row in rows]

    # ── care ─────────────────────────────────────────────────────────────────────────────

    def sequences(self) -> dict[str, int]:
        """Every sequence that is known, and its revision."""
        with self.database.read() as connection:
            return {name: revision for name, (_, revision, _) in revisions(connection).items()}

    def progress(self, wanted: Collection[str] | None = None) -> dict[str, Progress]:
        """Count what is labelled of ``wanted`` sequences at least, None: of all with labels."""
        with self.database.read() as connection:
            return reading.progress(connection, wanted)

    def having(self, edits: Mapping[str, str]) -> set[str]:
        """Sequences whose history has the edit whose id ``edits`` gives for them."""
        with self.database.read() as connection:
            return reading.having(connection, edits)

    def require_answer(self) -> None:
        """Raise UnavailableError unless the database answers."""
        self.database.ping()

    def check(self, sequence: str) -> list[str]:
        """List the places of a sequence that disagree with its journal, one sentence each."""
        with self._sessions.reading(sequence) as (connection, state):
            return [finding.text for finding in check.check(connection, state)]

    def integrity(self) -> list[str]:
        """List faults of the database itself, one sentence each; all of it is read."""
        return integrity.integrity(self.database)

    def rebuild_indexes(self) -> None:
        """Make the database's indexes anew from its rows."""
        integrity.rebuild_indexes(self.database)

    def repair(self, sequence: str) -> tuple[list[str], list[str]]:
        """Make anew what disagrees with the journal: what was wrong, and what cannot be mended.

        Other processes that have the sequence open go on with what they know: stop them first.
        """
        return self._sessions.rebuild(sequence, check.repair)
