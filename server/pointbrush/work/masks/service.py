"""Labels of a frame's points from masks of its pictures, and masks from labels."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.formats.masks.png import VOID_8_BIT
from pointbrush.labels import Label, LabelStore, Write
from pointbrush.labels.classes.palette import Palette
from pointbrush.labels.plans import Writes
from pointbrush.labels.types import IMPORTED, PAINTED, PREDICTED, Only
from pointbrush.masks import LiftOptions, draw, lift
from pointbrush.masks.models import MaskModels, Prompt
from pointbrush.sequences import Sequence as Recording
from pointbrush.values.masks import VOID, MaskEdit, MaskPrompt, MaskSource
from pointbrush.work.annotate.layers import KeptAnnotation
from pointbrush.work.annotate.strokes import edit_id
from pointbrush.work.masks.classes import Classes, chosen_labels
from pointbrush.work.masks.pictures import picture_of
from pointbrush.work.masks.views import lattice_pixels, size_of, view_of
from pointbrush.work.part import Part

Mask = NDArray[np.unsignedinteger]
RULES: Mapping[str, tuple[int, Only]] = {
    "imported": (IMPORTED, "not_painted"),
    "predicted": (PREDICTED, "predictable"),
    "painted": (PAINTED, "any"),
}
"""Provenance of points by the source of a mask, and the points that it may change."""
BACKGROUND = 65534
"""Value that stands for a named value 0, which otherwise means no mask; no mask of labels has it
by chance."""
SUREST = 255
"""Confidence of a predicted point without a confidence of its own."""
_DEFAULTS = LiftOptions()


def lifted(
    recording: Recording,
    frame: int,
    masks: Mapping[str, Mask],
    options: LiftOptions = _DEFAULTS,
) -> NDArray[np.int32]:
    """Return the value (N,) of masks by camera at each point, stored order: see ``masks.lift``.

    Raises NotFoundError (camera), BadInputError (size, no calibration).
    """
    views = [(view_of(recording, frame, camera), mask) for camera, mask in masks.items()]
    return lift(views, recording[frame].xyz, options)


class Masks(Part):
    """Masks by camera and frame; a mask is an image (H, W) of whole numbers."""

    def __init__(
        self, store: LabelStore, recording: Callable[[str], Recording], models: MaskModels
    ) -> None:
        """``models``: those that find masks in pictures."""
        super().__init__(store, recording)
        self._models = models

    def predict(
        self, sequence: str, frame: int, camera: str, prompt: MaskPrompt, *, author: str
    ) -> MaskEdit:
        """Label the points seen in masks that a model finds in a picture, as one edit.

        Raises NotFoundError (camera, nothing found), BadInputError (model, calibration),
        UnavailableError (no answer of the model), LockedLabelError.
        """
        recording = self._recording(sequence)
        view_of(recording, frame, camera)  # raises before the model is called
        clicks = (np.reshape(each, (-1, 2)) for each in (prompt.positives, prompt.negatives))
        positives, negatives = (np.asarray(each, np.float64) for each in clicks)
        picture = picture_of(recording, frame, camera)
        found = self._models.masks(prompt.model, Prompt(picture, positives, negatives, prompt.text))
        if not found.mask.any():
            raise NotFoundError(
                f"model {prompt.model}: expected an object in the picture of {camera!r}, found none"
            )
        classes = {
            value: name if prompt.label is None else prompt.label
            for value, name in enumerate(found.names, 1)
        }
        return self.set_mask(
            sequence, frame, {camera: found.mask}, classes,
            author=author, edit=prompt.id, source="predicted",
        )  # fmt: skip

    def set_mask(
        self,
        sequence: str,
        frame: int,
        masks: Mapping[str, Mask],
        classes: Classes | None = None,
        *,
        author: str,
        edit: str | None = None,
        source: MaskSource = "imported",
    ) -> MaskEdit:
        """Label the points seen in masks by camera, as one edit; several cameras vote.

        ``classes``: label id or name of a label or class for each value; 0 removes labels.  Without
        it the values are label ids, and VOID (of 8 bits: 255) says nothing.  Values that it does
        not name change nothing.  A predicted mask adds labels of classes that the workspace lacks.
        Painted points keep their labels, unless the mask is painted; points of locked labels do.
        Raises NotFoundError, BadInputError (size, classes), LockedLabelError.
        """
        recording = self._recording(sequence)
        masks = {camera: _wide(mask, classes) for camera, mask in masks.items()}
        values = lifted(recording, frame, masks)
        meant, create = used_classes(masks, classes), source == "predicted"
        chosen_labels(self._store.choosing(sequence), meant, create=create)
        seen = np.isin(values, [*meant])
        numbers = np.flatnonzero(seen)
        provenance, only = RULES[source]

        def choose(palette: Palette) -> tuple[Sequence[Label], Writes]:
            ids, added = chosen_labels(palette, meant, create=create)
            label = ids[values[numbers]]
            write = Write(
                numbers,
                label=label,
                provenance=np.where(label > 0, provenance, _cleared(source)).astype(np.uint8),
                confidence=np.where(label > 0, SUREST, 0) if source == "predicted" else None,
                only=only,
                living=True,
                hidden=frozenset(),
            )
            return added, {frame: write}

        cameras = ", ".join(f"'{name}'" for name in masks)
        commit = self._store.apply(
            sequence,
            edit_id=edit_id(edit),
            author=author,
            kind="prediction" if source == "predicted" else "import",
            writes=choose,
            summary=f"mask of {cameras}, frame {frame}"[:200],
            identity=recording.identity,
        )
        return MaskEdit.of(commit, seen=len(numbers), doubt=int((values < 0).sum()))

    def pixel(self, sequence: str, frame: int) -> NDArray[np.uint16] | None:
        """Return row and column (N, 2) of points in the depth image, source order, or None."""
        stored = self._recording(sequence)[frame]
        found = lattice_pixels(stored)
        if found is None:
            return None
        (width, _), pixel = found
        return stored.to_source(np.stack(np.divmod(pixel, width), axis=1).astype(np.uint16))

    def size(self, sequence: str, frame: int, camera: str) -> tuple[int, int]:
        """Return width and height of a camera's picture; raises NotFoundError."""
        return size_of(self._recording(sequence), frame, camera)

    def mask_of(self, sequence: str, frame: int, camera: str) -> tuple[Mask, int]:
        """Return the labels of a frame in a camera's picture (H, W) uint16, and its revision.

        VOID: no point is seen there.  Raises NotFoundError, BadInputError (no calibration).
        """
        recording = self._recording(sequence)
        count = recording[frame].count
        kept = KeptAnnotation(self._store, sequence, frame, ("label", "deleted"))
        layers = kept.read(0, count)
        view = view_of(recording, frame, camera).without(layers["deleted"])
        return draw(view, layers["label"]), kept.revision


def _wide(mask: Mask, classes: Classes | None) -> Mask:
    """Return a mask (H, W) uint16 in which VOID is 65535, and a named value 0 is BACKGROUND."""
    named = classes or {}
    wide = mask.astype(np.uint16)
    if mask.dtype == np.uint8 and VOID_8_BIT not in named:
        wide[mask == VOID_8_BIT] = VOID
    if 0 in named:
        wide[mask == 0] = BACKGROUND
    return wide


def used_classes(masks: Mapping[str, Mask], classes: Classes | None) -> Classes:
    """Return the label or class of each value of masks; raises BadInputError if none has one."""
    used = {int(value) for mask in masks.values() for value in np.unique(mask)} - {0, VOID}
    meant: dict[int, int | str] = {value: value for value in used}
    if classes is not None:
        meant = dict(classes)
    if 0 in meant:
        meant[BACKGROUND] = meant.pop(0)
    if not used & meant.keys():
        named = ", ".join(map(str, sorted(used)[:10])) or "only 0"
        expected = "label ids" if classes is None else ", ".join(map(str, sorted(meant)[:10]))
        raise BadInputError(f"mask: expected pixels of values {expected}, got {named}")
    return meant


def _cleared(source: MaskSource) -> int:
    """Return the provenance of a point that a mask removes the label of."""
    return PAINTED if source == "painted" else 0
