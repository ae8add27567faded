"""Boxes over REST, and as viewers hear of them."""

from __future__ import annotations

import asyncio
import uuid
from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pytest

from pointbrush.client import BoxPose, Client
from pointbrush.errors import NotFoundError
from tests.serving import Served
from tests.streaming.client import Viewer, viewer
from tests.waiting import PATIENCE

PLACE = {"centre": [1.0, 2.0, 3.0], "quaternion": [0.0, 0.0, 0.6, 0.8]}


@pytest.fixture
def api(served: Served) -> Iterator[httpx.Client]:
    base = f"{served.url}/api/v1/sequences/wall"
    with httpx.Client(base_url=base, headers=served.headers) as client:
        client.post("/labels", json={"name": "car"})
        yield client


def new(**more: Any) -> dict[str, Any]:
    return {"label": 1, "size": [4.2, 1.8, 1.5], "poses": {"0": PLACE, "2": PLACE}, **more}


def test_a_box_is_added_changed_listed_and_removed(api: httpx.Client) -> None:
    edit = str(uuid.uuid4())
    added = api.post("/boxes", json=new(edit=edit, attributes={"parked": True, "occluded": 1}))
    assert added.status_code == 201, added.text
    box = added.json()["box"]
    assert added.json()["edit"] == edit
    assert box["attributes"] == {"parked": True, "occluded": 1}
    assert box["poses"]["2"] == {
        **PLACE, "provenance": "drawn", "confidence": 1.0, "attributes": {},
    }  # fmt: skip
    assert api.post("/boxes", json=new(edit=edit)).json()["box"] == box
    where = added.headers["Location"].rpartition("/wall")[2]
    assert box["heading_known"] is True
    change = {
        "heading_known": False,
        "size": [4.0, 1.7, 1.4],
        "attributes": {"parked": None},
        "poses": {"0": None, "2": {"attributes": {"truncated": 0.5}}, "3": PLACE},
    }
    changed = api.patch(where, json=change).json()["box"]
    assert (changed["size"], changed["attributes"]) == ([4.0, 1.7, 1.4], {"occluded": 1})
    assert changed["heading_known"] is False
    assert list(changed["poses"]) == ["2", "3"]
    assert changed["poses"]["2"] == {**box["poses"]["2"], "attributes": {"truncated": 0.5}}
    assert api.get(where).json() == changed
    assert api.get("/boxes", params={"frame": 3, "label": 1}).json()["boxes"] == [changed]
    assert api.get("/boxes", params={"frame": 0}).json()["boxes"] == []
    assert api.delete(where).status_code == 200
    assert api.get(where).status_code == 404
    assert api.post("/undo").status_code == 200
    assert api.get(where).json() == changed
    api.delete(where)


@pytest.mark.parametrize(
    ("body", "status"),
    [
        (new(size=[1, 0, 1]), 400),
        (new(poses={}), 422),
        (new(poses={"-1": PLACE}), 422),
        (new(poses={"999": PLACE}), 404),
        (new(poses={"0": {**PLACE, "quaternion": [0, 0, 0, 0]}}), 400),
        (new(label=60000), 404),
        (new(attributes={"a": [1]}), 422),
        (new(colour="red"), 422),
    ],
)
def test_what_cannot_be_is_refused(api: httpx.Client, body: dict[str, Any], status: int) -> None:
    answer = api.post("/boxes", json=body)
    assert answer.status_code in (status, 422 if status == 400 else status), answer.text
    assert answer.headers["content-type"] == "application/problem+json"


def test_boxes_of_a_locked_label_are_not_changed(api: httpx.Client) -> None:
    label = api.post("/labels", json={"name": "locked"}).json()["id"]
    box = api.post("/boxes", json=new(label=label)).json()["box"]["id"]
    api.patch(f"/labels/{label}", json={"locked": True})
    answers = [
        api.post("/boxes", json=new(label=label)),
        api.patch(f"/boxes/{box}", json={"size": [1.0, 1.0, 1.0]}),
        api.delete(f"/boxes/{box}"),
    ]
    assert [answer.status_code for answer in answers] == [409] * 3


def test_viewers_hear_of_every_change(served: Served, api: httpx.Client) -> None:
    box = api.post("/boxes", json=new()).json()["box"]

    async def until(client: Viewer, revision: int) -> dict[str, Any]:
        while True:
            message = await client.until("boxes")
            if message["revision"] >= revision:
                return message

    async def scenario() -> None:
        async with (
            viewer(served.url, served.token) as client,
            httpx.AsyncClient(base_url=api.base_url, headers=served.headers) as others,
        ):
            await client.hello()
            await client.open("wall")
            first = await client.until("boxes")
            assert first["whole"]
            assert box in first["boxes"]
            changed = await others.patch(f"/boxes/{box['id']}", json={"size": [2.0, 1.0, 1.0]})
            told = await until(client, changed.json()["revision"])
            assert (told["whole"], told["removed"]) == (False, [])
            assert told["boxes"] == [changed.json()["box"]]
            gone = await others.delete(f"/boxes/{box['id']}")
            told = await until(client, gone.json()["revision"])
            assert (told["boxes"], told["removed"]) == ([], [box["id"]])

    asyncio.run(asyncio.wait_for(scenario(), PATIENCE))


def test_the_client_has_boxes(served: Served, api: httpx.Client) -> None:
    with Client(served.url, served.token) as client:
        wall = client["wall"]
        pose = BoxPose((0.3, 0.2, 3.0), (0.0, 0.0, 0.6, 0.8))
        made = wall.boxes.add(1, (0.8, 0.4, 1.0), {0: pose, 2: pose}, {"parked": True})
        assert wall.boxes[made.id] == made
        assert made.poses[2] == pose
        changed = wall.boxes.change(made.id, poses={2: None}, attributes={"parked": None})
        assert (list(changed.poses), changed.attributes) == ([0], {})
        assert made.id not in [box.id for box in wall.boxes.all(frame=2)]
        assert wall.boxes.paint(made.id, "0").changed > 0
        wall.undo()
        wall.boxes.remove(made.id)
        with pytest.raises(NotFoundError):
            wall.boxes[made.id]


def test_boxes_are_a_table_where_pandas_is(served: Served, api: httpx.Client) -> None:
    pytest.importorskip("pandas")
    with Client(served.url, served.token) as client:
        api.post("/boxes", json=new(attributes={"occluded": 1}))
        table = client["wall"].boxes.frame(frame=2)
        found = table[["frame", "length", "qw", "occluded"]].to_numpy().tolist()
        assert found == [[2, 4.2, 0.8, 1]]
        client["wall"].undo()


def test_points_of_a_box_are_labelled_as_one_edit(served: Served, api: httpx.Client) -> None:
    store, recording = served.workspace.labels, served.workspace.recording("wall")
    before = [store.values("wall", frame).label for frame in (0, 2)]
    place = {"centre": [0.3, 0.2, 3.0], "quaternion": [0.0, 0.0, 0.6, 0.8]}
    poses = {"0": place, "2": {**place, "centre": [-0.5, 0.0, 3.0]}}
    box = api.post("/boxes", json=new(size=[0.8, 0.4, 1.0], poses=poses)).json()["box"]["id"]
    answer = api.post(f"/boxes/{box}/points", json={})
    drawn, changed = store.boxes.get("wall", box), 0
    for frame, old in zip((0, 2), before, strict=True):
        T = drawn.poses[frame].transform
        local = (recording[frame].coordinates.astype(float) - T[:3, 3]) @ T[:3, :3]
        inside = (np.abs(local) <= drawn.size / 2).all(axis=1)
        assert inside.any()
        now = store.values("wall", frame).label
        assert ((now == 1) == (inside | (old == 1))).all()
        changed += int((now != old).sum())
    assert answer.json()["changed"] == changed
    api.post("/undo")
    assert all(
        (store.values("wall", f).label == b).all() for f, b in zip((0, 2), before, strict=True)
    )
    assert api.post(f"/boxes/{box}/points", json={"frames": "1"}).status_code in (400, 422)
    api.post(f"/boxes/{box}/points", json={"frames": "2"})
    assert (store.values("wall", 0).label == before[0]).all()
    api.post("/undo")
    api.delete(f"/boxes/{box}")
