"""Oriented boxes per label and frame, as JSON and as KITTI tracking text."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.exports.fit import Box, pca_box, upright_axes, upright_box
from pointbrush.formats.exports.labeled import ExportFrame, Palette, category_of
from pointbrush.formats.exports.output import Output
from pointbrush.formats.exports.points import write_palette


def write_boxes(frames: Iterable[ExportFrame], palette: Palette, output: Output) -> None:
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
    with output.file("boxes.json") as file:
        file.write(json.dumps({"boxes": listed}, indent=1, ensure_ascii=False).encode())
    with output.file("label_02/0000.txt") as file:
        file.write("".join(line + "\n" for line in lines).encode())
    write_palette(palette, output)


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
    """frame id type truncated occluded alpha bbox4 height width length x y z rotation_y."""
    axes: NDArray[np.float64] = upright_axes(frame.up)
    forward, left, up = axes @ box.center
    length, width, height = box.size
    # KITTI gives the middle of the bottom face, and turns about the axis that points down.
    location = -left, -(up - height / 2), forward
    turn = (-box.yaw - np.pi / 2 + np.pi) % (2 * np.pi) - np.pi
    kind = "".join(c if c.isalnum() else "_" for c in category) or "Misc"
    numbers = " ".join(f"{value:.6f}" for value in (height, width, length, *location, turn))
    return f"{frame.index} {label} {kind} 0 0 -10 -1 -1 -1 -1 {numbers}"
