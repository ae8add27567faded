"""Projects: recordings in groups, with people's roles and a selection of the categories."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Annotated

from pointbrush.values.base import Body, ClosedKeys, Rule, Value, optional
from pointbrush.values.kinds import VISIBLE, Name, Role, SequenceName, TaskState

AccountName = Annotated[str, Rule(min_length=1, max_length=128, pattern=f"^{VISIBLE}+$")]
Roles = Annotated[Mapping[AccountName, Role], Rule(max_length=10_000), ClosedKeys()]
Recordings = Annotated[tuple[SequenceName, ...], Rule(max_length=100_000)]
CategoryNumbers = Annotated[
    tuple[Annotated[int, Rule(ge=1, le=65535)], ...], Rule(max_length=65535)
]


@dataclass(frozen=True, slots=True)
class ProjectPatch(Body):
    """Values to set; missing fields do not change."""

    name: Name | None = None
    """Text that people see."""
    roles: Roles | None = None
    """Role in the project by account; empty: every account has its role in the workspace."""
    categories: CategoryNumbers | None = optional()
    """Numbers of the selected categories; null: all categories."""
    recordings: Recordings | None = None
    """Ids of recordings, which move from their former projects."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NewProject(ProjectPatch):
    """A new project."""

    name: Name
    """Text that people see."""
    id: SequenceName | None = None
    """Name in URLs; null: derived from ``name``."""


@dataclass(frozen=True, slots=True)
class ProjectInfo(Value):
    """A project as the caller sees it."""

    id: str
    """Name in URLs."""
    name: str
    """Text that people see."""
    created: datetime
    """Time of its creation."""
    role: Role
    """Role of the caller in it."""
    roles: Mapping[str, Role]
    """Role in the project by account; empty: every account has its role in the workspace."""
    categories: tuple[int, ...] | None
    """Numbers of the selected categories; null: all categories."""
    recordings: tuple[str, ...]
    """Ids of its recordings."""
    tasks: Mapping[TaskState, int]
    """Number of its tasks in each state."""
    people: Mapping[str, Mapping[TaskState, int]]
    """Number of tasks in each state, by the name of the assignee; empty name: not assigned."""


@dataclass(frozen=True, slots=True)
class ClassFigures(Value):
    """Figures of a class."""

    name: str
    """Name of the class."""
    points: int
    """Number of its points."""
    objects: int
    """Number of its labels with points."""
    hours: float
    """Hours of editing, by the class's share of painted points."""


@dataclass(frozen=True, slots=True)
class PersonFigures(Value):
    """Figures of a person."""

    name: str
    """Name of the person."""
    hours: float
    """Hours of editing."""
    edits: int
    """Number of edits."""
    points: int
    """Number of points that their strokes changed."""


@dataclass(frozen=True, slots=True)
class Statistics(Value):
    """Figures of a project, from its edits."""

    recordings: int
    """Number of recordings."""
    labelled_frames: int
    """Number of frames with labelled points."""
    points: int
    """Number of labelled points."""
    objects: int
    """Number of labels with points."""
    hours: float
    """Hours of editing."""
    classes: tuple[ClassFigures, ...]
    """Figures by class, the most points first."""
    people: tuple[PersonFigures, ...]
    """Figures by person, the most hours first."""
