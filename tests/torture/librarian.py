"""Somebody who imports recordings while others edit, and the comparison of what is left of them."""

from __future__ import annotations

import io
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import httpx
import numpy as np
from numpy.typing import NDArray

from tests.faults.clients import ENDED, SEQUENCE
from tests.faults.server import TOKEN, ServerProcess
from tests.torture.framework import Arena

PAUSE = 0.1
"""Seconds between two looks at a job, and before the next try."""
FAR = 120.0
UNFORESEEN = "unexpectedly"
"""Word of a job that failed for a reason which nobody foresaw."""


class Librarian:
    """Imports recordings of one frame at a server, one after another."""

    def __init__(self, arena: Arena, points: int = 5_000) -> None:
        """``points``: of each recording."""
        self._tally, self._points = arena.tally, points
        self._random = np.random.default_rng(arena.seed)
        self._kept: dict[str, NDArray[np.float32]] = {}

    @contextmanager
    def importing(self, address: Callable[[], str]) -> Iterator[None]:
        """Import until the context ends; ``address`` of the server, "" while there is none."""
        stop = threading.Event()
        thread = threading.Thread(target=self._work, args=(address, stop), daemon=True)
        thread.start()
        try:
            yield
        finally:
            stop.set()
            thread.join(2 * FAR)
            assert not thread.is_alive(), "an import without an end"

    def _work(self, address: Callable[[], str], stop: threading.Event) -> None:
        while not stop.wait(PAUSE):
            if url := address():
                headers = {"Authorization": f"Bearer {TOKEN}"}
                with httpx.Client(base_url=f"{url}/api/v1", headers=headers, timeout=FAR) as api:
                    try:
                        self._one(api)
                    except httpx.TransportError:
                        continue

    def _one(self, api: httpx.Client) -> None:
        xyz = self._random.normal(size=(self._points, 3)).astype(np.float32)
        content = io.BytesIO()
        np.savez(content, xyz=xyz)
        response = api.post(
            "/sequences",
            files=[("files", ("0.npz", content.getvalue()))],
            data={"name": "book", "id": str(uuid.uuid4())},
        )
        if not self._tally.status(response.status_code, response.text, away=True):
            return
        job = self._ended(api, response.json())
        if job["state"] == "done":
            self._kept[job["sequence"]] = xyz
        elif UNFORESEEN in str(job["error"]):
            self._tally.count("errors", f"an import: {job['error']}")
        else:
            self._tally.refused += 1

    def _ended(self, api: httpx.Client, job: dict[str, Any]) -> dict[str, Any]:
        while job["state"] not in ENDED:
            time.sleep(PAUSE)
            response = api.get(f"/jobs/{job['id']}")
            if self._tally.status(response.status_code, response.text, away=True):
                job = response.json()
        return job

    def settle(self, server: ServerProcess) -> None:
        """Compare every recording that was imported, and delete it."""
        with server.api() as api:
            listed = {each["id"] for each in api.get("/sequences").raise_for_status().json()}
            for sequence, xyz in self._kept.items():
                if sequence not in listed:
                    self._tally.count("lost", f"{sequence} was imported, and is not listed")
                    continue
                self._compare(api, sequence, xyz)
            for sequence in listed - {SEQUENCE}:
                api.delete(f"/sequences/{sequence}").raise_for_status()
        self._kept.clear()

    def _compare(self, api: httpx.Client, sequence: str, xyz: NDArray[np.float32]) -> None:
        response = api.get(f"/sequences/{sequence}/frames/0/points")
        if self._tally.status(response.status_code, response.text):
            found = np.load(io.BytesIO(response.content))["xyz"]
            if not np.array_equal(found, xyz):
                self._tally.count("differs", f"the points of {sequence}")
