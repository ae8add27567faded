"""Oriented boxes per label and frame, as JSON and as KITTI tracking text."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.writers.labeled import ExportFrame, Palette, category_of
from pointbrush.formats.writers.output import Output
from pointbrush.formats.writers.points import write_palette
from pointbrush.geometry.rotations import upright_axes

Matrix = NDArray[np.float64]
# More edges than this gain less than a thousandth of the area.
MAX_EDGES = 360


FILE = "boxes.json"
VISIBLE = "visible"
"""Extent of these boxes: they enclose the visible points, not the whole object."""


def write_boxes(frames: Iterable[ExportFrame], palette: Palette, output: Output) -> dict[str, str]:
    """``boxes.json`` and ``label_02/0000.txt`` (KITTI tracking) of every label in every frame.

    JSON has per box the tightest box along the principal axes (``box``) and the smallest upright
    one (``upright``), both in source coordinates.  The KITTI text has the upright one in KITTI's
    camera axes (x right, y down, z forward), seen from the source's origin.
    """
    entries = {entry.id: entry for entry in palette.entries}
    listed: list[dict[str, Any]] = []
    lines: list[str] = []
    for frame in frames:
        tracks = {int(track["label"]): track for track in frame.tracks}
        for label, xyz in sorted(_by_label(frame).items()):
            upright = upright_box(xyz, frame.up)
            entry = entries.get(label)
            category = category_of(entry) if entry else f"label {label}"
            record = {
                "frame": frame.index,
                "label": label,
                "name": entry.name if entry else category,
                "category": category,
                "points": len(xyz),
                "box": _document(pca_box(xyz)),
                "upright": _document(upright) | {"yaw": upright.yaw},
            }
            if label in tracks:
                record["track"] = dict(tracks[label])
            listed.append(record)
            lines.append(_kitti(frame, label, category, upright))
    with output.file(FILE) as file:
        document = {"extent": VISIBLE, "boxes": listed}
        file.write(json.dumps(document, indent=1, ensure_ascii=False).encode())
    with output.file("label_02/0000.txt") as file:
        file.write("".join(line + "\n" for line in lines).encode())
    write_palette(palette, output)
    return {"extent": VISIBLE}


def _by_label(frame: ExportFrame) -> dict[int, NDArray[Any]]:
    """The points (N, 3) of each label that has any."""
    parts: dict[int, list[NDArray[Any]]] = {}
    for block in frame.blocks():
        alive = np.where(block.deleted, 0, block.label)
        for label in np.unique(alive[alive > 0]).tolist():
            parts.setdefault(label, []).append(block.points.xyz[alive == label])
    return {label: np.concatenate(xyz) for label, xyz in parts.items()}


def _document(box: Box) -> dict[str, Any]:
    return {
        "center": box.center.tolist(),
        "size": box.size.tolist(),
        "rotation": box.R.tolist(),
    }


def _kitti(frame: ExportFrame, label: int, category: str, box: Box) -> str:
    """frame id type truncated occluded alpha bbox4 height width length x y z rotation_y.

    Truncation (-1), occlusion (3), alpha (-10) and the picture (-1) are unknown.
    """
    axes: NDArray[np.float64] = upright_axes(frame.up)
    forward, left, up = axes @ box.center
    length, width, height = box.size
    # KITTI uses the middle of the bottom face, and a rotation about the axis that points down.
    location = -left, -(up - height / 2), forward
    turn = (-box.yaw - np.pi / 2 + np.pi) % (2 * np.pi) - np.pi
    kind = "".join(c if c.isalnum() else "_" for c in category) or "Misc"
    numbers = " ".join(f"{value:.6f}" for value in (height, width, length, *location, turn))
    return f"{frame.index} {label} {kind} -1 3 -10 -1 -1 -1 -1 {numbers}"


@dataclass(frozen=True, slots=True)
class Box:
    """``center`` (3,), ``size`` (3,) along the box's axes, ``R`` (3, 3) ``R_source_box``.

    ``yaw`` of an upright box turns its first axis about the vertical, -pi/2 to pi/2; else 0.
    """

    center: Matrix
    size: Matrix
    R: Matrix
    yaw: float = 0.0


def pca_box(xyz: NDArray[Any]) -> Box:
    """The box along the principal axes of (N, 3) points, N at least 1, longest spread first."""
    points = np.asarray(xyz, np.float64)
    middle = points.mean(axis=0)
    _, _, axes = np.linalg.svd(np.cov((points - middle).T, bias=True) + np.zeros((3, 3)))
    axes[2] = np.cross(axes[0], axes[1])
    turned = (points - middle) @ axes.T
    low, high = turned.min(axis=0), turned.max(axis=0)
    return Box(middle + (low + high) / 2 @ axes, high - low, axes.T.copy())


def upright_box(xyz: NDArray[Any], up: NDArray[Any]) -> Box:
    """The smallest box round (N, 3) points, N at least 1, with its third axis along ``up``.

    One side of the smallest rectangle round points lies on an edge of their convex hull
    (Freeman and Shapira 1975).  The longer side is the first axis.
    """
    axes = upright_axes(up)
    points = np.asarray(xyz, np.float64)
    middle = points.mean(axis=0)
    turned = (points - middle) @ axes.T
    yaw, low, high = _smallest_rectangle(turned[:, :2])
    center = np.append(_turn(yaw) @ (low + high) / 2, (turned[:, 2].min() + turned[:, 2].max()) / 2)
    R_upright_box = np.eye(3)
    R_upright_box[:2, :2] = _turn(yaw)
    size = np.append(high - low, np.ptp(turned[:, 2]))
    return Box(middle + center @ axes, size, axes.T @ R_upright_box, yaw)


def _turn(yaw: float) -> Matrix:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s], [s, c]])


def _smallest_rectangle(flat: Matrix) -> tuple[float, Matrix, Matrix]:
    """Yaw of the long side, and the extent along the turned axes."""
    corners = _hull(flat)
    edges = np.roll(corners, -1, axis=0) - corners
    edges = edges[np.any(edges != 0, axis=1)]
    edges = edges[:: len(edges) // MAX_EDGES + 1] if len(edges) else np.array([[1.0, 0.0]])
    angles = np.arctan2(edges[:, 1], edges[:, 0])
    extents = [(corners @ _turn(angle)) for angle in angles]
    # Points on a line have no area at angles along it: then the sum of the sides decides.
    sides = [np.ptp(turned, axis=0) for turned in extents]
    best = int(np.argmin([side[0] * side[1] + 1e-9 * side.sum() for side in sides]))
    yaw = float(angles[best]) + (np.pi / 2 if sides[best][1] > sides[best][0] else 0.0)
    yaw = (yaw + np.pi / 2) % np.pi - np.pi / 2
    turned = corners @ _turn(yaw)
    return yaw, turned.min(axis=0), turned.max(axis=0)


def _hull(flat: Matrix) -> Matrix:
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(flat[ConvexHull(flat).vertices] if len(flat) > 2 else flat)
    except QhullError:
        # On one line: the two ends are the hull.
        along = flat[:, 0] + 1e-3 * flat[:, 1]
        return flat[[int(np.argmin(along)), int(np.argmax(along))]]
