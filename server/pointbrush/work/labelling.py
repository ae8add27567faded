"""Palettes, annotations, edits and tracking of recordings: the part of the façade that labels."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import NotFoundError
from pointbrush.formats.datasets import Dataset
from pointbrush.jobs import Job, JobRunner
from pointbrush.labels import Commit, EditInfo, FrameValues, Label, LabelStore
from pointbrush.lazy import once
from pointbrush.sequences import Sequence as Recording
from pointbrush.settings import Settings
from pointbrush.work import exporting, palettes
from pointbrush.work.annotate import accepting, copying, layers
from pointbrush.work.annotate.accepting import Judgement
from pointbrush.work.annotate.overlays import Placement, placements, require_overlaid
from pointbrush.work.annotate.splitting import Split, split_label
from pointbrush.work.annotate.strokes import LiveStroke, edit_id
from pointbrush.work.events import Event
from pointbrush.work.job_book import JobBook
from pointbrush.work.objects import Answer, Level, Objects, ObjectStroke
from pointbrush.work.palettes import NamedLabel
from pointbrush.work.tracking.options import RunOptions

if TYPE_CHECKING:
    from pointbrush.work.tracking.runs import Runs


class Labelling(ABC):
    """Work on the labels of a workspace, which ``Workspace`` is the whole of; thread-safe.

    Indices and arrays that leave here are in source order unless a name says ``stored``.
    """

    settings: Settings
    store: LabelStore
    runner: JobRunner
    _objects: Objects
    _job_book: JobBook

    @abstractmethod
    def recording(self, sequence: str) -> Recording:
        """The stored recording; raises NotFoundError, DamagedError."""

    @abstractmethod
    def _publish(self, event: Event) -> None: ...

    @once
    def _runs(self) -> Runs:
        from pointbrush.work.tracking.runs import Runs

        return Runs(self.store, self.runner, self._publish, self.settings.database_url)

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
        """Preview a stroke: levels of an object, or a region of another shape.

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
        edit: str | None = None,
        **chosen: Any,
    ) -> Job:
        """Carry labels from frame ``start`` to ``stop`` (included; either way), in a job.

        ``chosen``: fields of ``RunOptions``.  ``edit``: the id of its edit and of its job; of a
        run that ``author`` has begun before, that job is returned.
        """
        from pointbrush.work.tracking.runs import TrackRequest

        request = TrackRequest(start, stop, labels, RunOptions(**chosen))
        begin = partial(self._runs.start, self.recording(sequence), request, author)
        return self._job_book.begin_once(edit, author, begin)

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
