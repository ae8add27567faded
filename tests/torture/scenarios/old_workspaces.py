"""A workspace of the first version, in which a run is begun and the server killed."""

from __future__ import annotations

import io
import time

import httpx
import numpy as np

from tests.faults.server import ServerProcess, running
from tests.old_workspace import EXPECTED, old_workspace
from tests.torture.authors import at_rest, quiet
from tests.torture.framework import Arena, Tally, scenario
from tests.waiting import eventually

RUN = {"start": 0, "stop": 2, "method": "icp", "overwrite": "all"}
ROOT = "/sequences/ball"


@scenario("SIGKILL during a tracking run in a workspace of an early version", 1)
def early_workspace(arena: Arena) -> None:
    """The version that wrote it left no trace of runs under way; this one's run begins again."""
    for number in arena.rounds():
        workspace = old_workspace(arena.folder / str(number)).workspace
        with running(workspace) as server:
            _compare(server, arena.tally)
            with server.api() as api:
                answer = api.post(f"{ROOT}/tracking", json=RUN)
                arena.tally.status(answer.status_code, answer.text)
                time.sleep(arena.rng.uniform(0.0, 1.0))
            server.kill()
        with running(workspace) as server:
            with server.api() as api:
                eventually(lambda api=api: at_rest(api))
                job = api.get(f"/jobs/{answer.json()['id']}").raise_for_status().json()
                if job["state"] != "done":
                    arena.tally.count("lost", f"a run that was begun: {job}")
                elif job["result"]["edit"] is not None:
                    undone = api.post(f"{ROOT}/undo")
                    arena.tally.status(undone.status_code, undone.text)
            _compare(server, arena.tally)
            quiet(server, arena.tally)


def _compare(server: ServerProcess, tally: Tally) -> None:
    """Compare labels, tracks and tokens with what the version told that wrote them."""
    with server.api() as api:
        for sequence, told in EXPECTED["sequences"].items():
            for frame, wanted in enumerate(told["annotation"]):
                answer = api.get(f"/sequences/{sequence}/frames/{frame}/annotation")
                if tally.status(answer.status_code, answer.text[:200]):
                    numbers, counts = np.unique(
                        np.load(io.BytesIO(answer.content)), return_counts=True
                    )
                    found = dict(zip(map(str, numbers.tolist()), counts.tolist(), strict=True))
                    if found != wanted:
                        tally.count("differs", f"{sequence} {frame}: {found}, expected {wanted}")
            tracks = api.get(f"/sequences/{sequence}/tracks").json()
            if len(tracks) != told["tracks"]:
                tally.count("differs", f"{sequence}: {len(tracks)} tracks, not {told['tracks']}")
    admitted = [_admitted(server, secret) for secret in EXPECTED["secrets"].values()]
    if admitted.count(False) != 1:
        tally.count("differs", f"tokens that let somebody in: {admitted}")


def _admitted(server: ServerProcess, secret: str) -> bool:
    answer = httpx.get(f"{server.url}/api/v1/me", headers={"Authorization": f"Bearer {secret}"})
    return answer.status_code == 200
