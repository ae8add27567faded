"""Learnt weights: two forests of boosted trees for each kind of sensor, in one file of the package.

The trees are plain arrays, read by compiled loops; ``benchmarks/train_selection.py`` makes them.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import innermost
from pointbrush.sensor_kind import SENSOR_KINDS, SensorKind

FILE = Path(__file__).with_name("weights.npz")


class Forest(NamedTuple):
    """Trees in shared arrays.

    ``feature`` (n,): int16, -1 for a leaf; ``threshold`` (n,): float32, left if the value is not
    above it; the value of a leaf; ``left``, ``right`` (n,): int32; ``roots`` (trees,): int32.
    """

    feature: NDArray[np.int16]
    threshold: NDArray[np.float32]
    left: NDArray[np.int32]
    right: NDArray[np.int32]
    roots: NDArray[np.int32]


@innermost
def answer(model: Forest, row: NDArray[np.float64]) -> float:
    """Return the sum of the leaves that a row of numbers reaches."""
    feature, threshold, left, right, roots = model
    total = 0.0
    for at in roots:
        while feature[at] >= 0:
            at = left[at] if row[feature[at]] <= threshold[at] else right[at]
        total += threshold[at]
    return total


class Weights(NamedTuple):
    """``merge``: model of pieces being one object; ``value``: model of a candidate's quality."""

    merge: Forest
    value: Forest


@cache
def _shipped() -> Mapping[SensorKind, Weights]:
    return load_weights(FILE)


def built_in(sensor: SensorKind) -> Weights:
    """Return the package's weights for a kind of sensor."""
    return _shipped()[sensor]


def load_weights(path: Path) -> dict[SensorKind, Weights]:
    """Return the weights in a file by the kind of sensor."""
    with np.load(path) as stored:
        return {
            sensor: Weights(_forest(stored, f"{sensor}_merge"), _forest(stored, f"{sensor}_value"))
            for sensor in SENSOR_KINDS
        }


def save_weights(path: Path, weights: Mapping[SensorKind, Weights]) -> None:
    """Write weights; children are stored relative to their node, which compresses better."""
    arrays: dict[str, Any] = {}
    for sensor, pair in weights.items():
        for kind, forest in pair._asdict().items():
            name, nodes = f"{sensor}_{kind}", np.arange(len(forest.feature))
            arrays[f"{name}_feature"] = forest.feature.astype(np.int8)
            arrays[f"{name}_threshold"] = forest.threshold
            arrays[f"{name}_left"] = (forest.left - nodes).astype(np.int16)
            arrays[f"{name}_right"] = (forest.right - nodes).astype(np.int16)
            arrays[f"{name}_roots"] = forest.roots
    np.savez_compressed(path, **arrays)


def _forest(stored: Mapping[str, Any], name: str) -> Forest:
    nodes = np.arange(len(stored[f"{name}_feature"]))
    return Forest(
        stored[f"{name}_feature"].astype(np.int16),
        stored[f"{name}_threshold"].astype(np.float32),
        (stored[f"{name}_left"] + nodes).astype(np.int32),
        (stored[f"{name}_right"] + nodes).astype(np.int32),
        stored[f"{name}_roots"].astype(np.int32),
    )
