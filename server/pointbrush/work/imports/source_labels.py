"""Labels that came in the files of a recording → its first edit."""

from __future__ import annotations

import uuid
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.datasets import ClassName
from pointbrush.formats.palette import own_labels, source_dataset
from pointbrush.labels import Label, LabelStore, Write
from pointbrush.labels.palette import Palette
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.imports.choosing import Chosen
from pointbrush.work.imports.importing import IMPORTED, PART_POINTS
from pointbrush.work.imports.naming import Key, Naming, keys_of, learn_numbers


def import_source_labels(store: LabelStore, recording: Recording) -> None:
    """Make the labels that came with the files a first edit, with a palette for them.

    Its id follows from the recording's, so that whoever comes back to it does nothing twice.
    """
    sequence, naming = recording.manifest.id, _naming_of(recording)
    found: set[Key] = set()
    frames: set[int] = set()
    for frame, _, keys, _ in _labelled_parts(recording, naming):
        frames.add(frame)
        found.update(keys)
    if not frames:
        return
    learn_numbers(store, naming, Chosen.of(store.choosing(sequence), found, naming).classes)

    def choose(palette: Palette) -> tuple[Sequence[Label], Iterator[tuple[int, Write]]]:
        chosen = Chosen.of(palette, found, naming)
        return chosen.fresh, (
            (frame, Write(numbers, label=_ids(chosen, keys)[which], provenance=IMPORTED))
            for frame, numbers, keys, which in _labelled_parts(recording, naming)
        )

    store.apply(
        sequence,
        edit_id=str(uuid.uuid5(uuid.NAMESPACE_OID, sequence)),
        author="import",
        kind="import",
        writes=choose,
        summary=f"labels that came with the files, {len(frames)} frames",
        identity=recording.identity,
    )


def _naming_of(recording: Recording) -> Naming:
    sources = [Path(source) for source in recording.manifest.source.split(", ")]
    own = {label.id: label for label in own_labels(sources)}
    dataset = source_dataset(sources)
    words = enumerate(map(ClassName, recording.manifest.classes), start=1)
    if dataset is None:
        return Naming(dict(words), own)
    return Naming({**dataset.classes, **dict(words)}, own, dataset.name)


def _ids(chosen: Chosen, keys: tuple[Key, ...]) -> NDArray[np.uint16]:
    return np.array([chosen.ids[key] for key in keys], np.uint16)


def _labelled_parts(
    recording: Recording, naming: Naming
) -> Iterator[tuple[int, NDArray[np.int64], tuple[Key, ...], NDArray[np.int64]]]:
    """Labelled points, a part of a frame at once: frame, numbers (n,), keys, which (n,) of them.

    A label of ours is an instance already.
    """
    for frame in recording:
        if frame.label is None:
            continue
        instances = frame.instance is not None and not naming.own
        for first in range(0, frame.count, PART_POINTS):
            last = min(first + PART_POINTS, frame.count)
            label = frame.read("label", first, last)
            numbers = np.flatnonzero(label)
            if len(numbers):
                instance = (
                    frame.read("instance", first, last)[numbers].astype(np.int64)
                    if instances
                    else np.zeros(len(numbers), np.int64)
                )
                keys, which = keys_of(label[numbers].astype(np.int64), instance)
                yield frame.index, numbers + first, keys, which
