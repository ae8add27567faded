"""Boxes of other tools are turned as their makers' sources turn them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from pointbrush.formats.box_labels import read_boxes


def test_sustechpoints_turns_about_the_boxes_own_axes_x_y_z(tmp_path: Path) -> None:
    """As three.js's Euler order XYZ in SUSTechPOINTS' public/js/util.js: R = Rx Ry Rz."""
    angles = (0.3, -0.2, 1.1)
    psr = {
        "position": {"x": 1, "y": 2, "z": 3},
        "scale": {"x": 4, "y": 2, "z": 1.5},
        "rotation": dict(zip("xyz", angles, strict=True)),
    }
    path = tmp_path / "000001.json"
    path.write_text(json.dumps([{"obj_id": "1", "obj_type": "Bus", "psr": psr}]))
    ((box,),) = (part.boxes for part in read_boxes(path, "sustechpoints"))
    np.testing.assert_allclose(box.rotation, Rotation.from_euler("XYZ", angles).as_matrix())
