"""Score the classes for label by example in your own service: a toy model over HTTP.

    python docs/examples/model_server.py --port 9100
    pointbrush serve --models nearest=http://127.0.0.1:9100
    pointbrush example drive --name mine --model nearest

The toy stores the mean features of each class and scores a cell by its distance to them.  Replace
``learn`` and ``scores`` by your network.  docs/howto/own-model.md describes the calls.
"""

from __future__ import annotations

import numpy as np
from selector_server import serve  # the file beside this one: calls as .npz over HTTP

Arrays = dict[str, np.ndarray]


def about(_: Arrays) -> Arrays:
    """Describe the model: its input, whether it learns, and its fixed classes (none: any)."""
    known = np.empty(0, "U1")
    return {"takes": np.array("features"), "learns": np.array(True), "classes": known}


def learn(given: Arrays) -> Arrays:
    """Return the mean of each class and the spread of the features, the state for ``scores``."""
    rows, classes = given["features"], given["classes"]
    every = range(len(given["names"]))
    means = [rows[classes == k].mean(axis=0) if (classes == k).any() else 1e6 for k in every]
    state = np.stack([np.broadcast_to(each, rows.shape[1]) for each in means])
    learnt = np.vstack([state, rows.std(axis=0) + 1e-6]).astype(np.float32)
    return {"state": np.frombuffer(learnt.tobytes(), np.uint8)}


def scores(given: Arrays) -> Arrays:
    """Return the score of each class (column) for each cell (row), from their distances."""
    learnt = np.frombuffer(given["state"].tobytes(), np.float32)
    *means, spread = learnt.reshape(len(given["names"]) + 1, -1)
    away = [np.abs((given["features"] - mean) / spread).mean(axis=1) for mean in means]
    return {"scores": np.exp(-4 * np.stack(away, axis=1)).astype(np.float32)}


if __name__ == "__main__":
    serve({"/v1/about": about, "/v1/learn": learn, "/v1/scores": scores}, "model", 9100)
