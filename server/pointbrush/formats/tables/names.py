"""Names of formats for commands and calls, without importing the readers."""

from __future__ import annotations

from collections.abc import Mapping

DELIMITERS: Mapping[str, str] = {
    "comma": ",", "semicolon": ";", "tab": "\t", "space": " ", "pipe": "|",
}  # fmt: skip
VIEWPOINT = "viewpoint"
POSES = ("auto", "none", VIEWPOINT)
"""Choices of poses other than a file; ``VIEWPOINT``: the viewpoint in headers of PCD files."""
AXES = ("x", "-x", "y", "-y", "z", "-z")
LABEL_FORMATS = (
    *("semantickitti", "lidarseg", "panoptic", "labelcloud-points", "npy", "lines", "las"),
    *("labelcloud", "sustechpoints", "supervisely", "datumaro", "xtreme1", "argoverse"),
    *("waymo", "segments", "nuscenes-boxes", "masks-yolo"),
    *("kitti-object", "kitti-tracking", "kitti-tracklets"),
    *("openpcdet", "boxes", "s3dis"),
    *("masks-coco", "masks-png", "points"),
)
"""All formats of labels, in the order of trial; LAS classes only by request."""
