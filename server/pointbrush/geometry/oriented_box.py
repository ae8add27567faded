"""Oriented boxes of objects over a range of frames: the truth that detectors are trained on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.geometry.quaternions import rotation_of
from pointbrush.values.boxes import BoxProvenance

Floats = NDArray[np.float64]
AttributeValue = str | float | bool
Attributes = Mapping[str, AttributeValue]
UNKNOWN_OCCLUSION = 3
"""The value of the attribute ``occluded`` for an unknown occlusion; KITTI defines the levels."""


@dataclass(frozen=True, slots=True, eq=False)
class BoxPose:
    """Place of a box in one frame.

    ``centre`` (3,) metres and ``quaternion`` (4,) x, y, z, w, of length 1, of the rotation from the
    box's axes (x forward, y left, z up) to the source coordinates of the frame's points.
    ``confidence`` 0..1.  ``attributes`` hold in this frame alone and precede the
    attributes of the box (``occluded``, ``truncated``, free ones).
    """

    centre: Floats
    quaternion: Floats
    provenance: BoxProvenance = "drawn"
    confidence: float = 1.0
    attributes: Attributes = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the pose.  Raises BadInputError."""
        _check_numbers("centre", self.centre, 3)
        _check_numbers("quaternion", self.quaternion, 4)
        if abs(float(np.linalg.norm(self.quaternion)) - 1) > 1e-6:
            raise BadInputError(
                f"quaternion: expected x, y, z, w of length 1, got {self.quaternion.tolist()}"
            )
        if not 0 <= self.confidence <= 1:
            raise BadInputError(f"confidence: expected 0 to 1, got {self.confidence}")
        _check_provenance(self.provenance)

    @property
    def transform(self) -> Floats:
        """Compute ``T_frame_box`` (4, 4), from the box's axes to the frame's coordinates."""
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = rotation_of(self.quaternion), self.centre
        return T


@dataclass(frozen=True, slots=True, eq=False)
class OrientedBox:
    """A box of a label: one size in all frames, a pose in each frame that it is in.

    ``id`` 1 and up in its recording, never given twice (0: not stored yet); ``label`` the label's
    id; ``size`` (3,) length, width, height, metres, along the box's axes; ``poses`` by frame.
    ``heading_known``: the box's forward axis points to the front of the object; where it is False,
    the front may also be at the opposite end.
    """

    id: int
    label: int
    size: Floats
    poses: Mapping[int, BoxPose]
    attributes: Attributes = field(default_factory=dict)
    provenance: BoxProvenance = "drawn"
    heading_known: bool = True

    def __post_init__(self) -> None:
        """Check the box.  Raises BadInputError."""
        _check_numbers("size", self.size, 3)
        if not (self.size > 0).all():
            raise BadInputError(
                f"size: expected length, width and height above 0 m, got {self.size.tolist()}"
            )
        _check_provenance(self.provenance)


def _check_numbers(name: str, values: Floats, count: int) -> None:
    if values.shape != (count,) or not np.isfinite(values).all():
        raise BadInputError(f"{name}: expected {count} finite numbers, got {values.tolist()}")


def _check_provenance(provenance: Any) -> None:
    known = get_args(get_args(BoxProvenance)[0])
    if provenance not in known:
        raise BadInputError(f"provenance: expected one of {', '.join(known)}, got {provenance!r}")
