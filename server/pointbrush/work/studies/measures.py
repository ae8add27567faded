"""The measures of a finished task, from its log and the journal of its labels."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, get_args

import numpy as np

from pointbrush.labels.types import EditInfo
from pointbrush.teamwork.studies import Record
from pointbrush.values.study import Phase
from pointbrush.work.studies.overlap import Point

PHASES: tuple[str, ...] = get_args(Phase)
LIMBS = ("head", "left", "right")
LEVELS = {"time_to_80_s": 0.8, "time_to_90_s": 0.9}
"""IoU that the measures of time wait for."""


def times_of(edits: Sequence[EditInfo], records: Sequence[Record]) -> dict[str, float]:
    """Return the time of each edit in the log by its id, seconds since the task began.

    A stroke's record has the id of its edit; undos and redos match by their order.
    """
    times = {each["id"].lower(): each["t"] / 1000 for each in records if each["kind"] == "stroke"}
    found = {each.id: times[each.id.lower()] for each in edits if each.id.lower() in times}
    for kind in ("undo", "redo"):
        ids = [each.id for each in edits if each.kind == kind]
        spans = [each["t"] / 1000 for each in records if each["kind"] == kind]
        found |= dict(zip(ids, spans, strict=False))
    return found


def measures(
    duration_s: float, records: Sequence[Record], strokes: int, curve: Sequence[Point]
) -> dict[str, Any]:
    """Return the measures of a task by name; None: the value was not reached or not logged."""
    counts = Counter(each["kind"] for each in records)
    return {
        "duration_s": round(duration_s, 3),
        "iou": curve[-1][1],
        **{
            name: next((at for at, iou in curve if iou >= level), None)
            for name, level in LEVELS.items()
        },
        "strokes": strokes,
        "clicks": counts["click"],
        "undos": counts["undo"],
        "redos": counts["redo"],
        **{f"{limb}_m": travel(records, limb) for limb in LIMBS},
        **shares(records, duration_s),
    }


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


def by_step(log: Sequence[Record]) -> Mapping[int, list[Record]]:
    """Return the records of each step."""
    found: dict[int, list[Record]] = {}
    for record in log:
        found.setdefault(record["step"], []).append(record)
    return found
