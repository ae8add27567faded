"""Sizes of classes, which complete boxes of partly seen objects."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from pointbrush.errors import BadInputError


@dataclass(frozen=True, slots=True)
class SizePrior:
    """Mean and standard deviation of length, width and height of a class, metres.

    ``person``: upright, without edges, facing the direction of motion.  ``weight``: share of the
    class among all classes that a name may mean.
    """

    name: str
    mean: tuple[float, float, float]
    spread: tuple[float, float, float]
    person: bool = False
    weight: float = 1.0

    def __post_init__(self) -> None:
        """Check the sizes.  Raises BadInputError."""
        for name, values in (("mean", self.mean), ("spread", self.spread)):
            if not (np.isfinite(values).all() and min(values) > 0):
                raise BadInputError(f"{name}: expected 3 numbers above 0 m, got {values}")

    @property
    def standing(self) -> bool:
        """Whether it is a person on foot, higher than long."""
        return self.person and self.mean[2] > 1.5 * self.mean[0]


BUILT_IN: Mapping[str, SizePrior] = {
    prior.name: prior
    for prior in (
        SizePrior("car", (4.45, 1.84, 1.6), (0.4, 0.11, 0.14), weight=0.7),
        SizePrior("van", (5.4, 2.02, 2.2), (0.6, 0.12, 0.28), weight=0.15),
        SizePrior("truck", (9.0, 2.5, 3.2), (2.0, 0.2, 0.4), weight=0.1),
        SizePrior("bus", (11.5, 2.7, 3.2), (1.5, 0.2, 0.25), weight=0.05),
        SizePrior("pedestrian", (0.65, 0.62, 1.7), (0.2, 0.1, 0.15), person=True),
        SizePrior("cyclist", (1.76, 0.6, 1.73), (0.15, 0.1, 0.15), person=True),
        SizePrior("motorcycle", (2.22, 0.86, 1.52), (0.25, 0.15, 0.2), person=True),
        SizePrior("bicycle", (1.72, 0.61, 1.36), (0.2, 0.12, 0.25), person=True),
    )
}
VEHICLES = ("car", "van", "truck", "bus")
TWO_WHEELERS = ("cyclist", "motorcycle", "bicycle")
NAMES: Mapping[str, tuple[str, ...]] = {
    "car": ("car", "cars", "sedan", "suv", "taxi", "automobile", "hatchback"),
    "van": ("van", "vans", "minibus"),
    "truck": ("truck", "trucks", "lorry", "trailer"),
    "bus": ("bus", "buses", "coach"),
    "pedestrian": ("pedestrian", "pedestrians", "person", "people", "human", "walker", "adult",
                   "child"),
    "cyclist": ("cyclist", "cyclists", "rider", "bicyclist", "motorcyclist"),
    "motorcycle": ("motorcycle", "motorcycles", "scooter", "motorbike"),
    "bicycle": ("bicycle", "bicycles", "bike"),
}  # fmt: skip
"""Words of categories that mean a class."""


def priors_of(category: str, names: Iterable[str] = ()) -> list[SizePrior]:
    """Return the priors that a category may mean; an exact name of a class has precedence.

    ``names``: further words, such as the label's name.  A generic vehicle may be a car, a van, a
    truck or a bus; an unknown category may be any class.
    """
    for text in (category, *names):
        if text.casefold() in BUILT_IN:
            return [BUILT_IN[text.casefold()]]
        words = set(re.findall(r"[a-z]+", re.sub(r"([a-z])([A-Z])", r"\1 \2", text).casefold()))
        for kind in (*TWO_WHEELERS, "truck", "bus", "van", "car", "pedestrian"):
            if words & set(NAMES[kind]):
                return [BUILT_IN[kind]]
        if words & {"vehicle", "vehicles"}:
            return [BUILT_IN[kind] for kind in VEHICLES]
    return list(BUILT_IN.values())
