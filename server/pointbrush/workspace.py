"""The one façade: every front (REST, socket, command line, review panel) calls it.

A workspace is a folder of imported sequences and a label database.  Indices and arrays that
leave here are in source order unless a name says ``stored``.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from pointbrush import formats
from pointbrush.errors import (
    BadInputError,
    ReadOnlyError,
)
from pointbrush.formats.datasets import DATASETS
from pointbrush.jobs import Job, JobRunner
from pointbrush.labels import (
    Category,
    LabelStore,
    Limits,
)
from pointbrush.lazy import lazily, once
from pointbrush.permissions import ServerPaths, make_private
from pointbrush.sequences import Manifest
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences.file_cache import FileCache
from pointbrush.settings import Settings
from pointbrush.system import require_room
from pointbrush.work import exporting, listing, thumbnails
from pointbrush.work.annotate import flooring
from pointbrush.work.annotate.overlays import Placement
from pointbrush.work.annotate.splitting import Split
from pointbrush.work.backup import (
    make_backup,
    note_made,
    require_here,
    require_labels,
    restore_one,
)
from pointbrush.work.compiling import are_compiled
from pointbrush.work.deletion import Deleted, Deletion
from pointbrush.work.events import (
    Event,
    Listeners,
    Prepared,
    Provisional,
    Retracted,
    SequencesChanged,
)
from pointbrush.work.folder_store import FolderStore, SequenceStore, make_folder
from pointbrush.work.imports.front import Importing
from pointbrush.work.imports.submitting import IMPORT, LABELS, SAMPLE, Imports
from pointbrush.work.job_book import JobBook
from pointbrush.work.labelling import Labelling
from pointbrush.work.library import Library
from pointbrush.work.listing import Listed, Repaired
from pointbrush.work.objects import (
    Answer,
    Objects,
    StaleCandidateError,
)
from pointbrush.work.palettes import NamedLabel
from pointbrush.work.tracking import TRACK

if TYPE_CHECKING:
    from pointbrush.work.imports.previewing import Preview
    from pointbrush.work.reviewing import Reviewing

__all__ = [
    "Answer",
    "Deleted",
    "Event",
    "Listed",
    "NamedLabel",
    "Placement",
    "Prepared",
    "Preview",
    "Provisional",
    "Retracted",
    "SequencesChanged",
    "Split",
    "StaleCandidateError",
    "Workspace",
]
if not TYPE_CHECKING:
    __getattr__ = lazily(__name__, {"Preview": "pointbrush.work.imports.previewing"})


class Workspace(Importing, Labelling):
    """A folder of recordings and their labels; thread-safe."""

    def __init__(self, settings: Settings) -> None:
        """Open (or make) the workspace folder and its database.

        Raises BadInputError when the folder cannot be used, UnavailableError without database.
        """
        self.settings = settings
        self.paths = ServerPaths(settings.workspace, *settings.roots)
        require_here(settings.workspace, settings.database_url)
        self.library = Library(_store_of(settings))
        self.library.clean()
        make_private(settings.workspace)
        self._require_labels()
        self._listeners = Listeners()
        limits = Limits(settings.statement_seconds, settings.keepalive_seconds)
        self.store = LabelStore(settings.database_url, limits=limits)
        note_made(settings.workspace, settings.database_url)
        self._unsubscribe = self.store.subscribe(self._publish)
        self.runner = JobRunner(
            self._publish,
            workers=settings.workers,
            scheduler=settings.scheduler,
            public=self.paths.hide,
        )
        self._imports = Imports(
            self.library, self.store, self.runner, self._publish, settings.max_frame_points
        )
        self._objects = Objects(
            self.store, settings.workspace.absolute() / "objects", settings.selector, self._publish
        )
        begin = {
            IMPORT: self._imports.again,
            SAMPLE: self._imports.again,
            LABELS: lambda job: self._label_imports.again(self._recording_of(job), job),
            TRACK: lambda job: self._runs.again(self._recording_of(job), job),
        }
        self._job_book = JobBook(
            self.store,
            self.runner,
            self._publish,
            begin,
            lambda job: self._runs.keep(job),
            self.paths.hide,
        )
        self._deletion = Deletion(self.library, self.store)
        self._deletion.tidy()
        if not self.read_only:
            self.library.store.clear_remains(self.store.guards.importing)
        self._imports.complete(self.sequences())
        self.store.seal()
        self.store.watch_sequences(self._changed_elsewhere)

    def _require_labels(self) -> None:
        settings, recordings = self.settings, len(self.library.store.ids())
        require_labels(
            settings.workspace, settings.database_url, recordings, anew=settings.new_labels
        )

    def close(self) -> None:
        """Cancel jobs or leave them to the next server, end worker processes and the database."""
        self._objects.close()
        self.end_previews()
        self.runner.close()
        self._job_book.close()
        self._unsubscribe()
        self.store.close()

    def keep_jobs(self) -> None:
        """Let jobs outlive this process: see those of all servers, begin again what one left."""
        if not self.read_only:
            self._job_book.open()

    @property
    def read_only(self) -> str:
        """Sentence on what cannot be changed here; empty where everything can."""
        found = []
        for part in (self.library, self.store):
            try:
                part.require_writable()
            except ReadOnlyError as error:
                found.append(str(error))
        return "; ".join(found)

    @property
    def loops_compiled(self) -> bool:
        """Whether this machine has the loops of tracking and selection compiled."""
        return are_compiled()

    def expect_tracking(self) -> None:
        """Have a worker process made ready for a run, unless jobs have begun one already."""
        from pointbrush.work.tracking.job import load_default_method

        self.runner.make_ready(load_default_method)

    @once
    def reviewing(self) -> Reviewing:
        """States, notes and people of frames; checks, agreement and reports."""
        from pointbrush.work.reviewing import Reviewing

        return Reviewing(self.store, self.recording)

    def subscribe(self, listener: Callable[[Event], None]) -> Callable[[], None]:
        """Call ``listener`` at every event, from any thread; returns what undoes it."""
        return self._listeners.add(listener)

    def _publish(self, event: Event) -> None:
        self._listeners.tell(event)

    def _changed_elsewhere(self, sequence: str) -> None:
        """Another process added, deleted or restored a recording."""
        self.library.store.forget(sequence)
        self._deletion.tidy()
        self._publish(SequencesChanged(sequence))

    # ── sequences ────────────────────────────────────────────────────────────────────────

    def sequences(self) -> list[Manifest]:
        """Manifests of the recordings that can be opened, by name."""
        return self.library.manifests()

    def listing(self) -> list[Listed]:
        """All recordings by name, and what is wrong with those that are damaged."""
        return listing.recordings(self.library, self.store, self._imports, self._deletion)

    def entry(self, sequence: str) -> Listed:
        """One of them, damaged or not; raises NotFoundError."""
        return listing.entry(self.library, self.store, self._imports, sequence)

    def recording(self, sequence: str) -> Recording:
        """The stored recording; raises NotFoundError, DamagedError."""
        return self.library.recording(sequence)

    def thumbnail(self, sequence: str, frame: int) -> bytes:
        """A small picture of a frame, JPEG; raises NotFoundError, DamagedError."""
        recording = self.recording(sequence)
        return thumbnails.thumbnail(recording[frame], recording.manifest.T_room_local)

    def update_sequence(self, sequence: str, **fields: Any) -> Manifest:
        """Change ``name``, ``fps`` or ``room`` (4x4 T_room_local) of a recording."""
        manifest = self.library.update(sequence, **fields)
        self._publish(SequencesChanged(sequence))
        return manifest

    def stand_on_floor(
        self, sequence: str, frame: int, samples: Sequence[Mapping[str, Any]]
    ) -> Manifest:
        """Stand a recording on the surface that rays point at; see ``flooring.room_on_floor``."""
        recording = self.recording(sequence)
        room = flooring.room_on_floor(self.store, recording, frame, samples)
        return self.update_sequence(sequence, room=room)

    def reset_floor(self, sequence: str) -> Manifest:
        """Stand a recording as the import found it."""
        found = self.recording(sequence).manifest.T_found_room_local
        return self.update_sequence(sequence, room=found)

    def delete_sequence(self, sequence: str, identity: str | None = None) -> None:
        """Delete a recording with its labels; it can be restored for 30 days.

        ``identity``: of the recording that is meant; nothing is done when it is deleted already.
        Raises ConflictError while somebody, on whichever server, imports or tracks it.
        """
        self._deletion.delete(sequence, identity)
        self._publish(SequencesChanged(sequence))

    def deleted_sequences(self) -> list[Deleted]:
        """Deleted recordings that can be restored, the last one deleted first."""
        return self._deletion.deleted()

    def restore_sequence(self, key: str) -> str:
        """Bring a deleted recording back, by its id or its import's identity; returns its id.

        It is another one when its own is taken meanwhile.  Raises NotFoundError.
        """
        sequence = self._deletion.restore(key)
        self._publish(SequencesChanged(sequence))
        return sequence

    # ── export and jobs ──────────────────────────────────────────────────────────────────

    def export(
        self,
        sequence: str,
        export_format: str,
        out: Path | BinaryIO,
        frames: str | None = None,
        val: str | None = None,
    ) -> None:
        """Write frames ``I:J`` with their labels; a folder or file at a Path, zip to a stream.

        ``val``: frames for validation in a format for training, as ``exporting.choose_split``.
        Raises BadInputError for an unknown format or range, DamagedError for a damaged frame: at a
        Path nothing is left then, a stream has not begun, or goes on and names the gap.
        """
        recording = self.recording(sequence)
        if export_format not in formats.EXPORTS:
            known = ", ".join(sorted(formats.EXPORTS))
            raise BadInputError(f"format: expected one of {known}, got {export_format!r}")
        split = exporting.choose_split(export_format, val, recording, self.library.ids)
        chosen = exporting.parse_frames(frames, len(recording))
        exporting.require_whole(recording, chosen)
        gaps: list[str] | None = None if isinstance(out, Path) else []
        labeled = exporting.labeled_frames(self.store, recording, chosen, gaps)
        labeled = exporting.split_frames(labeled, split)
        palette = self.store.palette(sequence)
        names = formats.category_names(palette)
        numbers = self.store.taxonomy.numbers(names)
        datasets = {name: self.store.taxonomy.known_as(name) for name in DATASETS}
        if (numbering := formats.EXPORTS[export_format].numbering) is not None:
            given = self.store.taxonomy.numbers_in(numbering, names)
            datasets[numbering.name] = datasets.get(numbering.name, {}) | given
        formats.export(export_format, labeled, palette, out, gaps, numbers, datasets)

    def categories(self) -> list[Category]:
        """The classes of the workspace: each has one number in all recordings."""
        return self.store.taxonomy.entries()

    def put_categories(self, wanted: Sequence[Category]) -> list[Category]:
        """Add classes, or change names and colours; see ``Taxonomy.put``."""
        return self.store.taxonomy.put(wanted)

    def jobs(self) -> list[Job]:
        """All remembered jobs, of all servers, newest first."""
        return self._job_book.jobs()

    def job(self, job_id: str) -> Job:
        """One job; raises NotFoundError."""
        return self._job_book.job(job_id)

    def cancel(self, job_id: str, *, keep: bool = False) -> Job:
        """Stop a job; ``keep`` commits what a tracking run has found so far."""
        return self._job_book.cancel(job_id, keep=keep)

    def uploads_in_use(self) -> set[Path]:
        """Return folders of uploaded files that jobs of all servers need; UnavailableError."""
        return self._job_book.uploads()

    def _recording_of(self, job: Job) -> Recording:
        return self.recording(job.sequence or "")

    # ── upkeep ───────────────────────────────────────────────────────────────────────────

    def check(self, sequence: str) -> list[str]:
        """List faults of a recording's files, its journal or its annotations; [] if sound."""
        return listing.problems_of(self.library, self.store, self._imports, sequence)

    def check_database(self) -> list[str]:
        """List faults of the label database itself; [] if all of it can be read."""
        return self.store.integrity()

    def repair(self, sequences: Collection[str]) -> Repaired:
        """Make anew what can be of what is wrong; see ``listing.repair``."""
        return listing.repair(self.library, self.store, sequences)

    def ready_checks(self) -> dict[str, Callable[[], None]]:
        """Return a check of each part that work needs; it raises UnavailableError."""
        return {
            "database": self.store.require_answer,
            "disk": lambda: require_room(self.library.folder),
            "sequences": self.library.store.require_answer,
            "scheduler": self.runner.require_scheduler,
        }

    def restore_from_backup(self, source: Path, sequence: str) -> str:
        """Bring one recording of a backup back, also while in use; returns its id here."""
        restored = restore_one(self.store, self.library, source, sequence)
        self._publish(SequencesChanged(restored))
        return restored

    def backup(self, target: Path) -> None:
        """Copy the whole workspace into the new folder ``target``, also while it is in use."""
        make_backup(self.store, self.library, target)


def _store_of(settings: Settings) -> SequenceStore:
    """Open where the recordings of a workspace are kept."""
    if not settings.sequences:
        return FolderStore(settings.workspace.absolute() / "sequences")
    make_folder("workspace", settings.workspace)
    from pointbrush.sequences.bucket import Bucket
    from pointbrush.work.bucket_store import BucketStore

    cache = FileCache(settings.cache_folder, settings.sequence_cache_bytes)
    return BucketStore(Bucket(settings.sequences, cache))
