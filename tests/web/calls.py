"""Calls of REST that several files of tests make."""

from __future__ import annotations

import io
from typing import Any

import httpx
import numpy as np

from tests.waiting import eventually


def load(response: httpx.Response) -> Any:
    assert response.status_code == 200, response.text
    return np.load(io.BytesIO(response.content), allow_pickle=False)


def npy(array: np.ndarray[Any, Any]) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def new_label(api: httpx.Client, name: str = "pin", **fields: Any) -> int:
    response = api.post("/sequences/wall/labels", json={"name": name, **fields})
    assert response.status_code == 201, response.text
    assert response.headers["location"].endswith(f"/labels/{response.json()['id']}")
    return int(response.json()["id"])


def stroke(label: int, **fields: Any) -> dict[str, Any]:
    return {
        "label": label,
        "shape": "sphere",
        "radius": 0.4,
        "samples": [{"origin": [0.2, 0.1, 3.0]}],
        **fields,
    }


def wait(api: httpx.Client, job: dict[str, Any]) -> dict[str, Any]:
    def ended() -> dict[str, Any] | None:
        found: dict[str, Any] = api.get(f"/jobs/{job['id']}").json()
        return found if found["state"] in ("done", "failed", "cancelled") else None

    return eventually(ended, every=0.05)  # type: ignore[no-any-return]
