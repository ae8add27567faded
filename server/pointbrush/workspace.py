"""The one façade: every front (REST, socket, command line, review panel) calls it.

A workspace is a folder of imported sequences and a label database.  Indices and arrays that
leave here are in source order unless a name says ``stored``.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from pointbrush import formats
from pointbrush.errors import (
    BadInputError,
    NotFoundError,
    ReadOnlyError,
)
from pointbrush.formats.corrections import Corrections
from pointbrush.formats.datasets import DATASETS, ClassName, Dataset
from pointbrush.jobs import Job, JobRunner
from pointbrush.labels import (
    Category,
    Commit,
    EditInfo,
    FrameValues,
    Label,
    LabelStore,
    Limits,
)
from pointbrush.lazy import lazily, once
from pointbrush.permissions import ServerPaths, make_private
from pointbrush.sequences import Manifest
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences.file_cache import FileCache
from pointbrush.settings import Settings
from pointbrush.shortage import require_room
from pointbrush.work import exporting, listing, palettes, thumbnails
from pointbrush.work.annotate import accepting, copying, flooring, layers
from pointbrush.work.annotate.accepting import Judgement
from pointbrush.work.annotate.placing import Placement, placements, require_overlaid
from pointbrush.work.annotate.splitting import Split, split_label
from pointbrush.work.annotate.strokes import LiveStroke, edit_id
from pointbrush.work.backup import make_backup, require_here, restore_one
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
from pointbrush.work.imports.submitting import IMPORT, LABELS, SAMPLE, ImportRequest, Imports
from pointbrush.work.job_book import JobBook
from pointbrush.work.library import Library
from pointbrush.work.listing import Listed, Repaired
from pointbrush.work.objects import (
    Answer,
    Level,
    Objects,
    ObjectStroke,
    StaleCandidateError,
)
from pointbrush.work.palettes import NamedLabel
from pointbrush.work.tracking import TRACK

if TYPE_CHECKING:
    from pointbrush.work.imports.annotating import LabelImports
    from pointbrush.work.imports.previewing import Preview, Previews
    from pointbrush.work.reviewing import Reviewing
    from pointbrush.work.tracking.runs import Runs

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


class Workspace:
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
        self._listeners = Listeners()
        limits = Limits(settings.statement_seconds, settings.keepalive_seconds)
        self.store = LabelStore(settings.database_url, limits=limits)
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

    def close(self) -> None:
        """Cancel jobs or leave them to the next server, end worker processes and the database."""
        self._objects.close()
        if Workspace._previews.made(self):
            self._previews.close()
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

    def require_importable(self) -> None:
        """Raise ReadOnlyError where nothing can be imported: before an upload is taken in."""
        self.library.require_writable()

    @property
    def loops_compiled(self) -> bool:
        """Whether this machine has the loops of tracking and selection compiled."""
        return are_compiled()

    def expect_tracking(self) -> None:
        """Have a worker process made ready for a run, unless jobs have begun one already."""
        from pointbrush.work.tracking.job import load_default_method

        self.runner.make_ready(load_default_method)

    # ── parts whose code most commands do without ────────────────────────────────────────

    @once
    def reviewing(self) -> Reviewing:
        """States, notes and people of frames; checks, agreement and reports."""
        from pointbrush.work.reviewing import Reviewing

        return Reviewing(self.store, self.recording)

    @once
    def _previews(self) -> Previews:
        from pointbrush.work.imports.previewing import Previews

        return Previews()

    @once
    def _label_imports(self) -> LabelImports:
        from pointbrush.work.imports.annotating import LabelImports

        return LabelImports(self.store, self.runner, self.settings.max_frame_points)

    @once
    def _runs(self) -> Runs:
        from pointbrush.work.tracking.runs import Runs

        return Runs(self.store, self.runner, self._publish, self.settings.database_url)

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
        return listing.entry(self.library, self.store, sequence)

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

    def delete_sequence(self, sequence: str) -> None:
        """Delete a recording with its labels; it can be restored for 30 days.

        Raises ConflictError while somebody, on whichever server, imports or tracks it.
        """
        self._deletion.delete(sequence)
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

    def import_paths(
        self,
        paths: Sequence[Path],
        *,
        name: str | None = None,
        fps: float | None = None,
        chosen: Corrections | None = None,
        cleanup: Path | None = None,
        roots: Sequence[Path] = (),
        owner: str | None = None,
    ) -> Job:
        """Import files as one sequence in a job; ``cleanup`` is removed when it has ended.

        ``chosen`` is what a person says of the files.  With ``roots``, nothing that lies or leads
        outside them is read.  ``owner``: who asks.
        """
        absolute = tuple(path.absolute() for path in paths)
        request = ImportRequest(absolute, name, fps, chosen or Corrections(), tuple(roots), cleanup)
        return self._imports.of_paths(request, owner)

    def preview(
        self,
        paths: Sequence[Path],
        *,
        name: str | None = None,
        fps: float | None = None,
        chosen: Corrections | None = None,
        roots: Sequence[Path] = (),
    ) -> Preview:
        """Say what ``import_paths`` would do; nothing is written.  Raises what readers raise."""
        from pointbrush.work.imports.previewing import PreviewRequest

        limits = formats.Limits(self.settings.max_frame_points, roots=tuple(roots))
        absolute = tuple(path.absolute() for path in paths)
        return self._previews.of(
            PreviewRequest(absolute, chosen or Corrections(), limits, name, fps)
        )

    def import_labels(
        self,
        sequence: str,
        place: Path,
        author: str,
        *,
        label_format: str | None = None,
        names: Mapping[int, ClassName] | None = None,
        dry_run: bool = False,
        no_ground: bool = False,
        field: str | None = None,
        roots: Sequence[Path] = (),
        cleanup: Path | None = None,
    ) -> Job:
        """Import labels made elsewhere as one edit, in a job whose result reports what was found.

        ``names`` are class names by number; ``dry_run`` writes nothing; ``no_ground`` leaves the
        ground out of boxes; ``field`` names the field of points that is labels; ``cleanup`` is
        removed when the job has ended.  Raises NotFoundError.
        """
        from pointbrush.work.imports.annotating import LabelRequest

        request = LabelRequest(
            place.absolute(),
            label_format,
            dict(names or {}),
            dry_run,
            no_ground,
            field,
            tuple(roots),
            cleanup,
        )
        return self._label_imports.start(self.recording(sequence), request, author)

    def import_sample(self, *, frames: int = 90, seed: int = 0) -> Job:
        """Make the sample recording and import it, with a palette for its objects."""
        return self._imports.of_sample(frames, seed)

    def import_roots(self, *, own: bool) -> list[Path]:
        """Folders that a caller over the network may import from.

        ``own``: where none are named, the current folder and the home folder; the caller is who
        started the server, on this machine.
        """
        return self.settings.roots or (self.settings.own_roots if own else [])

    # ── points and annotations ───────────────────────────────────────────────────────────

    def points(
        self, sequence: str, frame: int, names: Collection[str] = exporting.SENT
    ) -> Iterator[dict[str, NDArray[Any]]]:
        """Columns of a frame as in its file, source order and coordinates: consecutive blocks."""
        return exporting.source_columns(self.recording(sequence), frame, names)

    def values(
        self, sequence: str, frame: int, first: int = 0, count: int | None = None
    ) -> FrameValues:
        """Annotation values of points [first, first + count), in stored order."""
        self.recording(sequence)[frame]
        return self.store.values(sequence, frame, first, count)

    def annotation(
        self, sequence: str, frame: int, layer: str = "label"
    ) -> tuple[NDArray[Any], int]:
        """A layer of a frame's annotation (N,), and the revision of the frame's last change."""
        blocks, revision = self.annotation_blocks(sequence, frame, layer)
        return np.concatenate(list(blocks)), revision

    def annotation_blocks(
        self, sequence: str, frame: int, layer: str = "label"
    ) -> tuple[Iterator[NDArray[Any]], int]:
        """The same in consecutive blocks, of which an octree's frame has many."""
        return exporting.layer_blocks(self.store, self.recording(sequence), frame, layer)

    def put_annotation(
        self,
        sequence: str,
        frame: int,
        array: NDArray[Any],
        *,
        author: str,
        layer: str = "label",
        if_match: int | None = None,
        edit: str | None = None,
    ) -> Commit:
        """Replace a layer of a frame's annotation, as one edit.

        ``if_match``: a revision since which the frame must not have changed.
        Raises BadInputError (shape, dtype, unknown labels), LockedLabelError, ConflictError.
        """
        writes = layers.replacement(self.store, self.recording(sequence), frame, layer, array)
        return self.store.apply(
            sequence,
            edit_id=edit_id(edit),
            author=author,
            kind="import",
            writes=writes,
            summary=f"annotation of frame {frame}",
            if_match=None if if_match is None else (frame, if_match),
            identity=self.recording(sequence).identity,
        )

    def changed(self, sequence: str, frame: int, commit: Commit) -> int:
        """The revision of a frame's last change as of ``commit``."""
        if frame in commit.frames:
            return commit.revision
        # What others did since must not look as if it had been seen.
        return min(commit.revision, self.store.changed(sequence, frame))

    # ── palette ──────────────────────────────────────────────────────────────────────────

    def palette(self, sequence: str) -> list[Label]:
        """The sequence's labels."""
        self.recording(sequence)
        return self.store.palette(sequence)

    def label(self, sequence: str, label_id: int) -> Label:
        """One label; raises NotFoundError."""
        for label in self.palette(sequence):
            if label.id == label_id:
                return label
        raise NotFoundError(f"label: expected the id of a label, got {label_id}")

    def create_label(self, sequence: str, author: str, **fields: Any) -> Label:
        """Add a label: ``name``; optional ``category``, ``color``, ``id``, ``locked``, ``visible``.

        ``distinct``: a name or colour that another label has gives way to a free one.

        Here and below, ``edit_id`` makes a call that is sent twice count once.
        """
        self.recording(sequence)
        return self.store.create_label(sequence, author, **fields)[0]

    def add_labels(self, sequence: str, labels: Sequence[NamedLabel], author: str) -> list[str]:
        """Add those of ``labels`` that are not there, as one edit; returns their names."""
        self.recording(sequence)
        return palettes.add_labels(self.store, sequence, labels, author)

    def add_template(self, sequence: str, dataset: Dataset, author: str) -> list[str]:
        """Add a label for each class of a dataset; returns the names of new ones."""
        self.recording(sequence)
        return palettes.add_template(self.store, sequence, dataset, author)

    def update_label(self, sequence: str, author: str, label_id: int, **fields: Any) -> Label:
        """Change ``name``, ``category``, ``color``, ``locked`` or ``visible``."""
        self.recording(sequence)
        return self.store.update_label(sequence, author, label_id, **fields)[0]

    def arrange_labels(
        self, sequence: str, author: str, order: Sequence[int], *, edit_id: str | None = None
    ) -> Commit:
        """Put the palette in an order of label ids, as one edit; the others follow."""
        self.recording(sequence)
        return self.store.arrange_labels(sequence, author, order, edit_id=edit_id)

    def delete_label(
        self, sequence: str, author: str, label_id: int, *, edit_id: str | None = None
    ) -> Commit:
        """Remove a label; its points become unlabeled in the same edit."""
        self.recording(sequence)
        return self.store.delete_label(sequence, author, label_id, edit_id=edit_id)

    def merge_labels(
        self,
        sequence: str,
        author: str,
        label_id: int,
        others: Sequence[int],
        *,
        edit_id: str | None = None,
    ) -> Commit:
        """Give the points of ``others`` to a label and remove them, as one edit."""
        self.recording(sequence)
        return self.store.merge_labels(sequence, author, label_id, others, edit_id=edit_id)

    def split_label(
        self,
        sequence: str,
        author: str,
        label_id: int,
        frame: int,
        *,
        edit: str | None = None,
        **how: Any,
    ) -> Split:
        """Give each connected part of a label in a frame a label of its own: ``split_label``."""
        recording = self.recording(sequence)
        return split_label(self.store, recording, frame, label_id, author, edit_id(edit), **how)

    # ── edits ────────────────────────────────────────────────────────────────────────────

    def begin_stroke(
        self, sequence: str, frame: int, brush: Mapping[str, Any], stroke_id: str | None = None
    ) -> LiveStroke | ObjectStroke | Commit:
        """Start a stroke that is still being drawn; see LiveStroke.

        One that is sent again after its answer was lost has been applied: that is its commit.
        """
        given = edit_id(stroke_id)
        begun = self.store.begin(sequence, given)
        if isinstance(begun, Commit):
            return begun
        recording = self.recording(sequence)
        if brush.get("shape") == "object":
            return ObjectStroke(self._objects, self.store, recording, frame, brush, given)
        return LiveStroke(self.store, begun, recording, frame, brush, given)

    def placements(
        self, sequence: str, frame: int, before: int, after: int
    ) -> tuple[list[Placement], NDArray[np.float64]]:
        """Return the placements of frames over ``frame``, and the recording's shift (3,) metres.

        Of ``before`` frames before it and ``after`` after it, as far as there are so many.
        """
        recording = self.recording(sequence)
        _ = recording[frame]
        frames = range(max(0, frame - before), min(len(recording), frame + after + 1))
        require_overlaid(recording, frame, frames)
        shift = np.asarray(recording.manifest.shift, np.float64)
        return placements(self.store, recording, frame, frames), shift

    def stroke(self, sequence: str, frame: int, fields: Mapping[str, Any], author: str) -> Commit:
        """Apply a whole stroke (the fields of REST's); durable when this returns."""
        live = self.begin_stroke(sequence, frame, fields, fields.get("id"))
        if isinstance(live, Commit):
            return live
        live.add(fields.get("samples") or [])
        return live.commit(author)

    def ask(self, sequence: str, frame: int, fields: Mapping[str, Any]) -> Answer:
        """Return what a stroke would take: levels of an object, or a region of another shape.

        ``fields`` are those of a stroke, with ``positives`` for its samples.
        Raises BadInputError, NotFoundError.
        """
        recording = self.recording(sequence)
        if fields.get("shape", "object") == "object":
            return self._objects.answer(recording, frame, self._objects.parse(fields))
        view = self.store.view(sequence)
        live = LiveStroke(self.store, view, recording, frame, fields, edit_id(None))
        live.add(fields.get("positives") or [])
        numbers = live.previewed()
        levels = (Level("", 0, 1.0, numbers),) if len(numbers) else ()
        return Answer(levels, 0, ready=True)

    def undo(self, sequence: str, author: str, edit: str | None = None) -> Commit:
        """Take back this author's last edit; raises ConflictError when there is none."""
        self.recording(sequence)
        return self.store.undo(sequence, author, edit_id(edit))

    def redo(self, sequence: str, author: str, edit: str | None = None) -> Commit:
        """Bring back what this author's last undo took; raises ConflictError."""
        self.recording(sequence)
        return self.store.redo(sequence, author, edit_id(edit))

    def edits(self, sequence: str, before: int | None = None, limit: int = 100) -> list[EditInfo]:
        """The history, newest first."""
        self.recording(sequence)
        found = self.store.edits(sequence, before=before, limit=limit)
        return [replace(edit, author=self.store.accounts.name(edit.author)) for edit in found]

    # ── tracking ─────────────────────────────────────────────────────────────────────────

    def track(
        self,
        sequence: str,
        *,
        start: int,
        stop: int,
        author: str,
        labels: Sequence[int] | None = None,
        method: str = "auto",
        overwrite: str = "tracked",
        continue_lost: bool = False,
        until_painted: bool = False,
        stop_unsure: bool = False,
        edit: str | None = None,
    ) -> Job:
        """Carry labels from frame ``start`` to ``stop`` (included; either way), in a job.

        A label ends at its first lost frame unless ``continue_lost``, and at the next frame where
        it is painted with ``until_painted``.  ``stop_unsure`` ends the run at the first frame that
        a person should look at.
        """
        from pointbrush.tracking import TrackOptions
        from pointbrush.work.tracking.runs import TrackRequest

        options = TrackOptions(
            overwrite=overwrite,  # type: ignore[arg-type]  # checked by `start`
            continue_lost=continue_lost,
            until_painted=until_painted,
        )
        request = TrackRequest(start, stop, labels, method, options, stop_unsure)
        return self._runs.start(self.recording(sequence), request, author, edit_id(edit))

    def accept(
        self,
        sequence: str,
        frame: int,
        labels: Sequence[int],
        author: str,
        edit: str | None = None,
    ) -> Commit:
        """Make what tracking found of ``labels`` in a frame count as painted; see ``accept``."""
        self.recording(sequence)
        judged = Judgement(sequence, [frame], labels, author, edit_id(edit))
        return accepting.accept(self.store, judged)

    def copy_labels(
        self,
        sequence: str,
        frame: int,
        source: int,
        labels: Sequence[int],
        author: str,
        edit: str | None = None,
    ) -> Commit:
        """Label points of ``frame`` as points at their place in ``source``; see ``copy_labels``."""
        recording = self.recording(sequence)
        return copying.copy_labels(
            self.store, recording, frame, source, labels, author, edit_id(edit)
        )

    def clear_labels(
        self,
        sequence: str,
        frames: Sequence[int],
        labels: Sequence[int],
        author: str,
        edit: str | None = None,
    ) -> Commit:
        """Take labels from all of their points in frames, painted ones too, as one edit."""
        recording = self.recording(sequence)
        return copying.clear_labels(self.store, recording, frames, labels, author, edit_id(edit))

    def accept_range(
        self,
        sequence: str,
        frames: Sequence[int],
        labels: Sequence[int],
        author: str,
        edit: str | None = None,
    ) -> Commit:
        """Do the same in several frames, as one edit; see ``accept``."""
        return self._judged(accepting.accept, sequence, frames, labels, author, edit)

    def clear_range(
        self,
        sequence: str,
        frames: Sequence[int],
        labels: Sequence[int],
        author: str,
        edit: str | None = None,
    ) -> Commit:
        """Take back what tracking found in frames and vouch for its not being there; one edit."""
        return self._judged(accepting.clear, sequence, frames, labels, author, edit)

    def reject_range(
        self, sequence: str, frames: Sequence[int], labels: Sequence[int], author: str
    ) -> Commit:
        """Take back what tracking found of ``labels`` in frames, as one edit."""
        return self._judged(accepting.reject, sequence, frames, labels, author)

    def _judged(
        self,
        judge: Callable[[LabelStore, Judgement], Commit],
        sequence: str,
        frames: Sequence[int],
        labels: Sequence[int],
        author: str,
        edit: str | None = None,
    ) -> Commit:
        recording = self.recording(sequence)
        for frame in frames:
            _ = recording[frame]
        return judge(self.store, Judgement(sequence, frames, labels, author, edit_id(edit)))

    def tracks(self, sequence: str) -> list[dict[str, Any]]:
        """Pose, confidence and state of every tracked label in every frame."""
        self.recording(sequence)
        return self.store.tracks(sequence)

    # ── export and jobs ──────────────────────────────────────────────────────────────────

    def export(
        self, sequence: str, export_format: str, out: Path | BinaryIO, frames: str | None = None
    ) -> None:
        """Write frames ``I:J`` with their labels; a folder or file at a Path, zip to a stream.

        Raises BadInputError for an unknown format or range, DamagedError for a damaged frame: at a
        Path nothing is left then, a stream has not begun, or goes on and names the gap.
        """
        recording = self.recording(sequence)
        if export_format not in formats.EXPORTS:
            known = ", ".join(sorted(formats.EXPORTS))
            raise BadInputError(f"format: expected one of {known}, got {export_format!r}")
        chosen = exporting.parse_frames(frames, len(recording))
        exporting.require_whole(recording, chosen)
        gaps: list[str] | None = None if isinstance(out, Path) else []
        labeled = exporting.labeled_frames(self.store, recording, chosen, gaps)
        palette = self.store.palette(sequence)
        numbers = self.store.taxonomy.numbers(formats.category_names(palette))
        datasets = {name: self.store.taxonomy.known_as(name) for name in DATASETS}
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
        return listing.problems_of(self.library, self.store, sequence)

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
