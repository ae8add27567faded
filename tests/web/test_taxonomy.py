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


def test_palettes_of_templates_and_files_are_added_in_one_edit(served: Served) -> None:
    def post(sequence: str, body: dict[str, object]) -> httpx.Response:
        url = f"{served.url}/api/v1/sequences/{sequence}/palette"
        return httpx.post(url, json=body, headers=served.headers)

    templates = httpx.get(f"{served.url}/api/v1/templates", headers=served.headers).json()
    assert set(templates) == {"semantickitti", "nuscenes", "las", "scannet"}
    answer = post("one", {"template": "scannet"})
    assert answer.status_code == 200, answer.text
    assert len(answer.json()["added"]) == 20
    assert post("one", {"template": "scannet"}).json()["added"] == []
    taxonomy = httpx.get(f"{served.url}/api/v1/taxonomy", headers=served.headers).json()
    bathtub = next(c for c in taxonomy["categories"] if c["name"] == "bathtub")
    assert bathtub["datasets"] == {"scannet": 36}
    url = f"{served.url}/api/v1/sequences/one/palette"
    palette = httpx.get(url, headers=served.headers).json()
    assert len(post("two", palette).json()["added"]) == len(palette["labels"])
    order = httpx.put(f"{url}/order", json={"labels": [3, 1]}, headers=served.headers)
    assert order.status_code == 200, order.text
    shown = httpx.get(f"{served.url}/api/v1/sequences/one/labels", headers=served.headers).json()
    assert [label["id"] for label in shown[:3]] == [3, 1, 2]
    undo = f"{served.url}/api/v1/sequences/two/undo"
    httpx.post(undo, headers=served.headers).raise_for_status()
    url = url.replace("/one/", "/two/")
    assert httpx.get(url, headers=served.headers).json()["labels"] == []
    for body in ({}, {"template": "none"}, {"template": "las", "labels": [{"name": "a"}]}):
        assert post("one", body).status_code in (404, 422)
