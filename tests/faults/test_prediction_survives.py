"""A server that is killed while it applies a classifier leaves one whole edit, or none."""

from __future__ import annotations

import io
from contextlib import closing
from pathlib import Path

import httpx
import numpy as np

from pointbrush.workspace import Workspace
from tests.faults.server import ServerProcess, running
from tests.serving import add_sequence, settings_in
from tests.waiting import eventually

FRAMES, POINTS = 10, 20_000


def npy(values: np.ndarray) -> bytes:
    out = io.BytesIO()
    np.save(out, values)
    return out.getvalue()


def teach(api: httpx.Client) -> str:
    """Paint two sides of the wall in the first frame, and make a classifier of that."""
    for name in ("left", "right"):
        api.post("/sequences/wall/labels", json={"name": name}).raise_for_status()
    xyz = np.load(io.BytesIO(api.get("/sequences/wall/frames/0/points").content))["xyz"]
    labels = np.where(xyz[:, 0] < -1.5, 1, np.where(xyz[:, 0] > 1.5, 2, 0)).astype(np.uint16)
    where = "/sequences/wall/frames/0/annotation"
    api.put(where, content=npy(labels)).raise_for_status()
    painted = npy((labels > 0).astype(np.uint8))
    api.put(where, params={"layer": "provenance"}, content=painted).raise_for_status()
    body = {"name": "sides", "recordings": ["wall"]}
    return str(api.post("/classifiers", json=body).raise_for_status().json()["id"])


def test_a_kill_while_a_classifier_is_applied_leaves_the_journal_whole(tmp_path: Path) -> None:
    settings = settings_in(tmp_path)
    add_sequence(settings, "wall", frames=FRAMES, points=POINTS)
    with running(settings.workspace) as first, first.api() as api:
        body = {"classifier": teach(api), "frames": ""}
        answer = api.post("/sequences/wall/predictions", json=body).raise_for_status()
        job = str(answer.json()["id"])
        eventually(lambda: 0 < float(api.get(f"/jobs/{job}").json()["progress"]) < 1, every=0.005)
        before = len(api.get("/sequences/wall/edits").json())
        ServerProcess.kill(first)
    with running(settings.workspace) as second, second.api() as api:
        eventually(lambda: api.get(f"/jobs/{job}").json()["state"] in ("done", "failed"))
        assert api.get(f"/jobs/{job}").json()["state"] == "done"
        edits = api.get("/sequences/wall/edits").json()
        assert len(edits) == before + 1
        assert edits[0]["kind"] == "prediction"
        assert len(edits[0]["frames"]) == FRAMES
    with closing(Workspace(settings)) as workspace:
        assert workspace.labels.check("wall") == []
