"""A recording on a server: its labels, edits, tracking and exports."""

from __future__ import annotations

import json
import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike
from typing_extensions import Unpack

from pointbrush.client.answers import html_table, layer_of, npz_of, read, tuple_of
from pointbrush.client.boxes import Boxes
from pointbrush.client.classifiers import ByExample
from pointbrush.client.frame import Frames
from pointbrush.client.review import Review
from pointbrush.client.steps import PATIENCE, L, Part, Request, Steps, T, finished, started, steps
from pointbrush.client.uploads import AnyPath, Files, LabelKeywords, upload
from pointbrush.client.watching import Watch
from pointbrush.errors import NotFoundError
from pointbrush.values.base import Body
from pointbrush.values.boxes import BoxFit, FittedBoxes
from pointbrush.values.edits import Edit, PastEdit
from pointbrush.values.imports import ImportedLabels
from pointbrush.values.jobs import Job
from pointbrush.values.labels import (
    AddedLabels,
    Label,
    LabelPatch,
    Merge,
    NewLabel,
    OfferedCategories,
)
from pointbrush.values.people import FoundPeople, LabelledPeople, PeopleSearch
from pointbrush.values.recordings import Manifest, RecordingPatch
from pointbrush.values.runs import Overwrite, Stretch, TrackingRequest
from pointbrush.values.sensors import AlignedSensors, SensorAlignment
from pointbrush.values.tracking import Run, Track


class Recording(Part[L]):
    """A recording with its ``id``, ``name`` and ``manifest`` as of the call that returned it.

    Its parts are ``frames``, ``boxes``, ``review`` and ``by_example``.
    """

    def __init__(self, link: L, manifest: Manifest) -> None:
        super().__init__(link, f"/sequences/{manifest.id}")
        self.manifest = manifest
        self.id, self.name = manifest.id, manifest.name
        self.frames: Frames[L] = Frames(link, self.id, manifest.frames)
        self.review: Review[L] = Review(link, self._place)
        self.boxes: Boxes[L] = Boxes(link, f"{self._place}/boxes")
        self.by_example: ByExample[L] = ByExample(link, self._place)

    def __repr__(self) -> str:
        return f"Recording({self.id!r}, {len(self.frames)} frames)"

    def _repr_html_(self) -> str:
        """Return a table of the recording for a notebook."""
        known = self.manifest
        facts = {
            "id": known.id,
            "frames": f"{known.frames:,}, {known.fps:g} a second",
            "points": f"{sum(known.points):,}",
            "fields": ", ".join(known.fields),
            "labelled frames": f"{known.labelled:,}",
        }
        return html_table(known.name, facts)

    def _edit(self, path: str, body: dict[str, Any] | None = None) -> Steps[Edit]:
        """Make an edit once, by a call with the edit's id in its body."""
        return self._change(Edit, "POST", path, {"id": str(uuid.uuid4()), **(body or {})})

    def _palette_edit(
        self, kind: type[T], method: str, path: str, body: Body | None = None
    ) -> Steps[T]:
        """Make an edit once, by a call with the edit's id in its query."""
        return self._change(kind, method, path, body, edit=str(uuid.uuid4()))

    # ── palette ──────────────────────────────────────────────────────────────────────────

    @steps
    def labels(self) -> Steps[list[Label]]:
        """Return the palette, with the number of points of each label."""
        return self._get(list[Label], "/labels")

    @steps
    def label(self, name: str) -> Steps[Label]:
        """Return the label with a name; raises NotFoundError."""
        for label in (yield from self._get(list[Label], "/labels")):
            if label.name == name:
                return label
        raise NotFoundError(f"label: expected one of the palette, got {name!r}")

    @steps
    def create_label(
        self, /, name: str, *, category: str = "", color: str | None = None, id: int | None = None,
        locked: bool = False, visible: bool = True, distinct: bool = False,
    ) -> Steps[Label]:  # fmt: skip
        """Add a label and return it; the server chooses a missing ``id`` and ``color``.

        ``distinct``: replace a name or colour that is in use by a free one.
        """
        body = NewLabel(name, category, color, id, locked, visible, distinct)
        return self._palette_edit(Label, "POST", "/labels", body)

    @steps
    def update_label(
        self, /, label: int, *, name: str | None = None, category: str | None = None,
        color: str | None = None, locked: bool | None = None, visible: bool | None = None,
    ) -> Steps[Label]:  # fmt: skip
        """Change a label and return it; None: no change."""
        body = LabelPatch(name, category, color, locked, visible)
        return self._palette_edit(Label, "PATCH", f"/labels/{label}", body)

    @steps
    def delete_label(self, label: int) -> Steps[Edit]:
        """Delete a label; the same edit makes its points unlabeled."""
        return self._palette_edit(Edit, "DELETE", f"/labels/{label}")

    @steps
    def merge_labels(self, into: int, labels: Sequence[int]) -> Steps[Edit]:
        """Give all points of ``labels`` to label ``into`` and delete ``labels``, as one edit."""
        return self._palette_edit(Edit, "POST", f"/labels/{into}/merge", Merge(tuple(labels)))

    @steps
    def add_palette(self, template: str) -> Steps[list[str]]:
        """Add the classes of a well-known dataset; return the names of the new labels."""
        # A repeated call finds the labels in the palette: it needs no id.
        body = {"template": template}
        return list((yield from self._change(AddedLabels, "POST", "/palette", body)).added)

    # ── edits ────────────────────────────────────────────────────────────────────────────

    @steps
    def categories(self) -> Steps[list[str]]:
        """Return the categories for labels: the selection of the project, or all."""
        return list((yield from self._get(OfferedCategories, "/categories")).names)

    @steps
    def undo(self) -> Steps[Edit]:
        """Undo your last edit; raises ConflictError if there is none."""
        return self._edit("/undo")

    @steps
    def redo(self) -> Steps[Edit]:
        """Redo the edit of your last undo."""
        return self._edit("/redo")

    @steps
    def edits(self, limit: int = 100, before: int | None = None) -> Steps[list[PastEdit]]:
        """Return the history, newest first; ``before``: only edits before this revision."""
        return self._get(list[PastEdit], "/edits", limit=limit, before=before)

    def watch(self, after: int | None = None, *, patience: float = PATIENCE) -> Watch[L]:
        """Return an iterator of edits, doubts and jobs, for ``for`` or ``async for``.

        ``after``: start with the edits after this revision (None: from now on).  ``patience``:
        seconds for which the server may be away.
        """
        return Watch(self._link, self._place, after, patience)

    @steps
    def annotate(self, values: Mapping[int, ArrayLike], layer: str = "label") -> Steps[Edit]:
        """Replace a layer in several frames as one edit; ``values``: arrays by frame.

        Raises BadInputError as ``Frame.annotate`` does, and then changes no frame.
        """
        arrays = {frame: layer_of(array, layer) for frame, array in values.items()}
        query = {"layer": layer, "id": str(uuid.uuid4())}
        headers = {"Content-Type": "application/zip"}
        answer = yield from self._call(
            "PUT",
            "/annotations",
            idempotent=True,
            content=npz_of(arrays),
            headers=headers,
            params=query,
        )
        return read(Edit, answer.json())

    @steps
    def accept(self, labels: Sequence[int], start: int, stop: int) -> Steps[Edit]:
        """Mark tracked points of labels in frames ``start`` to ``stop`` as painted."""
        body = Stretch(labels=tuple(labels), start=start, stop=stop)
        return self._edit("/accept", body.to_json())

    @steps
    def clear(self, labels: Sequence[int], start: int, stop: int) -> Steps[Edit]:
        """Remove labels from tracked points in frames ``start`` to ``stop``; painted points stay.

        ``frames[i].clear`` removes the labels from painted points as well.
        """
        body = Stretch(labels=tuple(labels), start=start, stop=stop)
        return self._edit("/clear", body.to_json())

    # ── tracking ─────────────────────────────────────────────────────────────────────────

    @steps
    def start_tracking(
        self, /, labels: Sequence[int] | None, start: int, stop: int, *, method: str = "auto",
        overwrite: Overwrite = "tracked", continue_lost: bool = False, until_painted: bool = False,
        stop_unsure: bool = False, patience: float = PATIENCE,
    ) -> Steps[Job]:  # fmt: skip
        """Start a tracking run and return its job; arguments as of ``track``."""
        body = TrackingRequest(
            method, overwrite, continue_lost, until_painted, stop_unsure,
            start=start, stop=stop, labels=tuple_of(labels),
        )  # fmt: skip
        return self._start("/tracking", body, patience)

    @steps
    def track(
        self, /, labels: Sequence[int] | None, start: int, stop: int, *, method: str = "auto",
        overwrite: Overwrite = "tracked", continue_lost: bool = False, until_painted: bool = False,
        stop_unsure: bool = False, progress: bool = True, patience: float = PATIENCE,
    ) -> Steps[Run]:  # fmt: skip
        """Track labels from frame ``start`` to ``stop``, and wait; ``progress`` shows a bar.

        ``labels`` None: all labels in frame ``start``.  ``overwrite``: labelled points that the run
        may replace.  ``continue_lost``: search for a lost label in later frames.
        ``until_painted``: end a label at the next frame in which it is painted.  ``stop_unsure``:
        end the run at a doubtful frame.  ``patience``: seconds for which the server may be away,
        such as during a restart.  Raises PointbrushError with the error of a failed job,
        CancelledError, UnavailableError.
        """
        body = TrackingRequest(
            method, overwrite, continue_lost, until_painted, stop_unsure,
            start=start, stop=stop, labels=tuple_of(labels),
        )  # fmt: skip
        job = yield from self._start("/tracking", body, patience)
        return read(Run, (yield from finished(job, progress=progress, patience=patience)))

    def _start(self, path: str, body: Body, patience: float) -> Steps[Job]:
        job = str(uuid.uuid4())
        request = {"json": {"id": job, **body.to_json()}}
        return started(job, Request("POST", self._place + path, request, patience=patience))

    @steps
    def tracks(self) -> Steps[list[Track]]:
        """Return pose, confidence and state of each tracked label in each frame."""
        return self._get(list[Track], "/tracks")

    # ── people ───────────────────────────────────────────────────────────────────────────

    @steps
    def find_people(self, frames: Sequence[int] | None = None) -> Steps[FoundPeople]:
        """Return the people in colour pictures of frames (None: all); nothing is changed."""
        body = PeopleSearch(tuple_of(frames)).to_json()
        answer = yield from self._call("POST", "/people", json=body, idempotent=True)
        return read(FoundPeople, answer.json())

    @steps
    def start_find_people(
        self, frames: Sequence[int] | None = None, *, patience: float = PATIENCE
    ) -> Steps[Job]:
        """Start to label people and return the job; arguments as of ``label_people``."""
        return (yield from self._people(frames, patience))

    @steps
    def label_people(
        self, frames: Sequence[int] | None = None, *, progress: bool = False,
        patience: float = PATIENCE,
    ) -> Steps[LabelledPeople]:  # fmt: skip
        """Label the people that ``find_people`` finds, as one edit, and wait.

        Painted, erased and tracked points keep their labels.  ``patience``: as of ``track``.
        """
        job = yield from self._people(frames, patience)
        result = yield from finished(job, progress=progress, patience=patience)
        return read(LabelledPeople, result)

    def _people(self, frames: Sequence[int] | None, patience: float) -> Steps[Job]:
        job = str(uuid.uuid4())
        body = {"json": PeopleSearch(tuple_of(frames), True, job).to_json()}
        return started(job, Request("POST", f"{self._place}/people", body, patience=patience))

    # ── sensors ──────────────────────────────────────────────────────────────────────────

    @steps
    def start_align_sensors(
        self, frames: Sequence[int] | None = None, *, undo: bool = False,
        patience: float = PATIENCE,
    ) -> Steps[Job]:  # fmt: skip
        """Start to align sensors and return the job; arguments as of ``align_sensors``."""
        return self._start("/sensors/align", SensorAlignment(tuple_of(frames), undo), patience)

    @steps
    def align_sensors(
        self, frames: Sequence[int] | None = None, *, undo: bool = False, progress: bool = False,
        patience: float = PATIENCE,
    ) -> Steps[AlignedSensors]:  # fmt: skip
        """Correct the mounts of the sensors by surfaces that several of them see, and wait.

        ``frames`` None: some of the whole recording.  ``undo``: restore the mounts of before the
        last alignment instead.  ``patience``: as of ``track``.
        """
        body = SensorAlignment(tuple_of(frames), undo)
        job = yield from self._start("/sensors/align", body, patience)
        result = yield from finished(job, progress=progress, patience=patience)
        return read(AlignedSensors, result)

    # ── boxes ────────────────────────────────────────────────────────────────────────────

    @steps
    def start_fit_boxes(
        self,
        labels: Sequence[int] | None = None,
        *,
        category: str | None = None,
        frames: str | None = None,
        redraw: bool = False,
        patience: float = PATIENCE,
    ) -> Steps[Job]:
        """Start a fit of boxes and return its job; arguments as of ``fit_boxes``."""
        body = BoxFit(tuple_of(labels), category, frames, redraw)
        return self._start("/boxes/fit", body, patience)

    @steps
    def fit_boxes(
        self,
        labels: Sequence[int] | None = None,
        *,
        category: str | None = None,
        frames: str | None = None,
        redraw: bool = False,
        progress: bool = False,
        patience: float = PATIENCE,
    ) -> Steps[FittedBoxes]:
        """Fit boxes to the points of labels (None: all) or of a category, and wait.

        ``redraw`` also replaces poses that a person drew.  ``patience``: as of ``track``.
        """
        body = BoxFit(tuple_of(labels), category, frames, redraw)
        job = yield from self._start("/boxes/fit", body, patience)
        return read(FittedBoxes, (yield from finished(job, progress=progress, patience=patience)))

    @steps
    def export_boxes(self, format: str, out: AnyPath, frames: str | None = None) -> Steps[Path]:
        """Write the boxes of frames ``I:J`` in a format of boxes; as ``export``."""
        return self._export(out, {"format": format, "frames": frames})

    # ── labels made elsewhere, exports ───────────────────────────────────────────────────

    @steps
    def start_label_import(
        self,
        /,
        files: Files | None = None,
        *,
        server_path: AnyPath | None = None,
        dry_run: bool = False,
        patience: float = PATIENCE,
        **options: Unpack[LabelKeywords],
    ) -> Steps[Job]:
        """Start an import of labels and return its job; arguments as of ``import_labels``."""
        return (yield from self._label_import(files, server_path, options, dry_run, patience))

    @steps
    def import_labels(
        self,
        /,
        files: Files | None = None,
        *,
        server_path: AnyPath | None = None,
        dry_run: bool = False,
        progress: bool = False,
        patience: float = PATIENCE,
        **options: Unpack[LabelKeywords],
    ) -> Steps[ImportedLabels]:
        """Upload labels made elsewhere, import them as one edit, and wait; returns the report.

        ``server_path`` imports a path on the server instead of ``files``.  ``options``: fields of
        ``LabelImportOptions``.  ``dry_run`` changes nothing.  ``patience``: as of ``track``.
        """
        job = yield from self._label_import(files, server_path, options, dry_run, patience)
        result = yield from finished(job, progress=progress, patience=patience)
        return read(ImportedLabels, result)

    @steps
    def import_source_labels(self) -> Steps[None]:
        """Import the labels in the recording's own files that were not imported with it."""
        yield from self._call("POST", "/source-labels", idempotent=True)

    def _label_import(
        self,
        files: Files | None,
        server_path: AnyPath | None,
        given: LabelKeywords,
        dry_run: bool,
        patience: float,
    ) -> Steps[Job]:
        job, query = str(uuid.uuid4()), {"dry_run": json.dumps(dry_run)}
        place, options = f"{self._place}/annotations", {"id": job, **given}
        request = upload(place, files, options, server_path, query=query, patience=patience)
        return started(job, request)

    @steps
    def export(
        self,
        format: str,
        out: AnyPath,
        frames: str | None = None,
        val: str | None = None,
        above: float = 0.0,
        snapshot: str | None = None,
        sensor: str | None = None,
    ) -> Steps[Path]:
        """Write an export of frames ``I:J`` to a .zip, whole or not at all; return its path.

        ``val``: validation frames of a format that splits: ``I:J``, ids of recordings separated by
        commas, or ``none``; by default the frames of one recording in five.  ``above``: minimum
        confidence of predicted labels, 0 to 1.  ``snapshot``: labels of a snapshot instead of the
        current ones.  ``sensor``: only the points of this one of several sensors, in its
        coordinates.
        """
        options = {"format": format, "frames": frames, "val": val, "above": above or None}
        options |= {"snapshot": snapshot, "sensor": sensor}
        return self._export(out, options)

    def _export(self, out: AnyPath, options: dict[str, Any]) -> Steps[Path]:
        target = Path(out)
        partial = target.with_name(f".{target.name}-{uuid.uuid4().hex}")
        try:
            yield from self._call("GET", "/export", params=options, into=partial)
            partial.replace(target)
        finally:
            partial.unlink(missing_ok=True)
        return target

    # ── the recording itself ─────────────────────────────────────────────────────────────

    @steps
    def update(self, *, name: str | None = None, fps: float | None = None) -> Steps[Manifest]:
        """Change the name or the frame rate, and return the new manifest."""
        body = RecordingPatch(name, fps)
        self.manifest = yield from self._change(Manifest, "PATCH", "", body)
        self.name = self.manifest.name
        return self.manifest

    @steps
    def delete(self) -> Steps[None]:
        """Delete the recording with its labels; ``Client.restore`` restores it within 30 days."""
        identity = self.manifest.identity
        query = {"identity": identity}
        yield from self._call("DELETE", idempotent=identity is not None, params=query)
