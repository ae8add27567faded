"""Oriented boxes of a recording."""

from __future__ import annotations

import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from pointbrush.client.steps import L, Part, Request, Steps, send, steps
from pointbrush.client.values import Edit, Vector, read
from pointbrush.errors import BadInputError

Quaternion = tuple[float, float, float, float]
AttributeValue = str | float | bool
Provenance = Literal["fitted", "drawn", "imported"]


@dataclass(frozen=True, slots=True)
class BoxPose:
    """Pose of a box in a frame: ``centre`` metres, ``quaternion`` x, y, z, w of frame <- box.

    Both are in source coordinates.  ``attributes`` override the attributes of the box.
    """

    centre: Vector
    quaternion: Quaternion
    provenance: Provenance = "drawn"
    confidence: float = 1.0
    attributes: Mapping[str, AttributeValue] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Box:
    """An oriented box: ``size`` length, width, height along its x (forward), y (left), z (up).

    ``heading_known`` is False if the front of the object may also be at the opposite end.
    """

    id: int
    label: int
    size: Vector
    poses: Mapping[int, BoxPose]
    attributes: Mapping[str, AttributeValue]
    provenance: Provenance
    heading_known: bool = True


class Boxes(Part[L]):
    """Boxes of a recording."""

    def __init__(self, link: L, recording: str) -> None:
        super().__init__(link)
        self._place = f"/sequences/{recording}/boxes"

    @steps
    def all(self, frame: int | None = None, label: int | None = None) -> Steps[list[Box]]:
        """Return the boxes; optionally only boxes with a pose in ``frame``, or of a label."""
        return (yield from self._listed(frame, label))

    @steps
    def __getitem__(self, box: int) -> Steps[Box]:
        """Return a box by its id; raises NotFoundError."""
        answer = yield from send(Request("GET", f"{self._place}/{box}", again=True))
        return read(Box, answer.json())

    @steps
    def add(
        self,
        label: int,
        size: Sequence[float],
        poses: Mapping[int, BoxPose],
        attributes: Mapping[str, AttributeValue] | None = None,
        provenance: Provenance = "drawn",
        heading_known: bool = True,
    ) -> Steps[Box]:
        """Add a box as one edit, and return it; ``poses`` by frame."""
        body = {
            "label": label,
            "size": list(size),
            "poses": {str(frame): _pose(pose) for frame, pose in poses.items()},
            "attributes": dict(attributes or {}),
            "provenance": provenance,
            "heading_known": heading_known,
        }
        return (yield from self._edited("POST", self._place, body))

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
            body["poses"] = {str(f): None if p is None else _pose(p) for f, p in poses.items()}
        return (yield from self._edited("PATCH", f"{self._place}/{box}", body))

    @steps
    def remove(self, box: int) -> Steps[Edit]:
        """Delete a box."""
        query = {"edit": str(uuid.uuid4())}
        place = f"{self._place}/{box}"
        answer = yield from send(Request("DELETE", place, {"params": query}, again=True))
        return read(Edit, answer.json())

    @steps
    def paint(
        self, box: int, frames: str | None = None, *, only_unlabeled: bool = False
    ) -> Steps[Edit]:
        """Label the points inside a box with its label, in its frames ``I:J`` (None: all)."""
        body = {"frames": frames, "only_unlabeled": only_unlabeled, "edit": str(uuid.uuid4())}
        place = f"{self._place}/{box}/points"
        answer = yield from send(Request("POST", place, {"json": body}, again=True))
        return read(Edit, answer.json())

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
        given = {"frame": frame, "label": label}
        query = {name: value for name, value in given.items() if value is not None}
        answer = yield from send(Request("GET", self._place, {"params": query}, again=True))
        return [read(Box, entry) for entry in answer.json()["boxes"]]

    def _edited(self, method: str, place: str, body: Mapping[str, Any]) -> Steps[Box]:
        named = {**body, "edit": str(uuid.uuid4())}
        answer = yield from send(Request(method, place, {"json": named}, again=True))
        return read(Box, answer.json()["box"])


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


def _pose(pose: BoxPose) -> dict[str, Any]:
    return {
        "centre": [float(value) for value in pose.centre],
        "quaternion": [float(value) for value in pose.quaternion],
        "provenance": pose.provenance,
        "confidence": pose.confidence,
        "attributes": dict(pose.attributes),
    }
