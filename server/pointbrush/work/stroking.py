"""Strokes of all shapes on frames, complete or incremental, and their previews."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pointbrush.labels import Commit, LabelStore
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.annotate.strokes import LiveStroke, edit_id
from pointbrush.work.objects.service import Answer, Level, Objects
from pointbrush.work.objects.stroke import ObjectStroke
from pointbrush.work.part import Part


class Strokes(Part):
    """Strokes on frames."""

    def __init__(
        self, store: LabelStore, recording: Callable[[str], Recording], objects: Objects
    ) -> None:
        """``objects``: for strokes of the shape ``object``."""
        super().__init__(store, recording)
        self._objects = objects

    def begin(
        self, sequence: str, frame: int, brush: Mapping[str, Any], stroke_id: str | None = None
    ) -> LiveStroke | ObjectStroke | Commit:
        """Start an incremental stroke; see LiveStroke.

        For a repeated stroke that is already applied, its commit is returned.
        """
        given = edit_id(stroke_id)
        begun = self._store.begin(sequence, given)
        if isinstance(begun, Commit):
            return begun
        recording = self._recording(sequence)
        if brush.get("shape") == "object":
            return ObjectStroke(self._objects, self._store, recording, frame, brush, given)
        return LiveStroke(self._store, begun, recording, frame, brush, given)

    def apply(self, sequence: str, frame: int, fields: Mapping[str, Any], author: str) -> Commit:
        """Apply a complete stroke (fields of REST) and return when it is durable."""
        live = self.begin(sequence, frame, fields, fields.get("id"))
        if isinstance(live, Commit):
            return live
        live.add(fields.get("samples") or [])
        return live.commit(author)

    def preview(self, sequence: str, frame: int, fields: Mapping[str, Any]) -> Answer:
        """Preview a stroke: levels of an object, or a region of another shape.

        ``fields``: of a stroke, with ``positives`` for its samples.  Raises BadInputError,
        NotFoundError.
        """
        recording = self._recording(sequence)
        if fields.get("shape", "object") == "object":
            return self._objects.answer(recording, frame, self._objects.parse(fields))
        view = self._store.view(sequence)
        live = LiveStroke(self._store, view, recording, frame, fields, edit_id(None))
        live.add(fields.get("positives") or [])
        numbers = live.previewed()
        levels = (Level("", 0, 1.0, numbers),) if len(numbers) else ()
        return Answer(levels, 0, ready=True)
