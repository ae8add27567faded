"""The service for studies: their files, participants and results."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from pointbrush.errors import BadInputError, ConflictError
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.teamwork.studies import Session
from pointbrush.values.study import (
    FileKind,
    NewStudy,
    Participant,
    Replay,
    SessionStep,
    Study,
    StudyInfo,
)
from pointbrush.work.library import Library
from pointbrush.work.studies.design import conditions_of, plan
from pointbrush.work.studies.files import TEMPLATES, StudyFiles, parse
from pointbrush.work.studies.measures import by_step
from pointbrush.work.studies.recordings import require_task
from pointbrush.work.studies.sessions import Sessions
from pointbrush.work.trash import ids_for

if TYPE_CHECKING:
    from pointbrush.work.studies.overlap import Point
    from pointbrush.work.studies.results import Row


class Studies:
    """The studies of a workspace; thread-safe."""

    def __init__(
        self,
        store: WorkspaceStore,
        library: Library,
        folder: Path,
        erase: Callable[[str], None],
    ) -> None:
        """``erase``: removes a recording with its labels for ever."""
        self._store, self._library, self._erase = store, library, erase
        self._files = StudyFiles(folder)
        self.sessions = Sessions(store, library, self._files)

    def all(self) -> list[StudyInfo]:
        """Return all studies by id; raises BadInputError for an invalid file."""
        return [self.get(each) for each in self._files.ids()]

    def get(self, study: str) -> StudyInfo:
        """Return a study; raises NotFoundError, BadInputError for an invalid file."""
        text = self._files.text(study)
        found = parse(text, study)
        sessions = self._store.studies.all(study)
        done = sum(1 for each in sessions if each.step >= len(plan(found, each.conditions)) - 1)
        return StudyInfo(study, found, text, len(sessions), done)

    def create(self, new: NewStudy) -> StudyInfo:
        """Create a study and the samples that its tasks name.

        Raises ConflictError for an id that a study has, BadInputError, NotFoundError.
        """
        study, text = self._checked(new)
        known = self._files.ids()
        wanted = new.id or next(each for each in ids_for(study.title) if each not in known)
        if wanted in known:
            raise ConflictError(f"id: expected one of no study yet, got {wanted!r}")
        self._files.write(wanted, text)
        return self.get(wanted)

    def change(self, study: str, change: NewStudy) -> StudyInfo:
        """Replace a study without participants; raises ConflictError, BadInputError."""
        self._files.text(study)
        if self._store.studies.all(study):
            raise ConflictError("study: expected one without participants, delete them first")
        self._files.write(study, self._checked(change)[1])
        return self.get(study)

    def remove(self, study: str) -> None:
        """Remove a study and every trace of its participants."""
        self._files.text(study)
        for session in self._store.studies.all(study):
            self._erase_session(session)
        self._files.remove(study)

    def _checked(self, new: NewStudy) -> tuple[Study, str]:
        text = StudyFiles(TEMPLATES).text(new.template) if new.template else new.text
        found = parse(text)
        for names in (found.conditions, found.tasks, found.questionnaires):
            if len({each.name for each in names}) < len(names):
                raise BadInputError("name: expected a different one of each condition and task")
        for task in found.tasks:
            require_task(self._store, self._library, task)
        return found, text

    # ── participants ─────────────────────────────────────────────────────────────────────

    def participants(self, study: str) -> list[Participant]:
        """Return the participants of a study by number."""
        self._files.text(study)
        return [self.sessions.overview(each) for each in self._store.studies.all(study)]

    def add(self, study: str, count: int) -> list[tuple[Participant, str]]:
        """Add participants; return them with their codes, which are not stored."""
        design = self._files.read(study)
        made = [
            self._store.studies.add(study, lambda number: conditions_of(design, number))
            for _ in range(count)
        ]
        return [(self.sessions.overview(session), code) for session, code in made]

    def pause(self, study: str, key: str, *, paused: bool) -> Participant:
        """Pause or continue the session of a participant, by number or code."""
        account = self._store.studies.get(study, key).account
        self._store.studies.pause(account, paused=paused)
        return self.sessions.overview(self._store.studies.session(account))

    def erase(self, study: str, key: str) -> None:
        """Remove every trace of a participant, by number or code."""
        self._erase_session(self._store.studies.get(study, key))

    def _erase_session(self, session: Session) -> None:
        for sequence in self._store.studies.copies(session).values():
            self._erase(sequence)
        self._store.studies.erase(session.account)
        self._store.team.access.forget()

    # ── results ──────────────────────────────────────────────────────────────────────────

    def results(self, study: str, kind: FileKind, *, curves: bool = False) -> bytes:
        """Return the results as a file: a row per task, or the IoU over time."""
        from pointbrush.work.studies.results import curve_rows, encode  # slow to import

        rows = []
        for row, curve in self._results(study, self._files.read(study)):
            rows += curve_rows(row, curve) if curves else [row]
        return encode(rows, kind)

    def report(self, study: str) -> str:
        """Return the report of a study as HTML."""
        from pointbrush.work.studies.report import to_html

        design = self._files.read(study)
        return to_html(design, [*self._results(study, design)])

    def _results(self, study: str, design: Study) -> Iterator[tuple[Row, list[Point]]]:
        from pointbrush.work.studies.results import task_results

        return task_results(self._store, self._library, design, self._store.studies.all(study))

    def log(self, study: str, key: str, kind: FileKind) -> bytes:
        """Return the log of a participant as a file; as JSON, records as they were sent."""
        from pointbrush.work.studies.results import encode, log_rows

        session = self._store.studies.get(study, key)
        log = self._store.studies.log(session.account)
        return encode(
            log if kind == "json" else log_rows(self._files.read(study), session, log), kind
        )

    def steps(self, study: str, key: str) -> list[SessionStep]:
        """Return the steps of a participant that have a recording, by number."""
        session = self._store.studies.get(study, key)
        steps = plan(self._files.read(study), session.conditions)
        return [
            SessionStep(number, step.kind, step.condition.name, step.task.name, sequence)
            for number, sequence in sorted(self._store.studies.copies(session).items())
            if (step := steps[number]).condition and step.task
        ]

    def replay(self, study: str, key: str) -> Replay:
        """Compare the labels of a participant with those that their log leads to."""
        from pointbrush.work.studies.replaying import replay

        session = self._store.studies.get(study, key)
        records = by_step(self._store.studies.log(session.account))
        copies = {
            f"{step.condition}, {step.task}": (
                self._library.recording(step.sequence), records.get(step.number, [])
            )
            for step in self.steps(study, key)
        }  # fmt: skip
        return replay(self._store, copies)
