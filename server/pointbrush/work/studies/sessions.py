"""The session of a participant: the current step, its copy of the recording, and the log."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass

from pointbrush.errors import BadInputError, ConflictError
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.teamwork.studies import Session
from pointbrush.values.kinds import time_of
from pointbrush.values.study import (
    LogPosition,
    LogRecords,
    Participant,
    ParticipantState,
    StepDone,
    Study,
    StudyStep,
    StudyTask,
)
from pointbrush.work.library import Library
from pointbrush.work.studies.design import PlannedStep, plan
from pointbrush.work.studies.files import StudyFiles
from pointbrush.work.studies.overlap import Overlap, frames_of, ids_of, shown, truth_of
from pointbrush.work.studies.recordings import copy_for


@dataclass(frozen=True, slots=True)
class Current:
    """The current step of a session, and the copy that it shows, if it shows one."""

    study: Study
    session: Session
    steps: Sequence[PlannedStep]
    step: PlannedStep
    sequence: str | None


class Sessions:
    """The sessions of all participants of a workspace; thread-safe."""

    def __init__(self, store: WorkspaceStore, library: Library, files: StudyFiles) -> None:
        self._store, self._library, self._files = store, library, files
        self._copying = threading.Lock()

    def step(self, account: str) -> StudyStep:
        """Return the current step of a participant, with a copy of its recording."""
        session, now = self._store.studies.see(account)
        current = self._current(session)
        step, task, elapsed = current.step, current.step.task, session.elapsed(now)
        frames = range(0) if task is None else frames_of(self._library, task)
        timed = task is not None and step.kind in ("practice", "task")
        limit = task.time_limit_s if task is not None and timed else None
        left = None if limit is None else max(0.0, limit - elapsed)
        texts = (
            current.study.consent if step.kind == "consent" else "",
            task.instructions if task else "",
            step.condition.instructions if step.condition and not task else "",
        )
        return StudyStep(
            title=current.study.title,
            number=session.step,
            count=len(current.steps),
            kind="pause" if session.paused is not None else step.kind,
            text=next(filter(None, texts), ""),
            condition=step.condition,
            task=task,
            sequence=current.sequence,
            start=frames.start,
            stop=frames.stop,
            labels=() if task is None else ids_of(self._store, task),
            time_left_s=left,
            elapsed_s=elapsed,
            reached=left == 0.0 or (timed and self._reached(current)),
            questionnaire=step.questionnaire,
            records=session.records,
        )

    def finish(self, account: str, done: StepDone) -> StudyStep:
        """End a step and return the next one; a repeated call returns the current one.

        Raises BadInputError for answers that are missing or out of range, ConflictError.
        """
        session = self._store.studies.session(account)
        steps = plan(self._files.read(session.study), session.conditions)
        if done.number == session.step:
            if steps[session.step].kind == "done":
                raise ConflictError("step: the session is finished")
            _require_answers(steps[session.step], done.answers)
        self._store.studies.finish(account, done.number, done.answers)
        return self.step(account)

    def append(self, account: str, log: LogRecords) -> LogPosition:
        """Append records to the log; raises ConflictError for a gap and for other content."""
        records = [each.to_json() for each in log.records]
        return LogPosition(self._store.studies.append(account, log.first, records))

    def overview(self, session: Session) -> Participant:
        """Return the state of a session for its experimenter, without the code."""
        current = self._current(session, copies=False)
        state: ParticipantState = "running" if session.began is not None else "waiting"
        if current.step.kind == "done":
            state = "done"
        elif session.paused is not None:
            state = "paused"
        condition, task = current.step.condition, current.step.task
        return Participant(
            number=session.number,
            conditions=session.conditions,
            state=state,
            step=session.step,
            count=len(current.steps),
            kind=current.step.kind,
            condition=condition.name if condition else None,
            task=task.name if task else None,
            sequence=current.sequence,
            iou=self._iou(task, current.sequence) if task and current.sequence else None,
            records=session.records,
            seen=time_of(session.seen),
        )

    def _current(self, session: Session, *, copies: bool = True) -> Current:
        """Return the current step; ``copies``: make its copy if it is missing."""
        study = self._files.read(session.study)
        steps = plan(study, session.conditions)
        step = steps[min(session.step, len(steps) - 1)]
        if step.copy is None or step.task is None:
            return Current(study, session, steps, step, None)
        known = self._store.studies.copies(session).get(step.copy)
        if known is None and copies:
            with self._copying:
                known = self._copy(session, step.copy, step.task)
        return Current(study, session, steps, step, known)

    def _copy(self, session: Session, step: int, task: StudyTask) -> str:
        now = self._store.studies.session(session.account)
        known = self._store.studies.copies(now).get(step)
        if known is None:
            known = copy_for(self._store, self._library, task)
            self._store.studies.keep_copy(session.account, step, known)
            self._store.team.access.forget()
        return known

    def _reached(self, current: Current) -> bool:
        task, sequence = current.step.task, current.sequence
        if task is None or sequence is None or task.stop != "iou":
            return False
        return self._iou(task, sequence) >= task.target_iou

    def _iou(self, task: StudyTask, sequence: str) -> float:
        truth = truth_of(self._store, self._library, task)
        overlap = Overlap(truth, ids_of(self._store, task))
        for frame in truth:
            overlap.put(frame, shown(self._store.values(sequence, frame)))
        return overlap.iou


def _require_answers(step: PlannedStep, answers: Sequence[int]) -> None:
    items = step.questionnaire.items if step.questionnaire else ()
    if len(answers) != len(items):
        raise BadInputError(f"answers: expected {len(items)}, got {len(answers)}")
    for number, (item, answer) in enumerate(zip(items, answers, strict=True), 1):
        if answer > item.steps:
            raise BadInputError(f"answers: expected 1 to {item.steps} for item {number}")
