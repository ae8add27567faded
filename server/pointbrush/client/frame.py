"""Frames of a recording: points, pictures, annotations and strokes."""

from __future__ import annotations

import io
import json
import uuid
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, overload
from urllib.parse import quote

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pointbrush.client.answers import (
    Annotation,
    array_of,
    layer_of,
    mask_of,
    npy_of,
    rays,
    read,
)
from pointbrush.client.steps import L, Part, Steps, steps
from pointbrush.values.edits import Edit
from pointbrush.values.frames import Camera
from pointbrush.values.masks import LATTICE, MaskEdit, MaskPrompt
from pointbrush.values.objects import Candidate, Candidates
from pointbrush.values.runs import Clearing, Copying


class Frame(Part[L]):
    """Frame ``index`` of a recording."""

    def __init__(self, link: L, sequence: str, index: int) -> None:
        super().__init__(link, f"/sequences/{sequence}/frames/{index}")
        self._sequence, self.index = sequence, index

    def __repr__(self) -> str:
        return f"Frame({self._sequence!r}, {self.index})"

    def _edit(self, path: str, body: Mapping[str, Any]) -> Steps[Edit]:
        return self._change(Edit, "POST", path, {"id": str(uuid.uuid4()), **body})

    # ── points and pictures ──────────────────────────────────────────────────────────────

    @steps
    def points(self) -> Steps[dict[str, NDArray[Any]]]:
        """Return arrays of the points: ``xyz`` (N, 3), and ``rgb``, ``intensity`` where stored.

        ``pixel`` (N, 2), row and column in the depth image, if the points were measured in one;
        ``sensor`` (N,), number of each point's sensor, if the recording has several.
        """
        answer = yield from self._call("GET", "/points", params={"format": "npz"})
        with np.load(io.BytesIO(answer.content), allow_pickle=False) as stored:
            return dict(stored.items())

    @steps
    def cameras(self) -> Steps[list[Camera]]:
        """Return the cameras with a picture of this frame."""
        return self._get(list[Camera], "/cameras")

    @steps
    def image(self, camera: str) -> Steps[bytes]:
        """Return the picture of a camera as it was imported: JPEG, PNG or WebP."""
        answer = yield from self._call("GET", f"/images/{quote(camera, safe='')}")
        return answer.content

    @steps
    def mask(self, camera: str = LATTICE) -> Steps[NDArray[Any]]:
        """Return the label of each pixel of a camera's picture (H, W), 65535 without a point.

        ``camera``: its name; "depth" is the depth image that the points were measured in.
        """
        params = {"format": "npy"}
        answer = yield from self._call("GET", f"/masks/{quote(camera, safe='')}", params=params)
        return array_of(answer)

    @steps
    def set_mask(
        self,
        camera: str,
        array: ArrayLike,
        classes: Mapping[int, int | str] | None = None,
        *,
        source: str = "imported",
    ) -> Steps[MaskEdit]:
        """Label the points that a camera sees in a mask (H, W) of whole numbers, as one edit.

        ``classes``: the label id, or the name of a label or class, of each value; 0 removes labels.
        By default the values are label ids.  Other values change nothing.  ``source``: imported,
        predicted or painted; only a painted mask changes painted points.
        Raises BadInputError for another size, an unknown class or a camera without calibration.
        """
        params = {"id": str(uuid.uuid4()), "source": source}
        if classes is not None:
            params["classes"] = json.dumps(dict(classes))
        answer = yield from self._call(
            "PUT",
            f"/masks/{quote(camera, safe='')}",
            idempotent=True,
            content=npy_of(mask_of(array)),
            headers={"Content-Type": "application/x-npy"},
            params=params,
        )
        return read(MaskEdit, answer.json())

    @steps
    def predict_mask(
        self,
        camera: str,
        model: str,
        *,
        positives: ArrayLike = (),
        negatives: ArrayLike = (),
        text: str = "",
        label: int | None = None,
    ) -> Steps[MaskEdit]:
        """Label the points seen in masks that a model of the server finds in a picture.

        ``positives``, ``negatives`` (P, 2): clicks on and beside the object, column and row.
        ``label``: id of the label of all found points; by default those of the model's classes.
        """
        ons, offs = (
            tuple((float(u), float(v)) for u, v in np.reshape(each, (-1, 2)))
            for each in (positives, negatives)
        )
        body = MaskPrompt(model, ons, offs, text, label, str(uuid.uuid4())).to_json()
        place = f"/masks/{quote(camera, safe='')}/predict"
        answer = yield from self._call("POST", place, json=body, idempotent=True)
        return read(MaskEdit, answer.json())

    @steps
    def thumbnail(self) -> Steps[bytes]:
        """Return a small picture of the frame, a JPEG."""
        return (yield from self._call("GET", "/thumbnail")).content

    # ── annotations ──────────────────────────────────────────────────────────────────────

    @steps
    def annotation(self, layer: str = "label", snapshot: str | None = None) -> Steps[Annotation]:
        """Return a layer (N,) with its ``etag``: label, provenance, deleted or confidence.

        ``snapshot``: id of a snapshot to read instead of the current labels.
        """
        params = {"layer": layer, "snapshot": snapshot}
        answer = yield from self._call("GET", "/annotation", params=params)
        return Annotation(array_of(answer), answer.headers["ETag"])

    @steps
    def annotate(
        self, values: NDArray[Any], layer: str = "label", *, if_match: str | None = None
    ) -> Steps[Edit]:
        """Replace a layer as one edit; ``values`` (N,): whole numbers of any type.

        Raises BadInputError for values that the layer cannot hold (label 0 to 65535, provenance 0
        to 255, deleted 0 or 1).  ``if_match``: the ``etag`` of the layer that the values were made
        from; raises ConflictError if the frame has changed since.
        """
        headers = {"Content-Type": "application/x-npy"}
        if if_match is not None:
            headers["If-Match"] = if_match
        answer = yield from self._call(
            "PUT",
            "/annotation",
            idempotent=True,
            content=npy_of(layer_of(values, layer)),
            headers=headers,
            params={"layer": layer, "id": str(uuid.uuid4())},
        )
        return read(Edit, answer.json())

    # ── strokes and objects ──────────────────────────────────────────────────────────────

    @steps
    def stroke(
        self,
        /,
        *,
        label: int = 0,
        samples: ArrayLike = (),
        directions: ArrayLike | None = None,
        tool: str = "paint",
        shape: str = "sphere",
        **fields: Any,
    ) -> Steps[Edit]:
        """Apply a stroke of ``samples`` (S, 3), places or origins of rays with ``directions``.

        ``fields``: other fields of the stroke, such as radius, polygon, matrix, candidate, frames.
        """
        body = {"label": label, "tool": tool, "shape": shape, **fields}
        return self._edit("/strokes", {**body, "samples": rays(samples, directions)})

    @steps
    def objects(
        self,
        /,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        negatives: tuple[ArrayLike, ArrayLike] | None = None,
        **fields: Any,
    ) -> Steps[list[Candidate]]:
        """Return candidates for the object that rays (K, 3) point at, from part to group.

        ``negatives``: origins and directions of rays at points outside the object.  A stroke of
        shape ``object`` with the same rays and the id of a ``candidate`` takes one, with any label.
        """
        body = {"positives": rays(origins, directions), **fields}
        if negatives is not None:
            body["negatives"] = rays(*negatives)
        return list((yield from self._change(Candidates, "POST", "/object", body)).candidates)

    @steps
    def copy_labels(self, source: int, labels: Sequence[int]) -> Steps[Edit]:
        """Copy ``labels`` from the points at the same place in frame ``source``."""
        return self._edit("/copy", Copying(tuple(labels), source).to_json())

    @steps
    def clear(self, labels: Sequence[int], stop: int | None = None) -> Steps[Edit]:
        """Remove labels from all their points in this frame, or in all up to frame ``stop``.

        Painted points lose the labels as well; ``recording.clear`` clears only tracked points.
        """
        return self._edit("/clear", Clearing(tuple(labels), stop).to_json())


class Frames(Part[L], Sequence[Frame[L]]):
    """The frames of a recording."""

    def __init__(self, link: L, sequence: str, count: int) -> None:
        super().__init__(link)
        self._sequence, self._count = sequence, count

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, index: int) -> Frame[L]: ...
    @overload
    def __getitem__(self, index: slice) -> list[Frame[L]]: ...
    def __getitem__(self, index: int | slice) -> Frame[L] | list[Frame[L]]:
        """Return a frame, or the list of frames of a slice; raises IndexError."""
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(self._count))]
        number = index + self._count if index < 0 else index
        if not 0 <= number < self._count:
            raise IndexError(f"expected a frame from 0 to {self._count - 1}, got {index}")
        return Frame(self._link, self._sequence, number)

    def __iter__(self) -> Iterator[Frame[L]]:
        return (self[i] for i in range(self._count))
