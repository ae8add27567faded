"""A stroke on one frame or several: the selected points, and the writes of its tool."""

from __future__ import annotations

import uuid
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, ConflictError
from pointbrush.labels import Commit, LabelStore, View, Write
from pointbrush.labels.types import PAINTED, Only
from pointbrush.ranges import numbers_of
from pointbrush.selection import Stroke
from pointbrush.selection.selecting import OverlaySelector
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.annotate.overlays import placements, require_overlaid
from pointbrush.work.annotate.painted_frame import PaintedFrame


def edit_id(given: object) -> str:
    """Return a stroke's UUID in its normal form, or a new one if none is given."""
    if given is None:
        return str(uuid.uuid4())
    try:
        return str(uuid.UUID(str(given)))
    except ValueError:
        raise BadInputError(f"id: expected a UUID, got {str(given)[:80]!r}") from None


class LiveStroke:
    """A stroke while it is drawn; ``commit`` makes it one durable edit."""

    def __init__(
        self,
        store: LabelStore,
        view: View,
        recording: Recording,
        frame: int,
        fields: Mapping[str, Any],
        stroke_id: str,
    ) -> None:
        """``fields``: a stroke of REST or the socket without samples, in source coordinates.

        ``view``: of the recording's current labels.

        Raises BadInputError, NotFoundError (frame, label), LockedLabelError, HiddenLabelError.
        """
        self._store, self._view, self._recording = store, view, recording
        self.id, self.frame = stroke_id, frame
        self._source_brush = Stroke.parse({**fields, "samples": []})
        self._shift = np.asarray(recording.manifest.shift, np.float64)
        self._brush = self._source_brush.to_local(self._shift)
        if self._brush.tool == "paint":
            view.require_paintable(self._brush.label, self._brush.hidden)
        require_overlaid(recording, frame, self._brush.frames)
        self._painted = [
            PaintedFrame(view, recording, placement, self._brush)
            for placement in placements(store, recording, frame, self._brush.frames)
            if recording[placement.frame].count
        ]
        if not self._painted:
            raise BadInputError(f"frame {frame}: expected points to paint, the frame is empty")
        layers = [(one, layer) for one in self._painted for layer in one.layers()]
        self._of_layer = [one for one, _ in layers]
        self._selector = OverlaySelector([layer for _, layer in layers], self._brush)
        for k, numbers in self._selector.begun():
            self._of_layer[k].take(numbers)
        self._sampled = False

    def add(self, samples: Sequence[Mapping[str, Any]]) -> int:
        """Add samples (``origin``, ``direction``) and return the number of touched points.

        Raises DamagedError if the frame's files were truncated.
        """
        for _ in self.adding(samples):
            pass
        return self.touched

    def adding(self, samples: Sequence[Mapping[str, Any]]) -> Iterator[None]:
        """Add samples part by part; the caller can run other work between two parts."""
        for one in self._painted:
            one.look()
        self._view.look()
        if self._brush.tool == "paint":
            # A stroke fails once its label is locked, hidden or deleted.
            self._view.require_paintable(self._brush.label, self._brush.hidden)
        stroke = self._source_brush.with_samples(samples).to_local(self._shift)
        self._sampled = self._sampled or len(samples) > 0
        for one in self._painted:
            one.renew()
        for k, fresh in self._selector.add(stroke):
            self._of_layer[k].take(fresh)
            yield

    def replace(self, touched: Sequence[tuple[int, bytes]]) -> None:
        """Replace the selection by points of the client, given as a frame and ``runs``.

        Raises BadInputError if they are not points of the stroke's frames.
        """
        frames = {one.frame: one for one in self._painted}
        for one in self._painted:
            one.clear()
        for frame, runs in touched:
            if frame not in frames:
                raise BadInputError(f"touched: expected frames {sorted(frames)}, got {frame}")
            frames[frame].take(numbers_of(runs, len(self._recording[frame])))

    @property
    def touched(self) -> int:
        """Return the number of selected points."""
        return sum(len(one.taken) for one in self._painted)

    @property
    def changing(self) -> int:
        """Return the number of selected points that the stroke will change; reads the store."""
        return sum(one.changing for one in self._painted)

    def previewed(self) -> NDArray[np.int64]:
        """Return ascending numbers of points in its own frame that the stroke would change."""
        own = [one.changing_numbers() for one in self._painted if one.frame == self.frame]
        return np.concatenate([np.empty(0, np.int64), *own])

    def commit(self, author: str) -> Commit:
        """Commit the stroke as one edit and return when it is durable."""
        if not self._sampled and self._brush.kind.sampled:
            raise BadInputError(
                f"samples: expected at least one for shape '{self._brush.shape}', got none"
            )
        return self._store.apply(
            self._recording.manifest.id,
            edit_id=self.id,
            author=author,
            kind=self._brush.tool,
            writes=self._writes(),
            summary=self._summary,
            identity=self._recording.identity,
        )

    def _writes(self) -> Iterator[tuple[int, Write]]:
        if not self.touched:  # an empty write, so that the label is still checked
            yield self.frame, write_of(self._brush, np.empty(0, np.int64))
        for one in self._painted:
            for numbers in one.taken.parts():
                yield one.frame, write_of(self._brush, numbers)

    def _summary(self, points: int, frames: int) -> str:
        label = self._view.palette().get(self._brush.label)
        what = f" as '{label.name}'" if label and self._brush.tool == "paint" else ""
        where = f" in {frames} frames" if frames > 1 else ""
        return f"{self._brush.tool} {points:,} points{what}{where}"


def write_of(brush: Stroke, numbers: NDArray[np.int64]) -> Write:
    """Build the write of a brush to stored numbers (n,)."""
    # The edit's commit checks deleted and hidden points, as they may change until then; the order
    # of the journal decides.
    only: Only = "unlabeled" if brush.only_unlabeled else "any"
    hidden = brush.hidden
    match brush.tool:
        case "paint":
            return Write(
                numbers,
                label=brush.label,
                provenance=PAINTED,
                only=only,
                living=True,
                hidden=hidden,
            )
        case "erase":
            # A person has marked these points as unlabeled: tracking must not label them again.
            return Write(
                numbers, label=0, provenance=PAINTED, only="labeled", living=True, hidden=hidden
            )
        case "delete":
            return Write(numbers, deleted=True, only=only, living=True, hidden=hidden)
        case "restore":
            # Deleted points are shown without regard to hidden labels.
            return Write(numbers, deleted=False, living=False)
    raise ConflictError(f"tool: expected a known tool, got {brush.tool!r}")
