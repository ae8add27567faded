"""Oriented boxes of a recording."""

from __future__ import annotations

import uuid
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from pointbrush.client.answers import read, vector
from pointbrush.client.steps import L, Part, Steps, steps
from pointbrush.errors import BadInputError
from pointbrush.values import boxes as values
from pointbrush.values.boxes import AttributeValue, BoxPoints, BoxPose, BoxProvenance, NewBox
from pointbrush.values.edits import Edit


@dataclass(frozen=True, slots=True)
class Box(values.Box):
    """An oriented box of a label, with its poses by number of the frame."""

    poses: Mapping[int, BoxPose]  # type: ignore[assignment]
    """Pose in each frame."""


class Boxes(Part[L]):
    """Boxes of a recording."""

    @steps
    def all(self, frame: int | None = None, label: int | None = None) -> Steps[list[Box]]:
        """Return the boxes; optionally only boxes with a pose in ``frame``, or of a label."""
        return self._listed(frame, label)

    @steps
    def __getitem__(self, box: int) -> Steps[Box]:
        """Return a box by its id; raises NotFoundError."""
        return self._get(Box, f"/{box}")

    @steps
    def add(
        self,
        label: int,
        size: Sequence[float],
        poses: Mapping[int, BoxPose],
        attributes: Mapping[str, AttributeValue] | None = None,
        provenance: BoxProvenance = "drawn",
        heading_known: bool = True,
    ) -> Steps[Box]:
        """Add a box as one edit, and return it; ``poses`` by frame."""
        placed = {str(frame): _fixed(pose) for frame, pose in poses.items()}
        length, width, height = (float(side) for side in size)
        new = NewBox(
            label, (length, width, height), placed, dict(attributes or {}), provenance,
            heading_known,
        )  # fmt: skip
        return self._edited("POST", "", new.to_json())

    @steps
    def change(
        self,
        box: int,
        *,
        size: Sequence[float] | None = None,
        label: int | None = None,
        poses: Mapping[int, BoxPose | None] | None = None,
        attributes: Mapping[str, AttributeValue | None] | None = None,
        heading_known: bool | None = None,
    ) -> Steps[Box]:
        """Change a box as one edit, and return it.

        ``poses`` by frame and ``attributes`` by name; None removes an entry.
        """
        given = {
            "label": label, "size": size and list(size), "attributes": attributes,
            "heading_known": heading_known,
        }  # fmt: skip
        body: dict[str, Any] = {name: each for name, each in given.items() if each is not None}
        if poses is not None:
            body["poses"] = {
                str(f): None if p is None else asdict(_fixed(p)) for f, p in poses.items()
            }
        return self._edited("PATCH", f"/{box}", body)

    @steps
    def remove(self, box: int) -> Steps[Edit]:
        """Delete a box."""
        return self._change(Edit, "DELETE", f"/{box}", edit=str(uuid.uuid4()))

    @steps
    def paint(
        self, box: int, frames: str | None = None, *, only_unlabeled: bool = False
    ) -> Steps[Edit]:
        """Label the points inside a box with its label, in its frames ``I:J`` (None: all)."""
        body = BoxPoints(frames, only_unlabeled, str(uuid.uuid4()))
        return self._change(Edit, "POST", f"/{box}/points", body)

    @steps
    def frame(self, frame: int | None = None, label: int | None = None) -> Steps[Any]:
        """Return a pandas frame with a row for each box and frame; needs pandas.

        Columns: box, frame, label, length, width, height, x, y, z, qx, qy, qz, qw, provenance,
        confidence, heading_known, and one for each attribute.
        """
        try:
            import pandas
        except ImportError:
            raise BadInputError(
                "boxes.frame: expected pandas to be installed ('pip install pandas')"
            ) from None
        boxes = yield from self._listed(frame, label)
        rows = [_row(b, f) for b in boxes for f in b.poses if frame is None or f == frame]
        return pandas.DataFrame(rows, columns=None if rows else list(COLUMNS))

    def _listed(self, frame: int | None, label: int | None) -> Steps[list[Box]]:
        found = yield from self._get(dict[str, Any], frame=frame, label=label)
        return read(list[Box], found["boxes"])

    def _edited(self, method: str, path: str, body: Mapping[str, Any]) -> Steps[Box]:
        named = {**body, "edit": str(uuid.uuid4())}
        return read(Box, (yield from self._change(dict[str, Any], method, path, named))["box"])


COLUMNS = (
    "box", "frame", "label", "length", "width", "height", "x", "y", "z",
    "qx", "qy", "qz", "qw", "provenance", "confidence", "heading_known",
)  # fmt: skip


def _row(box: Box, frame: int) -> dict[str, Any]:
    pose = box.poses[frame]
    values = (
        box.id, frame, box.label, *box.size, *pose.centre, *pose.quaternion, pose.provenance,
        pose.confidence, box.heading_known,
    )  # fmt: skip
    return {**dict(zip(COLUMNS, values, strict=True)), **box.attributes, **pose.attributes}


def _fixed(pose: BoxPose) -> BoxPose:
    """Return a pose with tuples of numbers, also of arrays."""
    x, y, z, w = (float(value) for value in pose.quaternion)
    centre = vector(pose.centre) or pose.centre
    return replace(pose, centre=centre, quaternion=(x, y, z, w))
