"""Base class of all options: frozen values, validated at construction."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import ClassVar

import numpy as np

from pointbrush.errors import BadInputError

PositiveInt = int
PositiveFloat = float
"""Types of fields used as divisors: above zero."""


class Options:
    """Numbers of a step, each with its unit in its name or comment."""

    __slots__ = ()
    signed: ClassVar[frozenset[str]] = frozenset()
    """Fields that may be below zero; all fields if ``all_signed``."""
    all_signed: ClassVar[bool] = False
    above_one: ClassVar[frozenset[str]] = frozenset()
    """Shares that may exceed 1."""

    def __post_init__(self) -> None:
        """Check the values; raises BadInputError."""
        self.check()

    def check(self) -> None:
        """Raise BadInputError for the first invalid field, with its valid values."""
        for each in fields(self):  # type: ignore[arg-type]
            value = getattr(self, each.name)
            if isinstance(value, Options):
                continue
            low, high = self._bounds(each.name)
            integral, positive = "int" in str(each.type).lower(), "Positive" in str(each.type)
            expected = "a whole number" if integral else "a number"
            numbers = value if str(each.type).startswith("tuple") else (value,)
            kinds = int if integral else (int, float)
            good = isinstance(numbers, tuple) and all(
                isinstance(number, kinds)
                and not isinstance(number, bool)
                and math.isfinite(number)
                and low <= number <= high
                and not (positive and number == 0)
                for number in numbers
            )
            if not good:
                least = "above 0" if positive else f"from {low:g}"
                raise BadInputError(
                    f"{type(self).__name__}.{each.name}: expected {expected} {least} to {high:g}, "
                    f"got {value!r}"
                )

    def _bounds(self, name: str) -> tuple[float, float]:
        if self.all_signed or name in self.signed:
            return -math.inf, math.inf
        if name.endswith("_cos"):
            return -1.0, 1.0
        if name.endswith("_share") and name not in self.above_one:
            return 0.0, 1.0
        return 0.0, math.inf


class Weights(Options):
    """Weights of features of the same names: log odds per unit of the feature."""

    __slots__ = ()
    all_signed: ClassVar[bool] = True

    def odds(self, features: Mapping[str, float]) -> float:
        """Return the log odds of the named ``features``; features without a weight are ignored."""
        names = [each.name for each in fields(self)]  # type: ignore[arg-type]
        weights = np.array([getattr(self, name) for name in names], np.float64)
        return float(weights @ np.array([features[name] for name in names], np.float64))
