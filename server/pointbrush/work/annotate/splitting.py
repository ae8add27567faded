"""Splitting a label's points in one frame into one label per connected part, as one edit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import ConflictError
from pointbrush.labels import Commit, Label, LabelStore, Write
from pointbrush.labels.classes.palette import Palette, default_color
from pointbrush.labels.types import PAINTED
from pointbrush.selection.cluster import connected_parts, usual_gap
from pointbrush.values.edits import Split
from pointbrush.work.annotate.strokes import edit_id
from pointbrush.work.part import Part

MOST_PARTS = 64
"""Limit of parts with a label; further parts stay with the largest one."""
LEAST_POINTS = 10


class Splitting(Part):
    """Splits of a label into its connected parts."""

    def split(
        self,
        sequence: str,
        author: str,
        label_id: int,
        frame: int,
        *,
        edit: str | None = None,
        gap: float | None = None,
        least: int = LEAST_POINTS,
    ) -> Split:
        """Give each connected part of a label in a frame a new label; the largest part keeps it.

        Parts of fewer than ``least`` points stay with the largest.  ``gap``: metres between parts;
        None: derived from the spacing of the points.

        Raises NotFoundError, LockedLabelError, and ConflictError when the points are one part.
        """
        recording, store, edit = self._recording(sequence), self._store, edit_id(edit)
        repeated = store.find(sequence, edit)
        if repeated is not None:
            return _repeated(store, repeated, frame, gap)
        label = store.label(sequence, label_id)
        store.require_paintable(sequence, label_id)
        values = store.values(sequence, frame)
        numbers = np.flatnonzero((values.label == label_id) & ~values.deleted)
        xyz = recording[frame].coordinates[numbers]
        wide = usual_gap(xyz) if gap is None else gap
        part = connected_parts(xyz, wide)
        counts = np.bincount(part, minlength=1)
        parts = [int(k) for k in np.flatnonzero(counts >= least) if 0 < k < MOST_PARTS]
        if not parts:
            raise ConflictError(
                f"label: expected '{label.name}' to have parts of {least} points or more in frame "
                f"{frame} with {wide:.3g} m between them, got one"
            )
        fresh: Sequence[Label] = ()

        def choose(palette: Palette) -> tuple[Sequence[Label], dict[int, Write]]:
            nonlocal fresh
            fresh = _new_labels(palette, label, len(parts))
            return fresh, {frame: _write(numbers, part, parts, fresh)}

        commit = store.apply(
            sequence,
            edit_id=edit,
            author=author,
            kind="paint",
            writes=choose,
            summary=f"split '{label.name}' into {len(parts) + 1} parts",
            if_match=(frame, values.revision),
            identity=recording.identity,
        )
        return _result(commit, fresh, wide)


def _repeated(store: LabelStore, commit: Commit, frame: int, gap: float | None) -> Split:
    """Return the result of a repeated split."""
    delta = commit.frames.get(frame)
    ids = set() if delta is None else set(np.unique(delta.label).tolist())
    labels = [label for label in store.palette(commit.sequence) if label.id in ids]
    return _result(commit, labels, gap or 0.0)


def _result(commit: Commit, labels: Sequence[Label], gap: float) -> Split:
    return Split.of(commit, labels=tuple(label.id for label in labels), gap=gap)


def _write(
    numbers: NDArray[np.int64], part: NDArray[np.int64], parts: list[int], fresh: Sequence[Label]
) -> Write:
    """Build the write that gives the points (n,) of ``parts`` their new labels."""
    of_part = np.zeros(int(part.max()) + 1, np.uint16)
    of_part[parts] = [label.id for label in fresh]
    label = of_part[part]
    moved = label > 0
    return Write(numbers[moved], label=label[moved], provenance=PAINTED, living=True)


def _new_labels(palette: Palette, label: Label, count: int) -> list[Label]:
    """Return new labels named after the split label, with free ids, names and colours."""
    names, ids = {one.name for one in palette.labels}, palette.free_ids()
    made: list[Label] = []
    stem, _, last = label.name.rpartition(" ")
    stem = stem if stem and last.isdigit() else label.name
    number = 2
    for _ in range(count):
        while f"{stem} {number}" in names:
            number += 1
        called = (f"{stem} {number}", label.category)
        names.add(called[0])
        fresh = ids.take(called)
        made.append(Label(fresh, *called, default_color(fresh)))
    return made
