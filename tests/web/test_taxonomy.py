"""Classes over REST: the same numbers in every export."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

from tests.serving import Served, add_sequence, serving, settings_in


def numbers(served: Served, sequence: str) -> dict[str, int]:
    url = f"{served.url}/api/v1/sequences/{sequence}/export"
    answer = httpx.get(url, params={"format": "semantickitti"}, headers=served.headers)
    with zipfile.ZipFile(io.BytesIO(answer.content)) as archive:
        name = next(n for n in archive.namelist() if n.endswith("palette.json"))
        document = json.loads(archive.read(name))
    return {label["category"]: label["category_id"] for label in document["labels"]}


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Served]:
    settings = settings_in(tmp_path)
    for sequence in ("one", "two"):
        add_sequence(settings, sequence, frames=1, points=50)
    with serving(settings) as running:
        yield running


def test_exports_of_two_recordings_agree(served: Served) -> None:
    for sequence, names in (("one", ["car", "person"]), ("two", ["person", "tree", "car"])):
        for name in names:
            labels = f"{served.url}/api/v1/sequences/{sequence}/labels"
            body = {"name": f"{name} 1", "category": name}
            httpx.post(labels, json=body, headers=served.headers).raise_for_status()
    assert numbers(served, "one") == {"car": 1, "person": 2}
    assert numbers(served, "two") == {"person": 2, "tree": 3, "car": 1}
    url = f"{served.url}/api/v1/taxonomy"
    listed = httpx.get(url, headers=served.headers).json()
    assert [(c["number"], c["name"]) for c in listed["categories"]] == [
        (1, "car"),
        (2, "person"),
        (3, "tree"),
    ]
    listed["categories"][0]["datasets"] = {"semantickitti": 10}
    listed["categories"].append(
        {"number": 40, "name": "road", "color": "#808080", "datasets": {"las": 11}}
    )
    put = httpx.put(url, json=listed, headers=served.headers)
    assert put.json() == listed
    moved = {"categories": [{"number": 41, "name": "road"}]}
    assert httpx.put(url, json=moved, headers=served.headers).status_code == 409
