"""Mounts of the sensors of a bag, by its transforms.

``/tf_static`` holds fixed transforms.  Older publishers repeat them on ``/tf``, among moving ones:
only transforms that are the same in all messages of a bag are mounts.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from pointbrush.formats.cameras.pictures import Matrix
from pointbrush.formats.geometry.poses import of_quaternion
from pointbrush.formats.ros.bag import Bag, BagMessage, Topic
from pointbrush.formats.ros.message import TRANSFORMS, cut_off, kind_of, reader_of

MAX_TRANSFORMS = 100_000
SAME = 1e-6
"""Greatest difference of matrices that count as equal, metres for the last column."""

Parents = dict[str, tuple[str, Matrix]]


def mounts(bag: Bag, path: Path, topics: Sequence[Topic]) -> Callable[[str, str], Matrix | None]:
    """Find ``T_to_from`` of two frame ids by the transforms of a bag that stay the same.

    Raises BadInputError for a message that is cut off.
    """
    parents: Parents = {}
    for name in ("tf", "tf_static"):
        for topic in topics:
            if kind_of(topic.type) == TRANSFORMS and topic.name.strip("/") == name:
                parents |= _constant(bag, path, topic)
    return partial(_between, parents)


def _constant(bag: Bag, path: Path, topic: Topic) -> Parents:
    """Return parent and ``T_parent_child`` of each child with a constant transform."""
    parents: Parents = {}
    moving: set[str] = set()
    for message in bag.messages(path, topic.name):
        for child, parent, matrix in _of_message(f"{path.name} {topic.name}", message):
            known = parents.get(child)
            if known is None and len(parents) < MAX_TRANSFORMS:
                parents[child] = (parent, matrix)
            elif known and (known[0] != parent or np.abs(known[1] - matrix).max() > SAME):
                moving.add(child)
    return {child: found for child, found in parents.items() if child not in moving}


def _of_message(name: str, message: BagMessage) -> Iterator[tuple[str, str, Matrix]]:
    """(child, parent, T_parent_child) of a message."""
    try:
        reader = reader_of(name, message)
        for _ in range(reader.number("I")):
            _, parent = reader.head()
            child = reader.text()
            yield child.strip("/"), parent.strip("/"), of_quaternion(name, reader.floats(7))
    except struct.error:
        raise cut_off(name, TRANSFORMS, message) from None


def _between(parents: Parents, target: str, source: str) -> Matrix | None:
    """``T_target_source``, or None where the tree does not connect them."""
    target, source = target.strip("/"), source.strip("/")
    up_source, up_target = _to_ancestors(parents, source), _to_ancestors(parents, target)
    common = next((frame for frame in up_source if frame in up_target), None)
    if common is None:
        return None
    return np.asarray(np.linalg.inv(up_target[common]) @ up_source[common])


def _to_ancestors(parents: Parents, frame: str) -> dict[str, Matrix]:
    """``T_ancestor_frame`` of a frame and all above it; a circle ends."""
    found = {frame: np.eye(4)}
    while frame in parents:
        parent, matrix = parents[frame]
        if parent in found:
            break
        found[parent] = matrix @ found[frame]
        frame = parent
    return found
