"""Bounds of what classifiers may take, and a person's choices for applying one."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any

from pointbrush.classify.options import DoubtOptions, FeatureOptions, ForestOptions
from pointbrush.errors import BadInputError
from pointbrush.options import choice


@dataclass(frozen=True, slots=True)
class ClassifierOptions:
    """Sizes and counts; all above 0."""

    features: FeatureOptions = field(default_factory=FeatureOptions)
    forest: ForestOptions = field(default_factory=ForestOptions)
    doubt: DoubtOptions = field(default_factory=DoubtOptions)
    memory_bytes: int = 384 * 2**20
    """Described frames that are kept, bytes."""
    whole_points: int = 2_000_000
    """Points of the largest frame that is described at once; larger ones piece by piece."""
    view_points: int = 1_000_000
    """Points round a place of a larger one that are described to be looked at."""
    piece_points: int = 1_000_000
    """Points of a piece at most, without its margin."""
    margin: float = 48.0
    """Cells round a piece that are described with it."""
    frame_examples: int = 8_000
    """Examples of a frame at most, the classes alike."""
    taught_frames: int = 24
    """Painted frames of a recording that teach at most, evenly chosen."""
    taught_places: int = 16
    """Places of a large frame that teach at most."""
    taught_points: int = 200_000
    """Points round such a place that are described."""
    looked_frames: int = 6
    """Frames of a recording in which doubt is looked for."""
    looked_recordings: int = 4
    """Recordings of a workspace in which doubt is looked for."""

    def check(self) -> None:
        """Raise BadInputError for a number that is not above 0."""
        for part in (self.features, self.forest, self.doubt):
            part.check()
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, int | float) and not value > 0:
                raise BadInputError(f"{each.name}: expected a number above 0, got {value!r}")


@dataclass
class ApplyOptions:
    """Choices for applying a classifier, each with its help.

    Raises BadInputError.
    """

    classifier: str = choice("", "id of the classifier")
    frames: str = choice("", "frames I:J (default: all)")
    above: float = choice(0.0, "minimum confidence of points to label, 0 to 1")

    def __post_init__(self) -> None:
        if not 0 <= self.above <= 1:
            raise BadInputError(f"above: expected a confidence from 0 to 1, got {self.above}")

    @classmethod
    def of(cls, source: object) -> dict[str, Any]:
        """Return the choices as ``source``'s attributes have them, by name."""
        return {each.name: getattr(source, each.name) for each in fields(cls)}
