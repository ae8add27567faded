"""The results of a study as tables: measures of each task, IoU over time, logs."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.teamwork.studies import FinishedStep, Record, Session
from pointbrush.values.study import FileKind, LogRecord, Study
from pointbrush.work.library import Library
from pointbrush.work.studies.design import PlannedStep, plan, score
from pointbrush.work.studies.measures import LIMBS, Task, by_step, measures, times_of
from pointbrush.work.studies.overlap import Overlap, Point, curve_of, ids_of, truth_of

Row = dict[str, Any]
AXES = ("x", "y", "z", "qx", "qy", "qz", "qw")


class Results:
    """The results of the participants of one study."""

    def __init__(self, store: WorkspaceStore, library: Library, study: Study) -> None:
        self._store, self._library, self._study = store, library, study

    def tasks(self, sessions: Sequence[Session]) -> Iterator[tuple[Row, list[Point]]]:
        """Yield a row for each finished task of each participant, and the IoU over time."""
        for session in sessions:
            ended, log = self._store.studies.steps(session.account), None
            copies = self._store.studies.copies(session.account)
            steps = plan(self._study, session.conditions)
            scores = _scores(steps, ended)
            for number, step in enumerate(steps):
                if step.kind != "task" or number not in ended or number not in copies:
                    continue
                log = by_step(self._store.studies.log(session.account)) if log is None else log
                task = self._task(step, ended[number], copies[number], log.get(number, []))
                named = _named(session, step)
                row = named | measures(task) | scores.get(named["condition"], {}) | scores[""]
                yield row, [*task.curve]

    def _task(
        self, step: PlannedStep, ended: FinishedStep, sequence: str, records: Sequence[Record]
    ) -> Task:
        assert step.task is not None  # noqa: S101 - of kind "task"
        duration = ended.ended - ended.began - ended.paused_s
        if step.task.time_limit_s is not None:
            duration = min(duration, step.task.time_limit_s)
        edits = [*self._store.changes(sequence)]
        lines = [line for line, _ in edits if line.kind != "import"]
        overlap = Overlap(
            truth_of(self._store, self._library, step.task), ids_of(self._store, step.task)
        )
        curve = [*curve_of(edits, times_of(lines, records), overlap)]
        return Task(duration, records, lines, curve)

    def log(self, session: Session) -> list[Row]:
        """Return the log of a participant with a column for each number of a pose."""
        steps = plan(self._study, session.conditions)
        names = [name for name in LogRecord.__dataclass_fields__ if name not in (*LIMBS, "t")]
        rows = []
        for number, record in enumerate(self._store.studies.log(session.account)):
            step = steps[record["step"]] if record["step"] < len(steps) else steps[-1]
            row = _named(session, step) | {"record": number, "received": record["received"]}
            row |= {"t_ms": record["t"], **{name: record.get(name) for name in names}}
            row["profile"] = record.get("profile") and json.dumps(record["profile"])
            for limb in LIMBS:
                pose = record.get(limb) or (None,) * len(AXES)
                row |= {f"{limb}_{axis}": v for axis, v in zip(AXES, pose, strict=True)}
            rows.append(row)
        return rows


def curve_rows(row: Row, curve: Sequence[Point]) -> list[Row]:
    """Return the rows of the IoU over time of a task."""
    names = {name: row[name] for name in ("participant", "condition", "task")}
    return [names | {"t_s": at, "iou": iou} for at, iou in curve]


def at_seconds(curve: Sequence[Point], seconds: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return the IoU at 0, 1, … ``seconds``; after the last edit it keeps its value."""
    times, values = (np.array(each, float) for each in zip(*curve, strict=True))
    order = np.argsort(times, kind="stable")
    found = np.searchsorted(times[order], np.arange(seconds + 1), side="right") - 1
    return values[order][np.maximum(found, 0)]


def encode(rows: Sequence[Row], kind: FileKind) -> bytes:
    """Return rows as a CSV or Parquet file, with the columns of all of them."""
    columns = list(dict.fromkeys(name for row in rows for name in row))
    if kind == "csv":
        text = io.StringIO(newline="")
        writer = csv.DictWriter(text, columns)
        writer.writeheader()
        writer.writerows(rows)
        return text.getvalue().encode()
    import pyarrow as arrow
    from pyarrow import parquet  # slow to import

    out = io.BytesIO()
    parquet.write_table(
        arrow.table({name: [row.get(name) for row in rows] for name in columns}), out
    )
    return out.getvalue()


def _named(session: Session, step: PlannedStep) -> Row:
    condition, task = step.condition, step.task
    return {
        "participant": session.number,
        "position": session.conditions.index(condition.name) + 1 if condition else None,
        "condition": condition and condition.name,
        "device": condition and condition.device,
        "input": condition and condition.input,
        "task": task and task.name,
    }


def _scores(steps: Sequence[PlannedStep], ended: dict[int, FinishedStep]) -> dict[str, Row]:
    """Return scores and answers of questionnaires by condition; "": of the whole study."""
    rows: dict[str, Row] = {"": {}}
    for number, step in enumerate(steps):
        if step.questionnaire is None:
            continue
        name, items = step.questionnaire.name, step.questionnaire.items
        row = rows.setdefault(step.condition.name if step.condition else "", {})
        answers = ended[number].answers if number in ended else None
        row[name] = None if answers is None else score(items, answers)
        for place in range(len(items)):
            row[f"{name}_{place + 1}"] = None if answers is None else answers[place]
    return rows
