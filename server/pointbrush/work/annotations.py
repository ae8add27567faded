"""Layers of annotated frames, read and replaced, in source order."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.labels import Commit
from pointbrush.labels.versions import PastLabels
from pointbrush.work import exporting
from pointbrush.work.annotate import layers
from pointbrush.work.annotate.strokes import edit_id
from pointbrush.work.part import Part


class Annotations(Part):
    """Annotation of each point of a frame: a label, a provenance, whether it is deleted.

    Arrays are in source order.
    """

    def read(self, sequence: str, frame: int, layer: str = "label") -> tuple[NDArray[Any], int]:
        """Return a layer of a frame's annotation (N,), and the frame's last changed revision."""
        blocks, revision = self.blocks(sequence, frame, layer)
        return np.concatenate(list(blocks)), revision

    def blocks(
        self,
        sequence: str,
        frame: int,
        layer: str = "label",
        past: PastLabels | None = None,
        *,
        stored: bool = False,
    ) -> tuple[Iterator[NDArray[Any]], int]:
        """Return the same in consecutive blocks, of which a frame stored as an octree has many.

        ``past``: labels of a version, with its revision.  ``stored``: in stored order.
        """
        recording, store = self._recording(sequence), past or self._store
        if stored:
            count = recording[frame].count
            kept = layers.KeptAnnotation(store, sequence, frame, (layer,))
            firsts = range(0, max(count, 1), layers.READ_POINTS)
            parts = (kept.read(at, min(at + layers.READ_POINTS, count)) for at in firsts)
            return (part[layer] for part in parts), kept.revision
        return exporting.layer_blocks(store, recording, frame, layer)

    def put(
        self,
        sequence: str,
        frame: int,
        array: NDArray[Any],
        *,
        author: str,
        layer: str = "label",
        if_match: int | None = None,
        edit: str | None = None,
    ) -> Commit:
        """Replace a layer of a frame's annotation, as one edit.

        ``if_match``: a revision since which the frame must not have changed.
        Raises BadInputError (shape, dtype, unknown labels), LockedLabelError, ConflictError.
        """
        match = None if if_match is None else (frame, if_match)
        summary = f"annotation of frame {frame}"
        return self._replace(sequence, {frame: array}, layer, summary, author, match, edit)

    def put_many(
        self,
        sequence: str,
        arrays: Mapping[int, NDArray[Any]],
        *,
        author: str,
        layer: str = "label",
        edit: str | None = None,
    ) -> Commit:
        """Replace a layer in several frames, ``arrays`` by frame, as one edit.

        Raises the errors of ``put``; then no frame has changed.
        """
        summary = f"annotation of {len(arrays)} frames"
        return self._replace(sequence, arrays, layer, summary, author, None, edit)

    def _replace(
        self,
        sequence: str,
        arrays: Mapping[int, NDArray[Any]],
        layer: str,
        summary: str,
        author: str,
        if_match: tuple[int, int] | None,
        edit: str | None,
    ) -> Commit:
        recording = self._recording(sequence)
        writes = [
            layers.replacement(self._store, recording, frame, layer, array)
            for frame, array in arrays.items()
        ]
        return self._store.apply(
            sequence,
            edit_id=edit_id(edit),
            author=author,
            kind="import",
            writes=chain.from_iterable(writes),
            summary=summary,
            if_match=if_match,
            identity=recording.identity,
        )

    def changed(self, sequence: str, frame: int, commit: Commit) -> int:
        """Return the revision of a frame's last change up to ``commit``."""
        if frame in commit.frames:
            return commit.revision
        # Later changes by others must not count as seen by the caller.
        return min(commit.revision, self._store.changed(sequence, frame))
