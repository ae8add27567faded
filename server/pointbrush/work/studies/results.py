"""The results of a study as tables: measures of each task, IoU over time, logs."""

from __future__ import annotations

import csv
import io
import json
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, get_args

import numpy as np

from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.teamwork.studies import FinishedStep, Record, Session
from pointbrush.values.study import FileKind, LogRecord, Phase, Questionnaire, Study, StudyStep
from pointbrush.work.library import Library
from pointbrush.work.studies.design import items_of, plan, score
from pointbrush.work.studies.overlap import Overlap, Point, curve_of
from pointbrush.work.studies.replaying import Replayed, matched

Row = dict[str, Any]
PHASES: tuple[str, ...] = get_args(Phase)
LIMBS = ("head", "left", "right")
LEVELS = {"time_to_80_s": 0.8, "time_to_90_s": 0.9}
"""IoU that the measures of time wait for."""
AXES = ("x", "y", "z", "qx", "qy", "qz", "qw")


def task_results(
    store: WorkspaceStore, library: Library, study: Study, sessions: Iterable[Session]
) -> Iterator[tuple[Row, list[Point]]]:
    """Yield a row for each finished task of each participant, and the IoU over time."""
    for session in sessions:
        steps, copies = plan(study, session), store.studies.copies(session)
        scores = _scores(steps, session.finished)
        records = by_step(store.studies.log(session.account))
        for number, (step, ended) in enumerate(zip(steps, session.finished, strict=False)):
            if step.kind != "task" or step.task is None or number not in copies:
                continue
            duration = ended.ended - ended.began - ended.paused_s
            duration = min(duration, step.task.time_limit_s or duration)
            edits, log = [*store.changes(copies[number])], records[number]
            found = matched((edit for edit, _ in edits), log)
            strokes = sum(edit.target is None for edit, _ in found)
            overlap = Overlap.of(store, library, step.task)
            replayed = Replayed(library.recording(copies[number]).manifest.points)
            times = {edit.id: record["t"] / 1000 for edit, record in found}
            curve = [*curve_of(edits, times, overlap, replayed)]
            named = _named(session, step)
            row = named | measures(duration, log, strokes, curve)
            yield row | scores[named["condition"]] | scores[""], curve


def log_rows(study: Study, session: Session, log: Iterable[Record]) -> list[Row]:
    """Return the log of a participant with a column for each number of a pose."""
    steps, rows = plan(study, session), []
    names = [name for name in LogRecord.__dataclass_fields__ if name not in (*LIMBS, "t")]
    for number, record in enumerate(log):
        row = _named(session, steps[min(record["step"], len(steps) - 1)])
        row |= {"record": number, "received": record["received"], "t_ms": record["t"]}
        row |= {name: record.get(name) for name in names}
        row["profile"] = record.get("profile") and json.dumps(record["profile"])
        for limb in LIMBS:
            pose = record.get(limb) or (None,) * len(AXES)
            row |= {f"{limb}_{axis}": value for axis, value in zip(AXES, pose, strict=True)}
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
    """Return rows as a file, with the columns of all of them."""
    if kind == "json":
        return json.dumps(rows).encode()
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


def _named(session: Session, step: StudyStep) -> Row:
    condition, task = step.condition, step.task
    return {
        "participant": session.number,
        "position": session.conditions.index(condition.name) + 1 if condition else None,
        "condition": condition and condition.name,
        "device": condition and condition.device,
        "input": condition and condition.input,
        "task": task and task.name,
    }


def _scores(steps: Sequence[StudyStep], finished: Sequence[FinishedStep]) -> dict[str, Row]:
    """Return scores and answers of questionnaires by condition; "": of the whole study."""
    rows: dict[str, Row] = defaultdict(dict)
    for step, (*_, answers) in zip(steps, finished, strict=False):
        if step.questionnaire:
            row = rows[step.condition.name if step.condition else ""]
            values = [score(step.questionnaire.items, answers), *answers]
            row |= dict(zip(columns_of(step.questionnaire), values, strict=True))
    return rows


def columns_of(questionnaire: Questionnaire) -> list[str]:
    """Return the columns of a questionnaire: its score, and the answer to each item."""
    name = questionnaire.name
    return [name, *(f"{name}_{place}" for place in range(1, len(items_of(questionnaire)) + 1))]


# ── measures of a task, from its log and the journal of its labels ───────────────────────


def measures(
    duration_s: float, records: Sequence[Record], strokes: int, curve: Sequence[Point]
) -> dict[str, Any]:
    """Return the measures of a task by name; None: the value was not reached or not logged."""
    counts = Counter(each["kind"] for each in records)
    return {
        "duration_s": round(duration_s, 3),
        "iou": curve[-1][1],
        **{name: time_to(level, curve) for name, level in LEVELS.items()},
        **{
            name: next((t for t, iou in curve if iou >= least), None)
            for name, least in LEVELS.items()
        },
        "strokes": strokes,
        **{f"{kind}s": counts[kind] for kind in ("click", "undo", "redo")},
        **{f"{limb}_m": travel(records, limb) for limb in LIMBS},
        **shares(records, duration_s),
    }


def time_to(level: float, curve: Sequence[Point]) -> float | None:
    """Return the seconds until the IoU was at least ``level``; None: never."""
    return next((at for at, iou in curve if iou >= level), None)


def travel(records: Sequence[Record], limb: str) -> float | None:
    """Return the length of a limb's path in metres; None without two poses of it."""
    places = np.array([each[limb][:3] for each in records if each.get(limb)], float)
    if len(places) < 2:
        return None
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())


def shares(records: Sequence[Record], duration_s: float) -> dict[str, float | None]:
    """Return the share of each phase in a task; before the first record of a phase is waiting."""
    changes = [(0.0, "waiting")]
    changes += [(each["t"] / 1000, each["phase"]) for each in records if each["kind"] == "phase"]
    if len(changes) == 1 or duration_s <= 0:
        return dict.fromkeys(PHASES)
    spent = dict.fromkeys(PHASES, 0.0)
    for (begin, phase), (end, _) in pairwise([*changes, (duration_s, "")]):
        spent[phase] += max(0.0, min(end, duration_s) - min(begin, duration_s))
    return {phase: seconds / duration_s for phase, seconds in spent.items()}


def by_step(log: Iterable[Record]) -> Mapping[int, list[Record]]:
    """Return the records of each step."""
    found = defaultdict[int, list[Record]](list)
    for record in log:
        found[record["step"]].append(record)
    return found


COLUMNS = (
    "participant", "position", "condition", "device", "input", "task",
    *measures(1.0, (), 0, [(0.0, 0.0)]),
)  # fmt: skip
"""Columns of the results; each questionnaire adds further columns."""
