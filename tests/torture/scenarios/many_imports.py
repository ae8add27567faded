"""A Dask scheduler begins anew while many recordings are imported."""

from __future__ import annotations

import io
import time
import uuid
from typing import Any

import httpx
import numpy as np
import pytest

from tests.dask_cluster import DaskCluster
from tests.faults.clients import ENDED
from tests.faults.server import running
from tests.serving import settings_in
from tests.torture.authors import quiet
from tests.torture.framework import Arena, Tally, scenario
from tests.torture.librarian import UNFORESEEN
from tests.waiting import eventually

NUMBERS = range(1, 21)
"""Of recordings; each coordinate in a recording is its number."""
POINTS = 5_000
LONGEST = 300.0
"""Seconds in which each job must have ended; longer counts as hanging."""
PARTS = ("worker", "scheduler")


def _content(number: int) -> bytes:
    out = io.BytesIO()
    np.savez(out, xyz=np.full((POINTS, 3), number, np.float32))
    return out.getvalue()


def _begin(api: httpx.Client, number: int) -> str:
    files = [("files", (f"{i}.npz", _content(number))) for i in range(2)]
    fields = {"name": f"scan {number}", "id": str(uuid.uuid4())}
    answer = api.post("/sequences", files=files, data=fields).raise_for_status()
    return str(answer.json()["id"])


def _jobs(api: httpx.Client, wanted: dict[int, str]) -> list[dict[str, Any]]:
    known = {job["id"]: job for job in api.get("/jobs").raise_for_status().json()}
    return [known[job] for job in wanted.values()]


def _all_ended(api: httpx.Client, begun: dict[int, str]) -> bool:
    return all(job["state"] in ENDED for job in _jobs(api, begun))


def _failed(api: httpx.Client, begun: dict[int, str], tally: Tally) -> list[int]:
    """Return the numbers of imports that failed, each of which must say why."""
    eventually(lambda: _all_ended(api, begun), LONGEST, 0.2)
    failed = []
    for number, job in zip(begun, _jobs(api, begun), strict=True):
        if job["state"] == "done":
            tally.answered += 1
            continue
        failed.append(number)
        tally.refused += 1
        if not job["error"] or UNFORESEEN in job["error"]:
            tally.count("errors", f"an import: {job['state']}: {job['error']}")
    return failed


def _compare(api: httpx.Client, tally: Tally) -> None:
    """Each recording is there once, with its points; all are deleted."""
    listed = api.get("/sequences").raise_for_status().json()
    names = sorted(each["name"] for each in listed)
    if names != sorted(f"scan {number}" for number in NUMBERS):
        tally.count("lost", f"recordings: {names}")
    for each in listed:
        path = f"/sequences/{each['id']}/frames/1/points"
        xyz = np.load(io.BytesIO(api.get(path).raise_for_status().content))["xyz"]
        if each["damaged"] or not (xyz == float(each["name"].split()[1])).all():
            tally.count("differs", f"{each['name']}: {each['damaged']}")
        api.delete(f"/sequences/{each['id']}").raise_for_status()


@scenario("a Dask scheduler restarts during imports of 20 recordings", 1)
def dask_imports(arena: Arena) -> None:
    """Each import ends, a failed one says why, and does when it is sent again."""
    pytest.importorskip("distributed")
    cluster = arena.stack.enter_context(DaskCluster())
    settings = settings_in(arena.folder)
    for part in reversed(PARTS):
        cluster.start(part)
    there = {"POINTBRUSH_SCHEDULER": cluster.address}
    server = arena.stack.enter_context(running(settings.workspace, **there))
    for _ in arena.rounds():
        with server.api() as api:
            begun = {number: _begin(api, number) for number in NUMBERS}
            time.sleep(arena.rng.uniform(0.0, 4.0))
            for part in PARTS:
                cluster.kill(part)
            time.sleep(arena.rng.uniform(0.0, 3.0))
            for part in reversed(PARTS):
                cluster.start(part)
            failed = _failed(api, begun, arena.tally)
            begun = {number: _begin(api, number) for number in failed}
            if _failed(api, begun, arena.tally):
                arena.tally.count("lost", "imports that were sent again, and failed")
            _compare(api, arena.tally)
    quiet(server, arena.tally)
