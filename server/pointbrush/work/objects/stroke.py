"""A stroke that commits a candidate of the object tool as one edit."""

from __future__ import annotations

import uuid
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, ConflictError
from pointbrush.labels import Commit, LabelStore
from pointbrush.selection import Stroke
from pointbrush.selection.points import near, reach_of
from pointbrush.selection.rigid import inverse, transformed
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.annotate.overlays import placements, require_overlaid
from pointbrush.work.annotate.painted_frame import PaintedFrame
from pointbrush.work.annotate.strokes import write_of
from pointbrush.work.objects.service import Level, Objects

REPLACED = uuid.UUID("6f0a6f9e-7d0e-5a3c-9c77-6f626a656374")
"""Namespace for the id of the undo before a stroke that replaces another one."""


class ObjectStroke:
    """A stroke of the object tool, with the calls of a ``LiveStroke``."""

    def __init__(
        self,
        objects: Objects,
        store: LabelStore,
        recording: Recording,
        frame: int,
        fields: Mapping[str, Any],
        stroke_id: str,
    ) -> None:
        """``fields``: a stroke of REST or the socket, of shape ``object`` without samples.

        In further ``frames`` it selects points at the place of the object's points.  ``replaces``:
        id of this author's last edit, which is undone first, so that an object refined by another
        click remains one edit to undo.  Raises BadInputError, NotFoundError (frame, label),
        LockedLabelError.
        """
        self._objects, self._store, self._recording = objects, store, recording
        self.id, self.frame = stroke_id, frame
        self._brush = Stroke.parse({**fields, "samples": []})
        if self._brush.tool == "restore":
            raise BadInputError("tool: expected paint, erase or delete for an object, got restore")
        if self._brush.tool == "paint":
            store.require_paintable(recording.manifest.id, self._brush.label, self._brush.hidden)
        require_overlaid(recording, frame, self._brush.frames)
        self._placed = placements(store, recording, frame, self._brush.frames)
        self._fields = fields
        self._samples: list[Mapping[str, Any]] = []
        self.touched = 0

    @property
    def changing(self) -> int:
        """Return the number of selected points, which is known only after the commit."""
        return self.touched

    def add(self, samples: Sequence[Mapping[str, Any]]) -> int:
        """Add positive clicks."""
        self._samples.extend(samples)
        return self.touched

    def adding(self, samples: Sequence[Mapping[str, Any]]) -> Iterator[None]:
        """Add positive clicks in one part; see ``LiveStroke.adding``."""
        self.add(samples)
        yield

    def commit(self, author: str) -> Commit:
        """Commit the candidate as one edit and return when it is durable.

        Raises StaleCandidateError, and ConflictError if ``replaces`` is not this author's last
        edit.
        """
        level = self._level()
        self._take_back(author)
        own = level.numbers.astype(np.int64)
        taken = [(self.frame, own), *self._others(own)]
        writes = [(frame, write_of(self._brush, numbers)) for frame, numbers in taken]
        self.touched = sum(len(numbers) for _, numbers in taken)
        sequence = self._recording.manifest.id
        return self._store.apply(
            sequence,
            edit_id=self.id,
            author=author,
            kind=self._brush.tool,
            writes=writes,
            summary=f"{self._brush.tool} an object of {len(own):,} points",
            identity=self._recording.identity,
        )

    def _others(self, own: NDArray[np.int64]) -> Iterator[tuple[int, NDArray[np.int64]]]:
        """Yield the further frames with stored numbers of the points at the same place."""
        xyz = self._recording[self.frame].coordinates[own].astype(np.float64)
        reach = reach_of(xyz) if self._placed[1:] else 0.0
        local = self._brush.to_local(np.asarray(self._recording.manifest.shift, np.float64))
        view = self._store.view(self._recording.manifest.id)
        for placement in self._placed[1:]:
            if self._recording[placement.frame].count:
                painted = PaintedFrame(view, self._recording, placement, self._brush)
                for layer in painted.layers():
                    there = transformed(inverse(layer.T_shown_layer), xyz)
                    found = layer.own(near(layer.points, there, reach))
                    clip = local.placed(inverse(layer.T_shown_layer)).clip
                    yield placement.frame, found if clip is None else clip.of(layer.points, found)

    def _level(self) -> Level:
        fields = self._fields
        clicks = self._objects.parse({**fields, "positives": self._samples})
        candidate, level = fields.get("candidate") or "", fields.get("level")
        return self._objects.take(self._recording, self.frame, clicks, str(candidate), level)

    def _take_back(self, author: str) -> None:
        replaced = self._fields.get("replaces")
        if not replaced:
            return
        sequence = self._recording.manifest.id
        undo_id = str(uuid.uuid5(REPLACED, self.id))
        if self._store.find(sequence, undo_id) is not None:
            return  # a repeated stroke
        last, _ = self._store.stacks(sequence, author)
        if last is None or last.id != replaced:
            raise ConflictError(f"replaces: expected your last edit, got {replaced}")
        self._store.undo(sequence, author, undo_id)
