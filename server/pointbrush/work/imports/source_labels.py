"""Import of labels from the files of a recording as an edit, and failures of it."""

from __future__ import annotations

import uuid
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.tables.datasets import DATASETS, ClassName
from pointbrush.formats.tables.palette import SourceLabel
from pointbrush.labels import Label, Write
from pointbrush.labels.classes.palette import Palette
from pointbrush.labels.types import IMPORTED
from pointbrush.sequences import Manifest
from pointbrush.sequences import Sequence as Recording
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.work.imports.choosing import Chosen
from pointbrush.work.imports.importing import PART_POINTS
from pointbrush.work.imports.naming import Key, Naming, keys_of, learn_numbers

INTERRUPTED = "their import was interrupted"


class SourceLabels:
    """Imports the labels in the files of recordings, and keeps the reasons of failures."""

    def __init__(self, store: WorkspaceStore) -> None:
        self._store = store
        self._reasons: dict[str, str] = {}  # by identity

    def import_into(self, recording: Recording, author: str = "import") -> list[str]:
        """Commit the labels in the files as an edit, once; raises the error of a failure.

        Returns warnings about labels that are left out.
        """
        if "label" not in recording.manifest.fields:
            return []
        identity = recording.identity
        try:
            warnings = import_source_labels(self._store, recording, author)
        except Exception as error:
            self._reasons[identity] = str(error) or type(error).__name__
            raise
        self._reasons.pop(identity, None)
        return warnings

    def missing(self, manifests: Iterable[Manifest]) -> dict[str, str]:
        """Return reasons for missing labels by ids of recordings; raises UnavailableError.

        The journal shows imported labels; unfinished imports are not included.
        """
        found = {each.id: each for each in manifests if "label" in each.fields}
        edits = {sequence: edit_of(manifest) for sequence, manifest in found.items()}
        without = edits.keys() - self._store.having(edits) if edits else set()
        if without:
            without -= self._store.guards.importing()
        return {each: self._reasons.get(found[each].identity, INTERRUPTED) for each in without}


def edit_of(manifest: Manifest) -> str:
    """Return the id of the edit with a recording's own labels, equal for every attempt."""
    return str(uuid.uuid5(uuid.NAMESPACE_OID, manifest.imported_as))


def source_labels_summary(frames: int) -> str:
    """Return the summary of the edit with these labels."""
    return f"labels that came with the files, {frames} frames"


def import_source_labels(store: WorkspaceStore, recording: Recording, author: str) -> list[str]:
    """Commit the labels in the files as an edit that also adds their palette.

    An edit without labelled points is also committed, as a mark of success.  Returns warnings.
    """
    sequence = recording.manifest.id
    naming = _naming_of(recording.manifest).in_workspace(store)
    found: set[Key] = set()
    frames: set[int] = set()
    for frame, _, keys, _ in _labelled_parts(recording, naming):
        frames.add(frame)
        found.update(keys)
    chosen = Chosen.of(store.choosing(sequence), found, naming)
    learn_numbers(store, naming, chosen.classes)

    def choose(palette: Palette) -> tuple[Sequence[Label], Iterator[tuple[int, Write]]]:
        nonlocal chosen
        chosen = Chosen.of(palette, found, naming)
        return chosen.fresh, _writes(recording, naming, chosen)

    store.apply(
        sequence,
        edit_id=edit_of(recording.manifest),
        author=author,
        kind="import",
        writes=choose,
        summary=source_labels_summary(len(frames)),
        identity=recording.identity,
    )
    return chosen.warnings()


def _writes(recording: Recording, naming: Naming, chosen: Chosen) -> Iterator[tuple[int, Write]]:
    for frame, numbers, keys, which in _labelled_parts(recording, naming):
        label = _ids(chosen, keys)[which]
        kept = label > 0
        if kept.any():
            yield frame, Write(numbers[kept], label=label[kept], provenance=IMPORTED)


def _naming_of(manifest: Manifest) -> Naming:
    own = {label.id: label for label in (SourceLabel(**each) for each in manifest.palette)}
    words = dict(enumerate(map(ClassName, manifest.classes), start=1))
    known = DATASETS[manifest.dataset].classes if manifest.dataset else {}
    return Naming({**known, **words}, own, manifest.dataset)


def _ids(chosen: Chosen, keys: tuple[Key, ...]) -> NDArray[np.uint16]:
    return np.array([chosen.ids[key] for key in keys], np.uint16)


def _labelled_parts(
    recording: Recording, naming: Naming
) -> Iterator[tuple[int, NDArray[np.int64], tuple[Key, ...], NDArray[np.int64]]]:
    """Yield labelled points of parts of frames: frame, numbers (n,), keys, indices (n,) of keys.

    A label of a pointbrush export is an instance already.
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
