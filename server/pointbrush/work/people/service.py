"""The service that finds people: previews, and jobs that label them."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.database.job import Job
from pointbrush.errors import BadInputError, ConflictError
from pointbrush.jobs.job import MESSAGE
from pointbrush.jobs.runner import Receiver
from pointbrush.jobs.worker import Channel
from pointbrush.labels import Label, LabelStore, Write
from pointbrush.labels.classes.palette import Palette
from pointbrush.labels.plans import Writes
from pointbrush.labels.types import FULL_CONFIDENCE, PREDICTED
from pointbrush.lazy import once
from pointbrush.masks.people.model import PersonModel
from pointbrush.masks.people.options import PeopleOptions
from pointbrush.ranges import runs_of
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences import open_sequence
from pointbrush.sequences.storage.stored_files import RecordingFiles
from pointbrush.values.people import MOST_SHOWN, FoundPeople, FoundPerson, PersonPoints
from pointbrush.work.job_request import JobRequest
from pointbrush.work.job_service import EditService, JobContext, Submission, edit_result
from pointbrush.work.people import FIND
from pointbrush.work.people.frames import PersonInFrame, Search, has_pictures
from pointbrush.work.people.naming import NamedPerson, join_frames, name_people


@dataclass(frozen=True)
class SearchingWork:
    """Picklable work that sends the people of each frame as an item."""

    files: RecordingFiles
    frames: tuple[int, ...]
    options: PeopleOptions

    def __call__(self, channel: Channel) -> None:
        """Search frame by frame."""
        search = Search(open_sequence(self.files), PersonModel(), self.options)
        for number, frame in enumerate(self.frames, 1):
            channel.item(search.people_in(frame))
            channel.progress(number / len(self.frames), f"frame {frame}")


@dataclass(frozen=True)
class PeopleRequest(JobRequest):
    """Request to label the people in frames of a recording."""

    call = FIND
    frames: tuple[int, ...]


class People(EditService[PeopleRequest]):
    """Finds people; thread-safe.

    Every method raises NotFoundError (recording, frame), ConflictError for a recording without
    pictures, and BadInputError if the model is not installed.
    """

    kind = "prediction"
    request = PeopleRequest

    def __init__(self, context: JobContext) -> None:
        super().__init__(context)
        self.options = PeopleOptions()
        self._lock = threading.Lock()

    @once
    def _model(self) -> PersonModel:
        return PersonModel()

    def find(
        self, sequence: str, frames: Sequence[int] | None = None, *, stored: bool = False
    ) -> FoundPeople:
        """Return the people in frames (None: all); nothing is changed.

        ``stored``: runs of points are in stored order, not in source order.
        """
        recording = self._recording(sequence)
        wanted = self._checked(recording, frames)
        if len(wanted) > MOST_SHOWN:
            raise BadInputError(
                f"frames: expected at most {MOST_SHOWN} without apply, got {len(wanted)}"
            )
        search = Search(recording, self._model, self.options)
        with self._lock:
            found = [search.people_in(each) for each in wanted]
        palette = self._store.palette(sequence)
        people = _named(self._store, sequence, found, palette)
        category = people[0].label.category if people else ""
        shown = tuple(_shown(recording, person, stored=stored) for person in people)
        return FoundPeople(category, len(wanted), shown)

    def start(
        self, sequence: str, frames: Sequence[int] | None = None, *, author: str,
        edit: str | None = None,
    ) -> Job:  # fmt: skip
        """Label the people in frames (None: all) with a job, as one edit.

        ``edit``: id of the edit and the job; if ``author`` has already started a job with this id,
        it is returned.
        """
        wanted = self._checked(self._recording(sequence), frames)
        return self.begin(sequence, PeopleRequest(wanted), author, edit)

    def _checked(self, recording: Recording, frames: Sequence[int] | None) -> tuple[int, ...]:
        wanted = range(len(recording)) if frames is None else sorted(set(frames))
        if not any(has_pictures(recording, frame) for frame in wanted):
            raise ConflictError(
                "people: expected frames with the colours of a depth camera, got none; "
                "people are found in pictures"
            )
        _ = self._model
        return tuple(wanted)

    def _prepare(self, request: PeopleRequest, job: Job) -> Submission:
        recording = self._recording(job.sequence or "")
        self._store.require_writable()
        work = SearchingWork(recording.files, request.frames, self.options)
        return job, work, _Labelling(self._store, recording, len(request.frames))


class _Labelling(Receiver):
    """Commits the people as one edit, except points that were painted, erased or tracked."""

    def __init__(self, store: LabelStore, recording: Recording, frames: int) -> None:
        super().__init__()
        self.store, self.recording, self.frames = store, recording, frames

    def finish(self, job: Job, cancelled: bool) -> dict[str, Any]:
        people = 0 if cancelled else len(join_frames(self.items))
        if not people:
            why = "no label was changed" if cancelled else "no people found"
            return {"edit": None, "changed": 0, "people": 0, MESSAGE: why}
        many = "1 person" if people == 1 else f"{people} people"
        commit = self.store.apply(
            self.recording.manifest.id,
            edit_id=job.edit or job.id,
            author=job.owner or "",
            kind="prediction",
            writes=self._choose,
            summary=f"found {many}",
            identity=self.recording.identity,
        )
        message = f"found {many}, {commit.changed:,} points labelled"
        return edit_result(commit) | {"people": people, "frames": self.frames, MESSAGE: message}

    def _choose(self, palette: Palette) -> tuple[Sequence[Label], Writes]:
        """Return the labels and writes for the palette at the commit."""
        ids, added, chosen = palette.free_ids(), list[Label](), list[NamedPerson]()
        sequence = self.recording.manifest.id
        for person in _named(self.store, sequence, self.items, palette.labels, palette):
            label = person.label
            if not person.known:
                label = replace(label, id=ids.take((label.name, label.category)))
                added.append(label)
            # Hidden and locked labels are not predicted.
            if label.visible and not label.locked:
                chosen.append(replace(person, label=label))
        return added, _writes(chosen)


def _named(
    store: LabelStore, sequence: str, found: Iterable[Sequence[PersonInFrame]],
    labels: Sequence[Label], palette: Palette | None = None,
) -> list[NamedPerson]:  # fmt: skip
    def labels_of(frame: int, numbers: NDArray[np.int64]) -> NDArray[np.uint16]:
        return store.values(sequence, frame).label[numbers]

    people = sorted(join_frames(list(found)), key=lambda seen: seen[0].depth)
    used = {label for _, label in store.counts(sequence)}
    admits = palette.admits if palette else lambda _: True
    return name_people(people, labels, labels_of, admits, used)


def _writes(people: Iterable[NamedPerson]) -> Iterator[tuple[int, Write]]:
    for person in people:
        for each in person.seen:
            confidence = round(each.score * FULL_CONFIDENCE)
            write = Write(
                each.numbers, label=person.label.id, provenance=PREDICTED,
                confidence=np.full(len(each.numbers), confidence, np.uint8),
                only="predictable", living=True, hidden=frozenset(),
            )  # fmt: skip
            yield each.frame, write


def _shown(recording: Recording, person: NamedPerson, *, stored: bool) -> FoundPerson:
    frames = []
    for each in person.seen:
        numbers = each.numbers
        if not stored:
            numbers = np.sort(recording[each.frame].source_index[numbers]).astype(np.int64)
        runs = tuple((first, count) for first, count in runs_of(numbers).tolist())
        frames.append(PersonPoints(each.frame, each.score, len(numbers), runs))
    label = person.label
    return FoundPerson(label.name, label.color, label.id if person.known else None, tuple(frames))
