"""Labels made elsewhere over REST: uploaded, or from a path under the import roots."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from tests.serving import Served, add_sequence, serving, settings_in
from tests.waiting import eventually

POINTS = 50


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Served]:
    settings = settings_in(tmp_path, import_roots=str(tmp_path / "inbox"))
    (tmp_path / "inbox").mkdir()
    add_sequence(settings, "wall", frames=1, points=POINTS)
    with serving(settings) as running:
        yield running


def ended(served: Served, answer: httpx.Response) -> Any:
    assert answer.status_code == 202, answer.text
    url = f"{served.url}/api/v1/jobs/{answer.json()['id']}"

    def job() -> Any:
        found = httpx.get(url, headers=served.headers).json()
        return found if found["state"] in ("done", "failed") else None

    return eventually(job)


def test_labels_come_in_by_upload_and_by_path(served: Served, tmp_path: Path) -> None:
    url = f"{served.url}/api/v1/sequences/wall/annotations"
    packed = (np.arange(POINTS) % 2 * 40).astype("<u4").tobytes()
    files = {"files": ("000000.label", packed)}
    dry = httpx.post(url, params={"dry_run": "true"}, files=files, headers=served.headers)
    report = ended(served, dry)["result"]
    assert (report["labelled"], report["edit"]) == (25, None)
    (tmp_path / "inbox" / "000000.label").write_bytes(packed)
    body = {"path": str(tmp_path / "inbox" / "000000.label"), "map": "40 street"}
    report = ended(served, httpx.post(url, json=body, headers=served.headers))["result"]
    assert (report["changed"], report["new_labels"]) == (25, ["street"])
    url = f"{served.url}/api/v1/sequences/wall/labels"
    assert [label["name"] for label in httpx.get(url, headers=served.headers).json()] == ["street"]


def test_paths_outside_the_roots_and_other_bodies_are_refused(
    served: Served, tmp_path: Path
) -> None:
    url = f"{served.url}/api/v1/sequences/wall/annotations"
    (tmp_path / "a.label").write_bytes(bytes(200))
    outside = httpx.post(url, json={"path": str(tmp_path / "a.label")}, headers=served.headers)
    assert outside.status_code in (403, 404)
    wrong = httpx.post(url, json={"path": "x", "format": "nothing"}, headers=served.headers)
    assert wrong.status_code == 422
    files = {"files": ("000000.label", bytes(8))}
    failed = ended(served, httpx.post(url, files=files, headers=served.headers))
    assert "expected 50 labels, one for each point of frame 0, got 2" in failed["error"]
