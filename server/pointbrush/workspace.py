"""The façade of the server: REST, socket, command line and review panel call its parts.

A workspace is a folder of imported sequences and a label database.  Returned indices and arrays are
in source order unless a name contains ``stored``.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from pointbrush import formats
from pointbrush.database.database import Limits
from pointbrush.errors import BadInputError, ReadOnlyError
from pointbrush.jobs.runner import JobRunner
from pointbrush.lazy import once
from pointbrush.names import is_plain
from pointbrush.sequences import Manifest
from pointbrush.sequences.storage.file_cache import FileCache
from pointbrush.settings import Settings
from pointbrush.system.permissions import ServerPaths, make_private
from pointbrush.system.resources import require_room
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.work import exporting, thumbnails
from pointbrush.work.annotate import flooring
from pointbrush.work.annotate.accepting import Verdicts
from pointbrush.work.annotate.copying import Copying
from pointbrush.work.annotate.splitting import Splitting
from pointbrush.work.annotations import Annotations
from pointbrush.work.backups.backup import (
    CLASSIFIERS,
    STUDIES,
    make_backup,
    note_made,
    require_labels,
    require_noted_database,
    restore_one,
)
from pointbrush.work.boxes import FIT
from pointbrush.work.boxes.painting import BoxPainting
from pointbrush.work.classifiers import PREDICT
from pointbrush.work.deletion import Deletion
from pointbrush.work.events import ClassesRenamed, Event, Listeners, SequencesChanged
from pointbrush.work.folder_store import FolderStore, make_folder
from pointbrush.work.imports.requests import IMPORT, LABELS, SAMPLE
from pointbrush.work.imports.submitting import Imports
from pointbrush.work.job_registry import Begin, JobRegistry
from pointbrush.work.job_service import JobContext
from pointbrush.work.library import Library, SequenceStore
from pointbrush.work.listing import Listing, Repaired
from pointbrush.work.loops.running import Loops
from pointbrush.work.objects.service import Objects
from pointbrush.work.people import FIND
from pointbrush.work.sensors import ALIGN
from pointbrush.work.stroking import Strokes
from pointbrush.work.tracking import TRACK

if TYPE_CHECKING:
    from pointbrush.teamwork.delivering import Hooks
    from pointbrush.work.boxes.fitting_job import Fitting
    from pointbrush.work.classifiers.applying import Predictions
    from pointbrush.work.classifiers.service import Classifiers
    from pointbrush.work.masks.service import Masks
    from pointbrush.work.people.service import People
    from pointbrush.work.projects.agreeing import Agreeing
    from pointbrush.work.projects.queue import Queue
    from pointbrush.work.projects.service import Projects
    from pointbrush.work.projects.versions import Versions
    from pointbrush.work.reviewing.reviewing import Reviewing
    from pointbrush.work.scratch import Scratch
    from pointbrush.work.sensors.aligning import Aligning
    from pointbrush.work.studies.service import Studies
    from pointbrush.work.tracking.runs import Runs


class Workspace:
    """A folder of recordings and their labels, with services in its parts; thread-safe.

    ``library`` has the recordings, ``labels`` their palettes, annotations and history; ``imports``,
    ``tracking``, ``reviewing``, ``strokes`` and the others work on both.
    """

    def __init__(self, settings: Settings) -> None:
        """Open (or create) the workspace folder and its database.

        Raises BadInputError if the folder cannot be used, UnavailableError without database.
        """
        self.settings = settings
        self.paths = ServerPaths(settings.workspace, *settings.roots)
        require_noted_database(settings.workspace, settings.database_url)
        self.library = Library(_store_of(settings))
        self.library.clean()
        make_private(settings.workspace)
        self._require_labels()
        self._listeners = Listeners()
        publish, self.recording = self._listeners.notify, self.library.recording
        limits = Limits(settings.statement_seconds, settings.keepalive_seconds)
        self.labels = WorkspaceStore(settings.database_url, limits=limits)
        note_made(settings.workspace, settings.database_url)
        self._unsubscribe = self.labels.subscribe(publish)
        self.runner = JobRunner(
            publish,
            workers=settings.workers,
            scheduler=settings.scheduler,
            public=self.paths.hide,
        )
        self.imports: Imports
        begin: dict[str, Begin] = {
            IMPORT: lambda job: self.imports.files.restart(job),
            SAMPLE: lambda job: self.imports.samples.restart(job),
            LABELS: lambda job: self.imports.labels.restart(job),
            TRACK: lambda job: self.tracking.restart(job),
            PREDICT: lambda job: self.predictions.restart(job),
            FIT: lambda job: self.fitting.restart(job),
            FIND: lambda job: self.people.restart(job),
            ALIGN: lambda job: self.aligning.restart(job),
        }
        self.jobs = JobRegistry(
            self.labels,
            self.runner,
            publish,
            begin,
            lambda job_id: self.tracking.keep(job_id),
            self.paths.hide,
        )
        self._job_context = JobContext(
            self.library, self.labels, self.runner, self.jobs, publish, settings.database_url,
            settings.max_frame_points,
        )  # fmt: skip
        self.imports = Imports(self._job_context)
        self.deletion = Deletion(self.library, self.labels, publish)
        self.listing = Listing(self.library, self.labels, self.imports, self.deletion)
        self.loops = Loops(publish)
        self._objects = Objects(
            self.labels,
            self._object_folder,
            settings.selector,
            publish,
            lambda: self.loops.ensure("objects"),
        )
        self.strokes = Strokes(self.labels, self.recording, self._objects)
        self.annotations = Annotations(self.labels, self.recording)
        self.verdicts = Verdicts(self.labels, self.recording)
        self.copying = Copying(self.labels, self.recording)
        self.splitting = Splitting(self.labels, self.recording)
        self.boxes = BoxPainting(self.labels, self.recording)
        self.deletion.tidy()
        if not self.read_only:
            self.library.store.clear_remains(self.labels.guards.importing)
        self.imports.complete(self.library.manifests())
        self.labels.seal()
        self.labels.watch_sequences(self._changed_elsewhere)
        self.labels.watch_classes(lambda sequence: publish(ClassesRenamed(sequence)))

    def _require_labels(self) -> None:
        settings, recordings = self.settings, len(self.library.store.ids())
        require_labels(
            settings.workspace, settings.database_url, recordings, anew=settings.new_labels
        )

    def close(self) -> None:
        """Cancel or release jobs, end worker processes and close the database."""
        if Workspace.hooks.made(self):
            self.hooks.close()
        self.loops.close()
        self._objects.close()
        self.imports.close()
        self.runner.close()
        self.jobs.close()
        self._unsubscribe()
        self.labels.close()

    def keep_jobs(self) -> None:
        """Store jobs, so that they outlive this process, and restart jobs of ended servers."""
        if not self.read_only:
            self.jobs.open()
            self.hooks.open()

    @property
    def read_only(self) -> str:
        """Return a sentence about read-only parts; empty if all parts are writable."""
        found = []
        for part in (self.library, self.labels):
            try:
                part.require_writable()
            except ReadOnlyError as error:
                found.append(str(error))
        return "; ".join(found)

    @once
    def tracking(self) -> Runs:
        """Return the service for tracking runs."""
        from pointbrush.work.tracking.runs import Runs

        return Runs(self._job_context)

    @once
    def classifiers(self) -> Classifiers:
        """Return the service for classifiers trained on examples."""
        from pointbrush.classify.models import Models
        from pointbrush.work.classifiers.service import Classifiers

        models = Models.parse(self.settings.models)
        folder, listed = self._classifier_folder, self.library.listed_ids
        return Classifiers(self.labels, folder, self.recording, listed, models=models)

    @once
    def predictions(self) -> Predictions:
        """Return the service that applies classifiers."""
        from pointbrush.work.classifiers.applying import Predictions

        return Predictions(self._job_context, self.classifiers)

    @once
    def people(self) -> People:
        """Return the service that finds people in pictures."""
        from pointbrush.work.people.service import People

        return People(self._job_context)

    @once
    def aligning(self) -> Aligning:
        """Return the service that aligns the sensors of a recording."""
        from pointbrush.work.sensors.aligning import Aligning

        return Aligning(self._job_context)

    @property
    def _object_folder(self) -> Path:
        return self.settings.workspace.absolute() / "objects"

    @property
    def _classifier_folder(self) -> Path:
        return self.settings.workspace.absolute() / CLASSIFIERS

    @once
    def masks(self) -> Masks:
        """Return the service for masks of pictures."""
        from pointbrush.masks.models import MaskModels
        from pointbrush.work.masks.service import Masks

        return Masks(self.labels, self.recording, MaskModels.parse(self.settings.mask_models))

    @once
    def fitting(self) -> Fitting:
        """Return the service for fits of boxes to labels."""
        from pointbrush.work.boxes.fitting_job import Fitting

        return Fitting(self._job_context)

    @once
    def projects(self) -> Projects:
        """Return the service for projects."""
        from pointbrush.work.projects.service import Projects

        return Projects(self.labels, self._listeners.notify)

    @once
    def versions(self) -> Versions:
        """Return the service for named versions of the labels of projects."""
        from pointbrush.work.projects.versions import Versions

        return Versions(self.labels)

    @once
    def agreeing(self) -> Agreeing:
        """Return the service for the comparison of copies that several people label."""
        from pointbrush.work.projects.agreeing import Agreeing

        return Agreeing(self.labels, self.library)

    @once
    def queue(self) -> Queue:
        """Return the service for tasks of projects."""
        from pointbrush.work.projects.copies import make_copy
        from pointbrush.work.projects.queue import Queue

        return Queue(self.labels, self.recording, partial(make_copy, self.labels, self.library))

    @once
    def scratch(self) -> Scratch:
        """Return the service for the recording of headset checks."""
        from pointbrush.work.scratch import Scratch

        return Scratch(self.labels, self.library)

    @once
    def studies(self) -> Studies:
        """Return the service for studies of labelling."""
        from pointbrush.work.studies.service import Studies

        folder = self.settings.workspace.absolute() / STUDIES
        return Studies(self.labels, self.library, folder, self._erase)

    def _erase(self, sequence: str) -> None:
        """Remove a recording with its labels and prepared frames for ever."""
        known = self.deletion.erase(sequence)
        if known.identity and is_plain(known.identity):
            shutil.rmtree(self._object_folder / known.identity, ignore_errors=True)

    @once
    def hooks(self) -> Hooks:
        """Return the service for webhooks of projects."""
        from pointbrush.teamwork.delivering import Hooks

        return Hooks(self.labels.team.webhooks, private=self.settings.webhook_private)

    @once
    def reviewing(self) -> Reviewing:
        """Return the service for reviews, checks, agreement and reports."""
        from pointbrush.work.reviewing.reviewing import Reviewing

        return Reviewing(self.labels, self.recording)

    def subscribe(self, listener: Callable[[Event], None]) -> Callable[[], None]:
        """Call ``listener`` at every event, from any thread; return a function that removes it."""
        return self._listeners.add(listener)

    def _changed_elsewhere(self, sequence: str) -> None:
        """Update after another process has added, deleted or restored a recording."""
        self.library.store.forget(sequence)
        self.deletion.tidy()
        self._listeners.notify(SequencesChanged(sequence))

    def thumbnail(self, sequence: str, frame: int) -> bytes:
        """Return a small picture of a frame, JPEG; raises NotFoundError, DamagedError."""
        recording = self.recording(sequence)
        return thumbnails.thumbnail(recording[frame], recording.manifest.T_room_local)

    def update_sequence(self, sequence: str, **fields: Any) -> Manifest:
        """Change ``name``, ``fps``, ``room`` or ``corrections`` of mounts of a recording.

        See ``sequences.storage.manifest.changed_manifest``.
        """
        manifest = self.library.update(sequence, **fields)
        self._listeners.notify(SequencesChanged(sequence))
        return manifest

    def stand_on_floor(
        self, sequence: str, frame: int, samples: Sequence[Mapping[str, Any]]
    ) -> Manifest:
        """Place a recording on the surface hit by rays; see ``flooring.room_on_floor``."""
        recording = self.recording(sequence)
        room = flooring.room_on_floor(self.labels, recording, frame, samples)
        return self.update_sequence(sequence, room=room)

    def reset_floor(self, sequence: str) -> Manifest:
        """Reset the orientation of a recording to the result of its import."""
        found = self.recording(sequence).manifest.T_found_room_local
        return self.update_sequence(sequence, room=found)

    def export(  # noqa: PLR0913 – the choices of an export, by name
        self,
        sequence: str,
        export_format: str,
        out: Path | BinaryIO,
        frames: str | None = None,
        val: str | None = None,
        above: float = 0.0,
        snapshot: str | None = None,
        sensor: str | None = None,
    ) -> None:
        """Export frames ``I:J`` with their labels to a folder or file, or as a zip to a stream.

        ``val``: frames for validation, see ``exporting.choose_split``; ``above``: minimum
        confidence of predicted labels, 0 to 1; ``snapshot``: export the labels of this version of
        the project; ``sensor``: only the points of this one of several sensors, in its coordinates.
        Raises BadInputError for an unknown format, range or sensor, DamagedError for a damaged
        frame.  After an error a Path does not exist; a stream has not started, or continues
        and names the gap.
        """
        recording = self.recording(sequence)
        if export_format not in formats.EXPORTS:
            known = ", ".join(sorted(formats.EXPORTS))
            raise BadInputError(f"format: expected one of {known}, got {export_format!r}")
        if sensor is not None:
            exporting.require_sensor(recording, sensor)
        split = exporting.choose_split(export_format, val, recording, self.library.listed_ids)
        chosen = exporting.parse_frames(frames, len(recording))
        exporting.require_whole(recording, chosen)
        gaps: list[str] | None = None if isinstance(out, Path) else []
        kept = self.labels if snapshot is None else self.versions.labels(sequence, snapshot)
        labeled = exporting.labeled_frames(kept, recording, chosen, gaps, above)
        labeled = exporting.split_frames(labeled, split)
        if formats.EXPORTS[export_format].whole_boxes:
            from pointbrush.work.boxes.exporting import boxed_frames  # imports readers

            labeled = boxed_frames(labeled, kept, recording)
        if formats.EXPORTS[export_format].pictures:
            from pointbrush.work.masks.exporting import masked_frames  # imports readers

            labeled = masked_frames(labeled, recording, chosen, sensor)
        if sensor is not None:
            labeled = formats.sensor_frames(labeled, sensor)
        palette = kept.palette(sequence)
        numbering = formats.EXPORTS[export_format].numbering
        numbers = self.labels.taxonomy.exported(palette, numbering)
        formats.export(export_format, labeled, palette, out, gaps, *numbers)

    def check_files(self, *, repair: bool = False) -> Repaired:
        """Return damaged classifiers and prepared frames; ``repair`` removes the latter."""
        classifiers: list[str] = []
        if self._classifier_folder.is_dir():  # slow to import
            from pointbrush.work.classifiers.files import ClassifierFiles

            classifiers = ClassifierFiles(self._classifier_folder).problems()
        removed, left = self._objects.problems(repair=repair)
        return Repaired(removed, [*classifiers, *left])

    def import_roots(self, *, own: bool) -> tuple[Path, ...]:
        """Return the folders from which a caller over the network may import.

        ``own``: the caller started the server on this machine; without configured folders they may
        then import from the current folder and the home folder.
        """
        return tuple(self.settings.roots or (self.settings.own_roots if own else []))

    def ready_checks(self) -> dict[str, Callable[[], None]]:
        """Return a check of each required part, which raises UnavailableError."""
        return {
            "database": self.labels.require_answer,
            "disk": lambda: require_room(self.library.folder),
            "sequences": self.library.store.require_answer,
            "scheduler": self.runner.require_scheduler,
        }

    def back_up(self, target: Path, earlier: Path | None = None) -> None:
        """Back up the workspace to the new folder ``target``; see ``backup.make_backup``."""
        make_backup(self.labels, self.library, target, self.settings.workspace, earlier)

    def restore_from_backup(self, source: Path, sequence: str) -> str:
        """Restore one recording of a backup, even while in use; return its id here."""
        restored = restore_one(self.labels, self.library, source, sequence)
        self._listeners.notify(SequencesChanged(restored))
        return restored


def _store_of(settings: Settings) -> SequenceStore:
    """Return the store of a workspace's recordings."""
    if not settings.sequences:
        return FolderStore(settings.workspace.absolute() / "sequences")
    make_folder("workspace", settings.workspace)
    from pointbrush.sequences.storage.bucket import Bucket
    from pointbrush.work.bucket_store import BucketStore

    cache = FileCache(settings.cache_folder, settings.sequence_cache_bytes)
    return BucketStore(Bucket(settings.sequences, cache))
