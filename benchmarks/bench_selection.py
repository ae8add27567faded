"""Selection against scipy's ball query and a plain numpy scan, on a Kinect-like frame.

python benchmarks/bench_selection.py
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from timing import paired, table

from pointbrush.frame import PointFrame
from pointbrush.selection import Stroke, first_hits, select
from pointbrush.sequences import RecordingInfo, import_frames, open_sequence
from pointbrush.work.annotate.painted_frame import frame_points


def room(points: int) -> PointFrame:
    """A room seen from inside: floor, walls and boxes, points in random order."""
    rng = np.random.default_rng(0)
    face = rng.integers(0, 12, points)
    xyz = rng.uniform(0, 1, (points, 3))
    axis, side = face % 3, (face // 3) % 2
    size = np.where(face[:, None] < 6, [6.0, 2.6, 5.0], [0.5, 0.8, 0.5])
    xyz[np.arange(points), axis] = side
    xyz = xyz * size + np.where(face[:, None] < 6, 0, [2.5, 0, 2.0])
    rgb = rng.integers(0, 255, (points, 3)).astype(np.uint8)
    return PointFrame(xyz.astype(np.float32), rgb=rgb)


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "room"
        import_frames([room(217_088)], target, RecordingInfo("room", "room", 30))
        frame = open_sequence(target)[0]
        points, tree = frame_points(frame), frame.kdtree
        xyz = np.ascontiguousarray(frame.xyz)
        center = np.array([2.5, 0.4, 2.2])
        for radius in (0.05, 0.2):
            ball = Stroke("sphere", label=1, values={"radius": radius}, origins=center[None])
            path = center + np.linspace(0, 1, 20)[:, None] * [0.6, 0.2, 0.4]
            sweep = Stroke("sphere", label=1, values={"radius": radius}, origins=path)
            taken = len(select(points, ball))
            print(f"ball of {100 * radius:g} cm, {taken} of {len(xyz)} points")
            print(
                table(
                    paired(
                        {
                            "pointbrush": lambda ball=ball: select(points, ball),
                            "scipy cKDTree.query_ball_point": lambda radius=radius: np.sort(
                                tree.query_ball_point(center, radius)
                            ),
                            "numpy scan of all points": lambda radius=radius: np.flatnonzero(
                                np.linalg.norm(xyz - center.astype(np.float32), axis=1) <= radius
                            ),
                            "pointbrush, stroke of 20 samples": lambda sweep=sweep: select(
                                points, sweep
                            ),
                        }
                    ),
                    "pointbrush",
                )
            )
        eye, aim = np.array([[3.0, 1.5, 0.2]]), np.array([[0.0, -0.3, 0.954]])
        aim /= np.linalg.norm(aim)
        print("first hit of a ray")
        print(
            table(paired({"pointbrush": lambda: first_hits(points, eye, aim, 0.05)}), "pointbrush")
        )


if __name__ == "__main__":
    main()
