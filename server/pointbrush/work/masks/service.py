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
from pointbrush.labels.types import FULL_CONFIDENCE, IMPORTED, PAINTED, PREDICTED, Only
from pointbrush.masks import LiftOptions, draw, lift
from pointbrush.masks.models import MaskModels, Prompt
from pointbrush.sequences import Sequence as Recording
from pointbrush.values.masks import VOID, MaskEdit, MaskPrompt, MaskSource
from pointbrush.work.annotate.layers import KeptAnnotation
from pointbrush.work.annotate.strokes import edit_id
from pointbrush.work.masks.classes import Classes, chosen_labels
from pointbrush.work.masks.views import (
    camera_picture,
    depth_images,
    depth_pixels,
    size_of,
    view_of,
)
from pointbrush.work.part import Part

Mask = NDArray[np.unsignedinteger]
RULES: Mapping[str, tuple[int, Only]] = {
    "imported": (IMPORTED, "not_painted"),
    "predicted": (PREDICTED, "predictable"),
    "painted": (PAINTED, "any"),
}
"""Provenance of points by the source of a mask, and the points that it may change."""
NAMED_ZERO = 65534
"""Value of pixels of value 0 if the caller names the value 0, which otherwise means no object."""
_DEFAULTS = LiftOptions()


def lift_masks(
    recording: Recording,
    frame: int,
    masks: Mapping[str, Mask],
    options: LiftOptions = _DEFAULTS,
) -> NDArray[np.int32]:
    """Return the value (N,) of masks by camera at each point, stored order, as ``masks.lift`` does.

    Raises NotFoundError (camera), BadInputError (size, no calibration).
    """
    views = [(view_of(recording, frame, camera), mask) for camera, mask in masks.items()]
    return lift(views, recording[frame].xyz, options)


class Masks(Part):
    """Labels from masks of pictures, and masks from labels; a mask is (H, W) whole numbers."""

    def __init__(
        self, store: LabelStore, recording: Callable[[str], Recording], models: MaskModels
    ) -> None:
        """``models``: models that find masks in pictures."""
        super().__init__(store, recording)
        self._models = models

    def predict(
        self, sequence: str, frame: int, camera: str, prompt: MaskPrompt, *, author: str
    ) -> MaskEdit:
        """Label the points behind the masks that a model finds in a picture, as one edit.

        Raises NotFoundError (camera; the model finds nothing), BadInputError (model, calibration),
        UnavailableError (no valid answer of the model), LockedLabelError.
        """
        recording = self._recording(sequence)
        view_of(recording, frame, camera)  # raises before the model is called
        clicks = (np.reshape(each, (-1, 2)) for each in (prompt.positives, prompt.negatives))
        positives, negatives = (np.asarray(each, np.float64) for each in clicks)
        picture = camera_picture(recording, frame, camera)
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
        """Label the points behind masks by camera, as one edit; several cameras vote.

        ``classes``: label id, or name of a label or class, for each value; 0 removes labels.  By
        default the values are label ids.  Values without a label, and VOID (255 in 8 bits) unless
        it is named, change nothing.  A predicted mask may add labels.  ``source`` decides which
        points may change, see ``RULES``; points of locked labels never do.
        Raises NotFoundError, BadInputError (size, classes), LockedLabelError.
        """
        recording = self._recording(sequence)
        masks = {camera: _normalized(mask, classes) for camera, mask in masks.items()}
        values = lift_masks(recording, frame, masks)
        named, predicted = named_values(masks, classes), source == "predicted"
        numbers = np.flatnonzero(np.isin(values, [*named]))
        provenance, only = RULES[source]
        unlabelled = PAINTED if source == "painted" else 0

        def choose(palette: Palette) -> tuple[Sequence[Label], Writes]:
            ids, added = chosen_labels(palette, named, create=predicted)
            label = ids[values[numbers]]
            write = Write(
                numbers,
                label=label,
                provenance=np.where(label > 0, provenance, unlabelled).astype(np.uint8),
                confidence=np.where(label > 0, FULL_CONFIDENCE, 0) if predicted else None,
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
            kind="prediction" if predicted else "import",
            writes=choose,
            summary=f"mask of {cameras}, frame {frame}"[:200],
            identity=recording.identity,
        )
        return MaskEdit.of(commit, seen=len(numbers), doubt=int((values < 0).sum()))

    def pixel(self, sequence: str, frame: int) -> NDArray[np.uint16] | None:
        """Return row and column (N, 2) of points in the depth image, source order; None: none."""
        stored = self._recording(sequence)[frame]
        places = np.zeros((stored.count, 2), np.uint16)
        images = [depth_pixels(stored, part) for part in depth_images(stored).values()]
        found = [image for image in images if image is not None]
        if sum(len(image.numbers) for image in found) < max(stored.count, 1):
            return None
        for image in found:
            places[image.numbers] = np.stack(np.divmod(image.pixel, image.size[0]), axis=1)
        return stored.to_source(places)

    def size(self, sequence: str, frame: int, camera: str) -> tuple[int, int]:
        """Return width and height of a camera's picture, pixels; raises NotFoundError."""
        return size_of(self._recording(sequence), frame, camera)

    def label_mask(self, sequence: str, frame: int, camera: str) -> tuple[Mask, int]:
        """Return the label of each pixel (H, W) uint16 of a camera's picture, and its revision.

        VOID: the camera sees no point there.  Raises NotFoundError, BadInputError (no calibration).
        """
        recording = self._recording(sequence)
        count = recording[frame].count
        kept = KeptAnnotation(self._store, sequence, frame, ("label", "deleted"))
        layers = kept.read(0, count)
        view = view_of(recording, frame, camera).without(layers["deleted"])
        return draw(view, layers["label"]), kept.revision


def _normalized(mask: Mask, classes: Classes | None) -> Mask:
    """Return a mask (H, W) uint16 in which a VOID of 8 bits is VOID, and a named 0 NAMED_ZERO."""
    named = classes or {}
    normalized = mask.astype(np.uint16)
    if mask.dtype == np.uint8 and VOID_8_BIT not in named:
        normalized[mask == VOID_8_BIT] = VOID
    if 0 in named:
        normalized[mask == 0] = NAMED_ZERO
    return normalized


def named_values(masks: Mapping[str, Mask], classes: Classes | None) -> Classes:
    """Return the label or class of each value of normalized masks.

    Raises BadInputError if no pixel has one of these values.
    """
    used = {int(value) for mask in masks.values() for value in np.unique(mask)} - {0, VOID}
    named: dict[int, int | str] = {value: value for value in used}
    if classes is not None:
        named = dict(classes)
    if 0 in named:
        named[NAMED_ZERO] = named.pop(0)
    if not used & named.keys():
        got = ", ".join(map(str, sorted(used)[:10])) or "only 0"
        expected = "label ids" if classes is None else ", ".join(map(str, sorted(named)[:10]))
        raise BadInputError(f"mask: expected pixels of values {expected}, got {got}")
    return named
