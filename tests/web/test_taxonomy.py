"""Classes over REST: the same numbers in every export."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

from pointbrush.client import BoxAttribute, BoxPose, Category, Client
from pointbrush.errors import BadInputError, ConflictError, NotFoundError
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
    sizes = {"size": [4.5, 1.8, 1.6], "spread": [0.4, 0.1, 0.1]}
    listed["categories"][0] |= sizes
    road = {"number": 40, "name": "road", "color": "#808080", "datasets": {"las": 11}}
    listed["categories"].append({**road, "size": None, "spread": None})
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


def test_boxes_have_the_attributes_that_the_taxonomy_defines(served: Served) -> None:
    defined = [
        BoxAttribute("door", "choice", "frame", ("open", "shut")),
        BoxAttribute("riders", "number"),
        BoxAttribute("towed", "yes/no"),
    ]
    with Client(served.url, served.token) as client:
        client.change_taxonomy(attributes=defined)
        assert client.box_attributes() == defined
        one = client["one"]
        one.create_label("car")
        place = ((0.0, 0.0, 3.0), (0.0, 0.0, 0.0, 1.0))
        pose = BoxPose(*place, attributes={"door": "open", "truncated": 0.5})
        made = one.boxes.add(1, (4, 2, 1.5), {0: pose}, {"riders": 2, "towed": True, "occluded": 3})
        assert made.poses[0].attributes == {"door": "open", "truncated": 0.5}
        refused: list[dict[str, float | str | bool]] = [
            {"colour": "red"}, {"riders": "two"}, {"towed": 1}, {"door": "open"}, {"occluded": 4},
        ]  # fmt: skip
        for attributes in refused:
            with pytest.raises(BadInputError):
                one.boxes.change(made.id, attributes=attributes)
        wrong: list[dict[str, float | str | bool]] = [
            {"door": "ajar"}, {"riders": 1}, {"truncated": 2},
        ]  # fmt: skip
        for attributes in wrong:
            with pytest.raises(BadInputError):
                one.boxes.change(made.id, poses={0: BoxPose(*place, attributes=attributes)})
        assert one.boxes[made.id] == made
        client.change_taxonomy([Category(1, "car", size=(4.5, 1.8, 1.6))])
        assert client.box_attributes() == defined
        assert client.taxonomy()[0].size == (4.5, 1.8, 1.6)
        client.change_taxonomy(attributes=[])
        assert client.box_attributes() == []


@pytest.mark.parametrize(
    "attribute",
    [
        {"name": "parked", "kind": "yes/no"},
        {"name": "door", "kind": "choice"},
        {"name": "door", "kind": "text", "choices": ["open"]},
        {"name": "door", "kind": "choice", "choices": ["open", "open"]},
        {"name": "door", "kind": "colour"},
    ],
)
def test_attributes_that_cannot_be_are_refused(served: Served, attribute: dict[str, str]) -> None:
    url = f"{served.url}/api/v1/taxonomy"
    answer = httpx.put(url, json={"attributes": [attribute]}, headers=served.headers)
    assert answer.status_code in (400, 422), answer.text


def test_classes_are_merged_and_deleted_by_their_numbers(served: Served) -> None:
    with Client(served.url, served.token) as client:
        one = client["one"]
        for name in ("car", "auto", "tree"):
            one.create_label(f"a {name}", category=name)
        known = {each.name: each.number for each in client.taxonomy()}
        client.merge_categories(known["car"], [known["auto"]])
        client.change_taxonomy([Category(known["car"], "vehicle")])
        assert [label.category for label in one.labels()] == ["vehicle", "vehicle", "tree"]
        with pytest.raises(ConflictError, match="'tree' has 1 labels"):
            client.delete_category(known["tree"])
        one.update_label(3, category="vehicle")
        client.delete_category(known["tree"])
        with pytest.raises(NotFoundError):
            client.delete_category(known["tree"])
        assert [(each.number, each.name) for each in client.taxonomy()] == [
            (known["car"], "vehicle")
        ]
