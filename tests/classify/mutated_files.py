"""Classifier files with changed numbers, read and used: python -m tests.classify.mutated_files.

Runs in a process of its own, since a number that a compiled loop trusts could end it.
"""

from __future__ import annotations

import argparse
import io
import json
import random
import resource
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.classifier import Classifier, Examples, from_file, to_file
from pointbrush.classify.features import feature_names
from pointbrush.classify.forest import probabilities
from pointbrush.classify.options import FeatureOptions, ForestOptions
from pointbrush.errors import BadInputError

WIDTH = len(feature_names(FeatureOptions()))
CELLS = 64
FOREST = ForestOptions(trees=4, copies=1)
MEMORY = 4 * 2**30
"""Bytes of address space that reading and using a file may take."""
EXTREMES = (0, 1, -1, 2**31 - 1, -(2**31), 2**15 - 1, 255, 1e30, float("inf"), float("nan"))


def arrays_of(classifier: Classifier) -> dict[str, NDArray[Any]]:
    with np.load(io.BytesIO(to_file(classifier))) as stored:
        return {name: stored[name].copy() for name in stored}


def taught() -> Classifier:
    rng = np.random.default_rng(1)
    classes = np.arange(120) % 3
    features = rng.normal(0, 1, (120, WIDTH)).astype(np.float32) + classes[:, None]
    examples = Examples(
        features.astype(np.float32), classes.astype(np.uint8), np.arange(120) // 9, np.ones(WIDTH)
    )
    return Classifier("fuzz", ("a", "b", "c"), 0.5, ("r",), {("r", 0): examples}).learnt(FOREST)


def mutate(arrays: dict[str, NDArray[Any]], rng: random.Random) -> None:
    """Change one to three values, or the length or type of an array."""
    for _ in range(rng.randint(1, 3)):
        name = rng.choice(sorted(arrays))
        array = arrays[name]
        kind = rng.random()
        if name == "about":
            about = json.loads(array.tobytes())
            about[rng.choice(sorted(about))] = rng.choice(EXTREMES)
            arrays[name] = np.frombuffer(json.dumps(about).encode(), np.uint8).copy()
        elif kind < 0.08:
            arrays[name] = array[: len(array) // 2]
        elif kind < 0.12:
            arrays[name] = array.astype(rng.choice(["f8", "i8", "u1"]))
        elif array.size:
            at = rng.randrange(array.size)
            with np.errstate(all="ignore"):
                if rng.random() < 0.5:  # a neighbour of the value: most such files are still right
                    array.flat[at] = array.flat[rng.randrange(array.size)]
                else:
                    array.flat[at] = np.array(rng.choice(EXTREMES)).astype(array.dtype)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("first", type=int)
    parser.add_argument("count", type=int)
    given = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    whole = taught()
    features = np.random.default_rng(2).normal(0, 2, (CELLS, WIDTH)).astype(np.float32)
    reached = refused = 0
    for seed in range(given.first, given.first + given.count):
        arrays = arrays_of(whole)
        mutate(arrays, random.Random(seed))
        out = io.BytesIO()
        np.savez(out, **arrays)  # type: ignore[arg-type]  # numpy's stub takes no mapping
        try:
            found = from_file(out.getvalue())
        except BadInputError as error:
            message = str(error)
            refused += message.startswith("classifier: ") and "expected" in message
            continue
        if found.trees is not None:
            probabilities(found.trees, features)
            reached += 1
        if seed % 20 == 0:
            found.learnt(FOREST)
    print(json.dumps({"reached": reached, "refused": refused}))


if __name__ == "__main__":
    main()
