"""The disk of a workspace turns read-only while people paint, and writable again."""

from __future__ import annotations

import io
import time
import uuid

import httpx
import numpy as np

from tests.faults.clients import FRAMES, SEQUENCE
from tests.faults.server import running
from tests.torture.authors import Authors, quiet
from tests.torture.framework import Arena, Tally, scenario
from tests.torture.machine import preloaded
from tests.waiting import eventually

REFUSALS = (403, 503)
"""Read-only, or a database that cannot be used now."""


def _stroke() -> dict[str, object]:
    sample = {"origin": [0.0, 0.0, 1.0]}
    return {"id": str(uuid.uuid4()), "label": 1, "radius": 0.3, "samples": [sample]}


def _look_refused(api: httpx.Client, tally: Tally) -> None:
    """Edits and imports are refused in words; everything can still be looked at."""
    root = f"/sequences/{SEQUENCE}"
    content = io.BytesIO()
    np.savez(content, xyz=np.ones((10, 3), np.float32))
    calls = {
        "a stroke": api.post(f"{root}/frames/0/strokes", json=_stroke()),
        "a label": api.post(f"{root}/labels", json={"name": str(uuid.uuid4())}),
        "a name": api.patch(root, json={"name": "other"}),
        "an import": api.post("/sequences", files=[("files", ("0.npz", content.getvalue()))]),
    }
    for name, answer in calls.items():
        if answer.status_code in REFUSALS and answer.json()["detail"]:
            tally.refused += 1
        else:
            tally.count("differs", f"{name}: {answer.status_code} {answer.text[:500]}")
    for path in ("", "/labels", "/edits", "/frames/0/annotation", f"/frames/{FRAMES - 1}/points"):
        answer = api.get(f"{root}{path}")
        tally.status(answer.status_code, f"{path}: {answer.text[:500]}")


@scenario("a workspace's disk turns read-only and back, while six authors edit", 1)
def disk_remounted(arena: Arena) -> None:
    """A library between the server and the system refuses changes, as a remount does."""
    workspace, switch = arena.folder / "workspace", arena.folder / "read-only"
    authors = Authors(workspace, arena.seed)
    server = arena.stack.enter_context(
        running(
            workspace,
            LD_PRELOAD=preloaded(arena.folder),
            TORTURE_READ_ONLY=str(switch),
            TORTURE_FOLDER=str(workspace),
        )
    )
    tally = arena.tally
    for _ in arena.rounds():
        with authors.editing(lambda: [server.url]), server.api() as api:
            time.sleep(arena.rng.uniform(0.2, 0.8))
            switch.touch()
            try:
                time.sleep(0.2)  # edits under way end
                _look_refused(api, tally)
                time.sleep(arena.rng.uniform(0.0, 1.0))
            finally:
                switch.unlink()
            eventually(lambda: httpx.get(f"{server.url}/readyz").status_code == 200, 30)
            time.sleep(arena.rng.uniform(0.2, 0.8))
        authors.settle(server, tally)
    quiet(server, tally)
