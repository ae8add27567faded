"""The client's interface to one recording, as far as commands use it, on this machine."""

from __future__ import annotations

from collections.abc import Sequence, Sized
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pointbrush.values.boxes import BoxFit
from pointbrush.values.classifiers import Application
from pointbrush.values.runs import TrackingRequest
from pointbrush.values.team.review import Agreement

if TYPE_CHECKING:
    from pointbrush.database.job import Job
    from pointbrush.geometry.oriented_box import OrientedBox
    from pointbrush.sequences import Manifest as StoredManifest
    from pointbrush.values.labels import Label as CountedLabel
    from pointbrush.values.people import FoundPeople
    from pointbrush.values.recordings import Manifest
    from pointbrush.values.team.review import Checked
    from pointbrush.work.reviewing.report.gather import Table
    from pointbrush.workspace import Workspace

AUTHOR = "command line"
"""Author of the edits of commands."""


@dataclass(frozen=True)
class Part:
    """A recording, a part of its calls, or a project, by its id."""

    workspace: Workspace
    id: str


class LocalRecording(Part):
    """The calls of ``client.Recording``."""

    @property
    def frames(self) -> Sized:
        """The frames; raises DamagedError, NotFoundError."""
        return self.workspace.recording(self.id)

    @property
    def manifest(self) -> Manifest:
        """The manifest of the recording; raises DamagedError, NotFoundError."""
        self.workspace.recording(self.id)
        return self.workspace.listing.entry(self.id)

    @property
    def boxes(self) -> LocalBoxes:
        return LocalBoxes(self.workspace, self.id)

    @property
    def by_example(self) -> LocalByExample:
        return LocalByExample(self.workspace, self.id)

    @property
    def review(self) -> LocalReview:
        return LocalReview(self.workspace, self.id)

    def labels(self) -> list[CountedLabel]:
        from pointbrush.work.palettes import counted_labels

        return counted_labels(self.workspace.labels, self.id)

    def start_tracking(
        self, labels: tuple[int, ...] | None, start: int, stop: int, **options: Any
    ) -> Job:
        body = TrackingRequest(start=start, stop=stop, labels=labels, **options)
        return self.workspace.tracking.start(self.id, body, AUTHOR)

    def start_fit_boxes(self, labels: tuple[int, ...] | None, **options: Any) -> Job:
        return self.workspace.fitting.fit(self.id, BoxFit(labels, **options), AUTHOR)

    def find_people(self, frames: Sequence[int]) -> FoundPeople:
        return self.workspace.people.find(self.id, frames)

    def start_find_people(self, frames: Sequence[int]) -> Job:
        return self.workspace.people.start(self.id, frames, author=AUTHOR)

    def start_align_sensors(self, frames: Sequence[int] | None, *, undo: bool) -> Job:
        return self.workspace.aligning.start(self.id, frames, author=AUTHOR, undo=undo)

    def start_label_import(
        self, files: Sequence[Path], *, map: str | None, dry_run: bool, **options: Any
    ) -> Job:
        from pointbrush.formats.tables.class_maps import parse_map

        (place,), names = files, {} if map is None else parse_map("--map", map)
        return self.workspace.imports.begin_labels(
            self.id, place, AUTHOR, names=names, dry_run=dry_run, **options
        )

    def import_source_labels(self) -> None:
        self.workspace.imports.import_source_labels(self.id, AUTHOR)

    def export(
        self, format: str, out: Path, frames: str | None, val: str | None, above: float,
        snapshot: str | None, sensor: str | None,
    ) -> None:  # fmt: skip
        self.workspace.export(self.id, format, out, frames, val, above, snapshot, sensor)

    def update(self, *, name: str) -> StoredManifest:
        return self.workspace.update_sequence(self.id, name=name)

    def delete(self) -> None:
        """Delete the recording with its labels; raises NotFoundError, DamagedError."""
        self.workspace.recording(self.id)
        self.workspace.deletion.delete(self.id)


class LocalBoxes(Part):
    """The calls of ``client.Boxes``."""

    def all(self) -> Sequence[OrientedBox]:
        return self.workspace.labels.boxes.listing(self.id).boxes


class LocalByExample(Part):
    """The calls of ``client.ByExample``."""

    def start(self, classifier: str, frames: str, above: float | None) -> Job:
        body = Application(classifier, frames, above)
        return self.workspace.predictions.start(self.id, body, AUTHOR)


class LocalReview(Part):
    """The calls of ``client.Review``."""

    def check(self, frames: str | None) -> Checked:
        return self.workspace.reviewing.checks(self.id, frames)

    def agreement(self, other: str, *, frames: str | None, boxes: bool) -> Agreement:
        """Return the agreement of labels, or of boxes alone, with another recording."""
        reviewing = self.workspace.reviewing
        if boxes:
            found = reviewing.box_agreement(self.id, other, frames)
            return Agreement(None, None, (), (), found)
        return reviewing.agreement(self.id, other, frames=frames)

    def report(self, out: Path, table: Table) -> None:
        from pointbrush.work.reviewing.report.gather import to_csv
        from pointbrush.work.reviewing.report.html import to_html

        found = self.workspace.reviewing.report(self.id)
        text = to_html(found) if out.suffix.lower() == ".html" else to_csv(found, table)
        out.write_text(text, encoding="utf-8")
