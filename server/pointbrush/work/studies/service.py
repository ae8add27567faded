"""The service for studies: their files, the sessions of participants, and results."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from pointbrush.database.project_tables import FIRST
from pointbrush.errors import BadInputError, ConflictError, NotFoundError
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.teamwork.studies import Session
from pointbrush.values.study import (
    FileKind,
    LogPosition,
    LogRecords,
    NewStudy,
    Participant,
    Replay,
    StepDone,
    Study,
    StudyInfo,
    StudyStep,
    StudyTask,
)
from pointbrush.work.library import Library
from pointbrush.work.projects.copies import make_copy
from pointbrush.work.studies.design import conditions_of, copy_key, plan, require_answers, step_of
from pointbrush.work.studies.files import TEMPLATES, StudyFiles, parse
from pointbrush.work.studies.overlap import Overlap, Point, frames_of, ids_of
from pointbrush.work.studies.recordings import require_task
from pointbrush.work.studies.replaying import replay
from pointbrush.work.studies.report import to_html
from pointbrush.work.studies.results import (
    COLUMNS,
    Row,
    by_step,
    columns_of,
    curve_rows,
    encode,
    log_rows,
    task_results,
)
from pointbrush.work.trash import ids_for


class Studies:
    """The studies of a workspace; thread-safe.

    ``key`` is the number or code of a participant, ``account`` that of the participant who calls.
    """

    def __init__(
        self, store: WorkspaceStore, library: Library, folder: Path, erase: Callable[[str], None]
    ) -> None:
        """``erase``: removes a recording with its labels for ever."""
        self._store, self._library, self._erase = store, library, erase
        self._rows, self._files = store.studies, StudyFiles(folder)
        self._copying: dict[str, threading.Lock] = {}
        self._writing = threading.Lock()

    def all(self) -> list[StudyInfo]:
        """Return all studies by id; raises BadInputError for an invalid file."""
        return [self.get(each) for each in self._files.ids()]

    def get(self, study: str) -> StudyInfo:
        """Return a study; raises NotFoundError, BadInputError for an invalid file."""
        text = self._files.text(study)
        found, sessions = parse(text, study), self._rows.all(study)
        done = sum(step_of(found, each).kind == "done" for each in sessions)
        return StudyInfo(study, found, text, len(sessions), done)

    def create(self, new: NewStudy) -> StudyInfo:
        """Create a study and the samples that its tasks name.

        Raises ConflictError for an id that a study has, BadInputError, NotFoundError.
        """
        study, text = self._checked(new)
        with self._writing:
            known = self._files.ids()
            wanted = new.id or next(each for each in ids_for(study.title) if each not in known)
            if wanted in known:
                raise ConflictError(f"id: expected one of no study yet, got {wanted!r}")
            self._files.write(wanted, text)
        return self.get(wanted)

    def change(self, study: str, change: NewStudy) -> StudyInfo:
        """Replace a study without participants; raises ConflictError, BadInputError."""
        self._files.text(study)
        if self._rows.all(study):
            raise ConflictError("study: expected one without participants, delete them first")
        text = self._checked(change)[1]
        with self._writing:
            self._files.write(study, text)
        return self.get(study)

    def remove(self, study: str) -> None:
        """Remove a study and every trace of its participants."""
        self._files.text(study)
        for session in self._rows.all(study):
            self._erase_session(session)
        self._files.remove(study)

    def _checked(self, new: NewStudy) -> tuple[Study, str]:
        text = StudyFiles(TEMPLATES).text(new.template) if new.template else new.text
        found = parse(text)
        columns = [name for each in found.questionnaires for name in columns_of(each)]
        for kind, names in (
            ("condition", [each.name for each in found.conditions]),
            ("task", [each.name for each in found.tasks]),
            ("column of the results", [*COLUMNS, *columns]),
        ):
            if twice := next((name for name in names if names.count(name) > 1), None):
                raise BadInputError(
                    f"name: expected another one of each {kind}, got {twice!r} twice"
                )
        for task in found.tasks:
            require_task(self._store, self._library, task)
        return found, text

    # ── participants, for the experimenter ───────────────────────────────────────────────

    def participants(self, study: str) -> list[Participant]:
        """Return the participants of a study by number."""
        design = self._files.read(study)
        return [self._overview(design, each) for each in self._rows.all(study)]

    def add(self, study: str, count: int) -> list[Participant]:
        """Add participants; only this answer has their codes."""
        design = self._files.read(study)
        made = [self._rows.add(study, lambda n: conditions_of(design, n)) for _ in range(count)]
        return [replace(self._overview(design, session), code=code) for session, code in made]

    def pause(self, study: str, key: str, *, paused: bool) -> Participant:
        """Pause or continue the session of a participant."""
        self._rows.pause(self._rows.get(study, key).account, paused=paused)
        return self._overview(self._files.read(study), self._rows.get(study, key))

    def erase(self, study: str, key: str) -> None:
        """Remove every trace of a participant."""
        self._erase_session(self._rows.get(study, key))

    def _erase_session(self, session: Session) -> None:
        for sequence in self._rows.copies(session).values():
            self._erase(sequence)
        self._rows.erase(session.account)
        self._store.team.access.forget()

    def _overview(self, study: Study, session: Session) -> Participant:
        step = step_of(study, session)
        sequence = self._rows.copies(session).get(copy_key(step)) if step.task else None
        return Participant(
            number=session.number,
            conditions=session.conditions,
            state="done" if step.kind == "done" else session.state,
            step=session.step,
            count=step.count,
            kind=step.kind,
            task=step.task.name if step.task else None,
            sequence=sequence,
            iou=self._iou(step.task, sequence) if step.task and sequence else None,
            records=session.records,
        )

    # ── the session of a participant ─────────────────────────────────────────────────────

    def step(self, account: str) -> StudyStep:
        """Return the current step of a participant, with a copy of its recording."""
        session, now = self._rows.begin(account)
        step = step_of(self._files.read(session.study), session)
        elapsed = session.elapsed(now)
        found = replace(step, elapsed_s=elapsed, records=session.records)
        if step.task:
            found = self._with_task(found, session, step.task)
        return replace(found, kind="pause") if session.paused is not None else found

    def _with_task(self, step: StudyStep, session: Session, task: StudyTask) -> StudyStep:
        sequence = self._copy_of(session, copy_key(step), task)
        frames, labels = frames_of(self._library, task), ids_of(self._store, task)
        step = replace(step, sequence=sequence, start=frames.start, stop=frames.stop, labels=labels)
        if step.kind == "instructions":
            return step
        left = task.time_limit_s and max(0.0, task.time_limit_s - step.elapsed_s)
        reached = left == 0.0 or (
            task.stop == "iou" and self._iou(task, sequence) >= task.target_iou
        )
        return replace(step, time_left_s=left, reached=reached)

    def finish(self, account: str, done: StepDone) -> StudyStep:
        """End a step and return the next one; a repeated call returns the current one.

        Raises BadInputError for answers that are missing or out of range, ConflictError.
        """
        session = self._rows.session(account)
        step = step_of(self._files.read(session.study), session)
        if done.number == session.step:
            if step.kind == "done":
                raise ConflictError("step: the session is finished")
            require_answers(step, done.answers)
        last = session.step == step.count - 2  # the step "done" follows
        self._rows.finish(account, done.number, done.answers, last=last)
        if last:
            self._store.team.access.forget()
        return self.step(account)

    def append(self, account: str, log: LogRecords) -> LogPosition:
        """Append records to the log; raises ConflictError for a gap and for other content."""
        records = [each.to_json() for each in log.records]
        return LogPosition(self._rows.append(account, log.first, records))

    def _copy_of(self, session: Session, number: int, task: StudyTask) -> str:
        """Return the copy of a task's recording for step ``number``, made if it is missing."""
        account, original = session.account, task.recording
        found = self._rows.copies(session).get(number)
        if found:
            return found
        # Calls of one participant wait for each other, and never for calls of other participants.
        with self._copying.setdefault(account, threading.Lock()):
            found = self._rows.copies(self._rows.session(account)).get(number)
            if found:
                return found
            project = self._store.team.summaries.project(original) or FIRST
            made = make_copy(
                self._store, self._library, original, project, range(0), "study", set(task.labels)
            )
            try:
                self._rows.keep_copy(account, number, made)
            except NotFoundError:  # the participant was deleted meanwhile
                self._erase(made)
                raise
        self._store.team.access.forget()
        return made

    def _iou(self, task: StudyTask, sequence: str) -> float:
        overlap = Overlap.of(self._store, self._library, task)
        for frame in frames_of(self._library, task):
            overlap.put(frame, self._store.values(sequence, frame))
        return overlap.iou

    # ── results ──────────────────────────────────────────────────────────────────────────

    def results(self, study: str, kind: FileKind, *, curves: bool = False) -> bytes:
        """Return the results as a file: a row per task, or the IoU over time."""
        rows = []
        for row, curve in self._results(study, self._files.read(study)):
            rows += curve_rows(row, curve) if curves else [row]
        return encode(rows, kind)

    def report(self, study: str) -> str:
        """Return the report of a study as HTML."""
        design = self._files.read(study)
        return to_html(design, [*self._results(study, design)])

    def _results(self, study: str, design: Study) -> Iterator[tuple[Row, list[Point]]]:
        return task_results(self._store, self._library, design, self._rows.all(study))

    def log(self, study: str, key: str, kind: FileKind) -> bytes:
        """Return the log of a participant as a file; as JSON, records as they were sent."""
        session = self._rows.get(study, key)
        log = self._rows.log(session.account)
        rows = log if kind == "json" else log_rows(self._files.read(study), session, log)
        return encode(rows, kind)

    def steps(self, study: str, key: str) -> list[StudyStep]:
        """Return the steps of a participant that have labels, by number."""
        session = self._rows.get(study, key)
        steps = plan(self._files.read(study), session)
        copies = sorted(self._rows.copies(session).items())
        return [replace(steps[number], sequence=sequence) for number, sequence in copies]

    def replay(self, study: str, key: str) -> Replay:
        """Compare the labels of a participant with the result of their log."""
        records, edits = by_step(self._rows.log(self._rows.get(study, key).account)), 0
        for step in self.steps(study, key):
            recording = self._library.recording(step.sequence or "")
            try:
                edits += replay(self._store, recording, records[step.number])
            except ConflictError as error:
                names = ", ".join(each.name for each in (step.condition, step.task) if each)
                return Replay(False, edits, f"{names}: {error}")
        return Replay(True, edits, "")
