"""Label by example: classifiers, their application, and their doubts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated

from pointbrush.values.base import Body, Rule, Value
from pointbrush.values.kinds import (
    FrameIndex,
    FrameRange,
    PaintId,
    PaintIds,
    SequenceName,
    Uuid,
    Vector,
)

NAME_LENGTH = 128
"""Longest name of a classifier, a class or a model, characters."""
MOST_CLASSES = 64
LARGEST_CELL = 1e6
"""Largest side of a cell of features, metres."""
ClassName = Annotated[str, Rule(min_length=1, max_length=NAME_LENGTH)]
Recordings = Annotated[tuple[SequenceName, ...], Rule(max_length=1000)]


@dataclass(frozen=True, slots=True)
class NewClassifier(Body):
    """A new classifier."""

    name: ClassName
    """Text that people see."""
    recordings: Annotated[tuple[SequenceName, ...], Rule(min_length=1, max_length=1000)]
    """Ids of the recordings whose painted points are its examples, now and later."""
    classes: (
        Annotated[tuple[ClassName, ...], Rule(min_length=1, max_length=MOST_CLASSES)] | None
    ) = None
    """Names of its classes; null: all classes in the palettes of its recordings."""
    model: Annotated[str, Rule(max_length=NAME_LENGTH)] = ""
    """Name of a plug-in or service of this server that replaces the trees; empty: trees."""
    imported: bool = False
    """Learn from imported labels as well."""
    start_from: Recordings = ()
    """Ids of labelled recordings to begin with; the more is painted, the less they count."""


@dataclass(frozen=True, slots=True)
class MoreExamples(Body):
    """Additional recordings to learn from."""

    recordings: Recordings = ()
    """Ids of the recordings; empty: learn again from the known ones."""


@dataclass(frozen=True, slots=True)
class HeldOut(Value):
    """Accuracy of a class in places that the training did not see."""

    accuracy: float | None
    """Expected share of correct points, 0 to 1; null: too few places."""
    places: int
    """Number of its painted places."""


@dataclass(frozen=True, slots=True)
class Classifier(Value):
    """A classifier of the workspace."""

    id: str
    """Name in URLs."""
    name: str
    """Text that people see."""
    classes: tuple[str, ...]
    """Names of its classes; predictions number them from 1."""
    taught_by: Mapping[str, int]
    """Number of its examples, by id of the recording."""
    examples: Mapping[str, int]
    """Number of its examples, by class."""
    score: float | None
    """Expected share of correct points in its recordings, 0 to 1; null: not measured."""
    cell: float
    """Side of a cell of features, metres; 0 before the first training."""
    model: str
    """Name of the model that predicts; empty: trees."""
    imported: bool
    """It learns from imported labels as well."""
    held_out: Mapping[str, HeldOut]
    """Accuracy in held-out places, by class."""
    above: float
    """Default limit of the confidence of labels that it applies, 0 to 1."""
    start_from: tuple[str, ...]
    """Ids of the labelled recordings that it began with."""


@dataclass(frozen=True, slots=True)
class Start(Value):
    """A labelled recording from which a classifier can start."""

    recording: str
    """Id of the recording."""
    classes: tuple[str, ...]
    """Classes that it has labels of."""


@dataclass(frozen=True, slots=True)
class PredictionRequest(Body):
    """Points to predict."""

    classifier: SequenceName
    """Id of the classifier."""
    labels: PaintIds | None = None
    """Ids of the only labels to predict; null: all of its classes."""
    place: Vector | None = None
    """Predict only near this place, source coordinates, metres; null: the whole frame."""


@dataclass(frozen=True, slots=True)
class DoubtPlace(Body):
    """A place as ``GET …/doubt`` lists it."""

    frame: FrameIndex
    """Number of the frame."""
    centre: Vector
    """Point on a surface, source coordinates, metres."""
    radius: Annotated[float, Rule(gt=0, le=LARGEST_CELL, allow_inf_nan=False)]
    """Radius of the place, metres."""


@dataclass(frozen=True, slots=True)
class DoubtAnswer(Body):
    """An answer to a doubt."""

    classifier: SequenceName
    """Id of the classifier."""
    place: DoubtPlace
    """The place that was asked about."""
    class_: PaintId | None = field(default=None, metadata={"alias": "class"})
    """Id of the label to paint; null: none of the classes, or skipped."""
    skip: bool = False
    """Ask no more about the place, but predict it."""


@dataclass(frozen=True, slots=True)
class Application(Body):
    """A classifier to apply to a recording."""

    classifier: SequenceName = ""
    """Id of the classifier."""
    frames: FrameRange = ""
    """Frames ``I:J``; empty: all frames."""
    above: Annotated[float, Rule(ge=0, le=1, allow_inf_nan=False)] | None = None
    """Minimum confidence of points to label, 0 to 1; null: as measured in held-out places."""
    id: Uuid | None = None
    """UUID of the job and of its edit: a repeated call does not begin another job."""


@dataclass(frozen=True, slots=True)
class Place(Value):
    """A doubtful place, where a label teaches most."""

    sequence: str
    """Id of the recording."""
    frame: int
    """Number of the frame."""
    centre: tuple[float, float, float]
    """Point on a surface, source coordinates, metres."""
    radius: float
    """Radius of a stroke there, metres."""
    points: int
    """Number of points in the piece."""
    runs: tuple[tuple[int, int], ...]
    """Runs of these points: first number and length."""
    classes: tuple[str, str]
    """Its two most likely classes, the likelier first."""
    doubt: float
    """Doubt between them, 0 to 1."""
