"""Edits of a recording and their history."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from pointbrush.values.base import Body, Value
from pointbrush.values.kinds import Uuid


@dataclass(frozen=True, slots=True)
class Edit(Value):
    """Result of an edit, which is durable."""

    edit: str
    """UUID of the edit."""
    changed: int
    """Number of points with a new label, provenance or deletion."""
    revision: int
    """Revision of the recording after the edit."""


@dataclass(frozen=True, slots=True)
class Split(Edit):
    """Result of the division of a label."""

    labels: tuple[int, ...]
    """Ids of the new labels, the largest first."""
    gap: float
    """Distance between parts, metres."""


@dataclass(frozen=True, slots=True)
class PastEdit(Value):
    """One line of the history."""

    id: str
    """UUID of the edit."""
    revision: int
    """Revision of the recording after the edit."""
    author: str
    """Name of the person or token."""
    time: datetime
    """Time of the commit."""
    kind: str
    """Kind of change, such as ``paint``, ``tracking`` or ``undo``."""
    summary: str
    """Sentence about the change."""
    points: int
    """Number of changed points."""
    frames: tuple[int, ...]
    """Numbers of the changed frames."""
    undone: bool
    """Its author has undone and not redone it."""


@dataclass(frozen=True, slots=True)
class Undo(Body):
    """An undo or redo of the caller's edits."""

    id: Uuid | None = None
    """UUID of the undo, which is applied once; null: the server chooses one."""
    edit: Uuid | None = None
    """UUID of the edit to undo or redo; null: the last one."""
