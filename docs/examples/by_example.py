"""Label the places where a classifier is least sure, from ground truth, and apply it.

    python docs/examples/by_example.py http://127.0.0.1:8080 TOKEN juggling truth.npy --strokes 10

``truth.npy`` contains a label id for each point of frame 0 in source order, 0 for none. It stands
for a person: each stroke is a ball with the label of the point at its centre.
"""

from __future__ import annotations

import argparse

import numpy as np

from pointbrush.client import Client


def main() -> None:
    """Paint one stroke of each label, then the strokes that teach most."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("url")
    parser.add_argument("token")
    parser.add_argument("sequence")
    parser.add_argument("truth")
    parser.add_argument("--strokes", type=int, default=10)
    parser.add_argument("--radius", type=float, default=0.1, help="metres")
    given = parser.parse_args()
    truth = np.load(given.truth)
    with Client(given.url, given.token) as client:
        recording = client[given.sequence]
        frame = recording.frames[0]
        xyz = np.asarray(frame.points()["xyz"], np.float64)

        def paint(point: int) -> None:
            label = int(truth[point])
            if label:
                frame.stroke(label=label, radius=given.radius, samples=[xyz[point].tolist()])

        for label in np.unique(truth[truth > 0]):
            paint(int(np.flatnonzero(truth == label)[0]))
        classifier = client.classifiers.create(f"{given.sequence} by example", [recording.id])
        for _ in range(given.strokes):
            place, *_ = recording.by_example.doubt(classifier.id, frame=0, most=1)
            paint(int(np.linalg.norm(xyz - place.centre, axis=1).argmin()))
        found = recording.by_example.predict(classifier.id, 0)
        right = float((found.label == truth)[truth > 0].mean())
        result = recording.by_example.apply(classifier.id)
        print(f"{right:.1%} right in frame 0; {result.changed:,} points labelled")


if __name__ == "__main__":
    main()
