"""Train a classifier on what is painted, propose labels, let a person correct, and repeat.

    pip install scikit-learn
    python docs/examples/active_learning.py http://127.0.0.1:8080 TOKEN juggling --rounds 3

Paint a few points of each class in any frame first. In each round the frame that the classifier
is least sure of gets its proposal and the state "review"; correct it on the page and accept it, and
the next round learns from it.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from sklearn.ensemble import RandomForestClassifier

from pointbrush.client import Client, Frame, Recording

PAINTED = 1
MOST_POINTS = 20_000
"""Points of a frame that are learned from."""
LOOK_SECONDS = 0.5


def features(frame: Frame) -> np.ndarray:
    """Return what the classifier sees of each point: place and colour."""
    points = frame.points()
    return np.column_stack([points[name] for name in ("xyz", "rgb") if name in points])


def examples(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Return features and labels of painted points, and of all points of accepted frames."""
    rng = np.random.default_rng(0)
    seen, labels = [], []
    for frame in recording.frames:
        values = frame.annotation()
        known = frame.annotation("provenance") == PAINTED
        if recording.review.frame(frame.index).state == "accepted":
            known |= values > 0
        chosen = np.flatnonzero(known)
        if len(chosen) > MOST_POINTS:
            chosen = rng.choice(chosen, MOST_POINTS, replace=False)
        if len(chosen):
            seen.append(features(frame)[chosen])
            labels.append(np.asarray(values)[chosen])
    if not labels:
        raise SystemExit("paint a few points of each class first")
    return np.concatenate(seen), np.concatenate(labels)


def propose(recording: Recording, model: RandomForestClassifier) -> Frame | None:
    """Write the model's labels into the open frame that it is least sure of; None: none is open."""
    doubts = {}
    for frame in recording.frames:
        if recording.review.frame(frame.index).state == "open":
            chances = np.sort(model.predict_proba(features(frame)), axis=1)
            doubts[frame.index] = 1 - float((chances[:, -1] - chances[:, -2]).mean())
    if not doubts:
        return None
    frame = recording.frames[max(doubts, key=doubts.__getitem__)]
    before = frame.annotation()
    painted = frame.annotation("provenance") == PAINTED
    proposal = model.predict(features(frame)).astype(np.uint16)
    # Somebody may paint in this frame at this moment: then ConflictError, and nothing is lost.
    frame.annotate(np.where(painted, before, proposal), if_match=before.etag)
    note = f"proposed, doubt {doubts[frame.index]:.2f}: correct it, then accept"
    recording.review.put(frame.index, state="review", note=note)
    return frame


def main() -> None:
    """Run the rounds."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("url")
    parser.add_argument("token")
    parser.add_argument("sequence")
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    with Client(given.url, given.token) as client:
        recording = client[given.sequence]
        for number in range(1, given.rounds + 1):
            seen, labels = examples(recording)
            model = RandomForestClassifier(30, max_depth=16, random_state=0).fit(seen, labels)
            frame = propose(recording, model)
            if frame is None:
                break
            print(f"round {number}: {len(labels)} points learned, correct frame {frame.index}")
            proposed = frame.annotation()
            while recording.review.frame(frame.index).state != "accepted":
                time.sleep(LOOK_SECONDS)
            right = float((proposed == frame.annotation()).mean())
            print(f"round {number}: {right:.1%} of the proposal was right", flush=True)


if __name__ == "__main__":
    main()
