"""Label a recording with your own model, and let people correct the frames that it is unsure of.

    python docs/examples/prelabel.py http://127.0.0.1:8080 TOKEN juggling

The labels are imported (provenance 3), so people can paint over them. The script puts each frame
with a low mean probability up for review with a note. People correct the frames in the review list
of the page.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

from pointbrush.client import Client

CLASSES = {1: "person", 2: "room"}
SURE = 0.9
"""Least mean probability of a frame that needs no correction."""


def predict(points: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return a class and its probability for each point; put your network here.

    The toy predicts people in the front half of the room, and is unsure near the border.
    """
    depth = points["xyz"][:, 2]
    border = (depth.min() + depth.max()) / 2
    away = (border - depth) / np.ptp(depth)
    front = 1 / (1 + np.exp(-20 * away))
    return np.where(front > 0.5, 1, 2).astype(np.uint32), np.maximum(front, 1 - front)


def main(url: str, token: str, sequence: str) -> None:
    """Predict every frame, import the labels as one edit, put unsure frames up for review."""
    with Client(url, token) as client, tempfile.TemporaryDirectory() as folder:
        recording = client[sequence]
        unsure = {}
        for frame in recording.frames:
            classes, probability = predict(frame.points())
            classes.tofile(Path(folder) / f"{frame.index:06}.label")  # as SemanticKITTI's
            if probability.mean() < SURE:
                unsure[frame.index] = float(probability.mean())
        names = "\n".join(f"{number} {name}" for number, name in CLASSES.items())
        report = recording.import_labels([Path(folder)], format="semantickitti", map=names)
        print(f"{report['labelled']:,} points labelled in {report['matched']} frames")
        for number, mean in unsure.items():
            recording.review.put(number, state="review", note=f"the model is {mean:.0%} sure")
        print(f"{len(unsure)} frames to correct")


if __name__ == "__main__":
    main(*sys.argv[1:4])
