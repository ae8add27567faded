"""Boxes as KITTI's text: object and tracking, with the calibration of their coordinates."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.boxes.conventions import numbers_by
from pointbrush.formats.boxes.figures import FrameBox
from pointbrush.formats.boxes.scene import File, Scene, SceneFrame
from pointbrush.geometry.oriented_box import UNKNOWN_OCCLUSION, AttributeValue
from pointbrush.geometry.rotations import upright_axes

Floats = NDArray[np.float64]
CAMERA_OF_UPRIGHT = np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]])
"""Rotation from forward, left, up to a camera's right, down, ahead."""
NEAR = 0.1
"""Metres ahead of a camera below which nothing is projected."""
NO_PICTURE = (-1.0, -1.0, -1.0, -1.0)
UNKNOWN_ALPHA = -10.0
UNKNOWN_TRUNCATION = -1.0
"""Value that the devkits' ``writeLabels.m`` writes for an object without a truncation."""
PARTLY_TRUNCATED = 0.5
"""Share outside the picture above which the truncation of tracking's text is "largely"."""
SIGNS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
EDGES = [(a, b) for a in range(8) for b in range(a + 1, 8) if (a ^ b).bit_count() == 1]


@dataclass(frozen=True, slots=True, eq=False)
class _Rectified:
    """KITTI's camera: level, so that upright boxes turn about its y.

    ``T_rect_source`` (4, 4); ``P`` (3, 4) projects, None without a picture of ``width`` x
    ``height`` pixels.
    """

    T_rect_source: Floats
    P: Floats | None = None
    width: int = 0
    height: int = 0

    @classmethod
    def of(cls, frame: SceneFrame) -> _Rectified:
        """Level the frame's camera; without one look along the source's forward from its origin."""
        T = np.eye(4)
        T[:3, :3] = CAMERA_OF_UPRIGHT @ upright_axes(frame.up)
        if frame.view is None:
            return cls(T)
        R = frame.view.T_camera_source[:3, :3]
        down = -frame.up / np.linalg.norm(frame.up)
        ahead = R[2] - down * (R[2] @ down)
        if np.linalg.norm(ahead) > 1e-6:
            ahead /= np.linalg.norm(ahead)
            T[:3, :3] = np.stack([np.cross(down, ahead), down, ahead])
        T[:3, 3] = T[:3, :3] @ R.T @ frame.view.T_camera_source[:3, 3]
        P = np.zeros((3, 4))
        P[:, :3] = frame.view.K @ R @ T[:3, :3].T
        return cls(T, P, frame.view.width, frame.view.height)

    def picture_of(self, box: FrameBox) -> tuple[tuple[float, ...], float | None]:
        """Compute left, top, right, bottom in pixels within the picture, and the share outside.

        The share is None without a picture.
        """
        if self.P is None:
            return NO_PICTURE, None
        corners = box.center + (SIGNS * box.size / 2) @ box.rotation.T
        seen = [end for a, b in EDGES for end in _ahead(corners[a], corners[b])]
        if not seen:
            return NO_PICTURE, 1.0
        u, v, w = self.P[:, :3] @ np.array(seen).T + self.P[:, 3:]
        pixels = np.stack([u / w, v / w])
        low, high = pixels.min(axis=1), pixels.max(axis=1)
        most = np.array([self.width - 1, self.height - 1], float)
        inside = np.clip(low, 0, most), np.clip(high, 0, most)
        whole = float(np.prod(high - low))
        share = float(np.prod(inside[1] - inside[0])) / whole if whole > 0 else 1.0
        return (*inside[0].tolist(), *inside[1].tolist()) if share else NO_PICTURE, 1 - share

    def calibration(self) -> bytes:
        """Write ``calib``: the projection four times, and the scanner's place."""
        P = np.hstack([np.eye(3), np.zeros((3, 1))]) if self.P is None else self.P
        rows = {f"P{number}": P for number in range(4)}
        rows |= {"R0_rect": np.eye(3), "Tr_velo_to_cam": self.T_rect_source[:3]}
        rows["Tr_imu_to_velo"] = np.eye(4)[:3]
        lines = (f"{name}: {_numbers(matrix.ravel(), 12)}\n" for name, matrix in rows.items())
        return "".join(lines).encode()


def _ahead(start: Floats, end: Floats) -> list[Floats]:
    """Clip an edge at the plane NEAR ahead of the camera: its ends, [] where it is behind."""
    if max(start[2], end[2]) < NEAR:
        return []
    ends = [start, end]
    for which, other in ((0, 1), (1, 0)):
        if ends[which][2] < NEAR:
            step = (NEAR - ends[which][2]) / (ends[other][2] - ends[which][2])
            ends[which] = ends[which] + step * (ends[other] - ends[which])
    return ends


def write_kitti_object(frames: Iterable[SceneFrame], _: Scene) -> Iterator[File]:
    """Write ``label_2/NNNNNN.txt`` and ``calib/NNNNNN.txt`` of each frame."""
    for frame in frames:
        camera = _Rectified.of(frame)
        lines = (f"{_object(box, camera)}\n" for box in frame.boxes)
        yield f"label_2/{frame.stem}.txt", "".join(lines).encode()
        yield f"calib/{frame.stem}.txt", camera.calibration()


def write_kitti_tracking(frames: Iterable[SceneFrame], _: Scene) -> Iterator[File]:
    """Write ``label_02/0000.txt`` and ``calib/0000.txt``, in the first frame's camera.

    The number of a track is its label's id.
    """
    camera: _Rectified | None = None
    lines: list[str] = []
    for frame in frames:
        camera = camera or _Rectified.of(frame)
        lines += (
            f"{frame.index} {box.label} {_object(box, camera, levels=True)}\n"
            for box in frame.boxes
        )
    yield "label_02/0000.txt", "".join(lines).encode()
    if camera is not None:
        yield "calib/0000.txt", camera.calibration()


def _object(box: FrameBox, camera: _Rectified, *, levels: bool = False) -> str:
    """Write type, truncated, occluded, alpha, picture, h w l, place and angle of a box.

    ``levels``: the truncation is a level, 0 to 2.  Unknown values are written as by the devkits.
    """
    moved = box.moved(camera.T_rect_source)
    picture, outside = camera.picture_of(moved)
    place, size, (turn,) = numbers_by("kitti", moved)
    share = _number(box.attributes.get("truncated"), outside)
    truncated = UNKNOWN_TRUNCATION if share is None else share
    if levels and share is not None:
        truncated = float(share > 0) + float(share > PARTLY_TRUNCATED)
    level = _number(box.attributes.get("occluded"), None)
    occluded = (
        UNKNOWN_OCCLUSION if level is None else round(min(max(0.0, level), UNKNOWN_OCCLUSION))
    )
    alpha = UNKNOWN_ALPHA if camera.P is None else turn - np.arctan2(place[0], place[2])
    if camera.P is not None:
        alpha = (alpha + np.pi) % (2 * np.pi) - np.pi
    truncation = f"{truncated:.0f}" if levels else f"{truncated:.4f}"
    numbers = _numbers([alpha, *picture, *size, *place, turn], 6)
    return f"{'_'.join(box.name.split()) or 'Misc'} {truncation} {occluded} {numbers}"


def _number(value: AttributeValue | None, otherwise: float | None) -> float | None:
    """Read an attribute as a number; true is 1."""
    return float(value) if isinstance(value, bool | int | float) else otherwise


def _numbers(values: Iterable[float], decimals: int) -> str:
    return " ".join(f"{value:.{decimals}f}" for value in values)
