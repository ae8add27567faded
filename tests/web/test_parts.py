"""Labels that are split into parts, and merged."""

from __future__ import annotations

import io
import uuid
from collections.abc import Iterator

import httpx
import numpy as np
import pytest

from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from tests.serving import serving, settings_in

FRAMES = 3
CARS = ((0.0, 400), (5.0, 300), (10.0, 200), (15.0, 4))
"""Where each car stands, metres, and how many points it has."""


def cars(seed: int) -> PointFrame:
    random = np.random.default_rng(seed)
    parts = [random.uniform(-0.5, 0.5, (count, 3)) + [x, 0, 0] for x, count in CARS]
    return PointFrame(xyz=np.concatenate(parts).astype(np.float32), rgb=None)


@pytest.fixture
def api(tmp_path_factory: pytest.TempPathFactory) -> Iterator[httpx.Client]:
    settings = settings_in(tmp_path_factory.mktemp("parts"))
    import_frames(
        (cars(seed) for seed in range(FRAMES)),
        settings.workspace / "sequences" / "cars",
        RecordingInfo("cars", "cars", 10.0),
    )
    with (
        serving(settings) as served,
        httpx.Client(base_url=f"{served.url}/api/v1/sequences/cars", headers=served.headers) as api,
    ):
        yield api


def annotation(api: httpx.Client, frame: int) -> np.ndarray:
    return np.asarray(np.load(io.BytesIO(api.get(f"/frames/{frame}/annotation").content)))


def put(api: httpx.Client, frame: int, values: np.ndarray) -> None:
    stream = io.BytesIO()
    np.save(stream, values.astype(np.uint16))
    headers = {"Content-Type": "application/x-npy"}
    answer = api.put(f"/frames/{frame}/annotation", content=stream.getvalue(), headers=headers)
    assert answer.status_code < 300, answer.text


def label(api: httpx.Client, name: str, **fields: object) -> int:
    return int(api.post("/labels", json={"name": name, **fields}).json()["id"])


def which_car() -> np.ndarray:
    return np.repeat(np.arange(len(CARS)), [count for _, count in CARS])


def test_a_split_gives_each_part_a_label_as_one_edit(api: httpx.Client) -> None:
    car = label(api, "car 1", category="car")
    everything = np.full(len(which_car()), car)
    for frame in range(FRAMES):
        put(api, frame, everything)
    edit = str(uuid.uuid4())
    first, repeated = (
        api.post(f"/labels/{car}/split", params={"edit": edit}, json={"frame": 1, "gap": 1.0})
        for _ in range(2)
    )
    split = first.json()
    assert repeated.json() == split
    assert split["changed"] == 500
    second, third = split["labels"]
    # The largest part keeps the label, and so does what is too small to be an object.
    expected = np.array([car, second, third, car])[which_car()]
    assert (annotation(api, 1) == expected).all()
    assert (annotation(api, 0) == car).all()
    named = {one["id"]: one for one in api.get("/labels").json()}
    assert [named[k]["name"] for k in (second, third)] == ["car 2", "car 3"]
    assert named[second]["category"] == "car"
    assert named[second]["color"] != named[third]["color"]
    again = api.post(f"/labels/{second}/split", json={"frame": 1, "gap": 1.0})
    assert again.status_code == 409
    assert "got one" in again.json()["detail"]
    assert api.post("/undo").status_code == 200
    assert (annotation(api, 1) == car).all()
    assert len(api.get("/labels").json()) == 1
    by_spacing = api.post(f"/labels/{car}/split", json={"frame": 1}).json()
    assert len(by_spacing["labels"]) == 2


def test_a_merge_is_one_edit_of_all_frames(api: httpx.Client) -> None:
    one, two, three = (label(api, name) for name in ("one", "two", "three"))
    values = np.array([one, two, three, 0])[which_car()]
    for frame in range(FRAMES):
        put(api, frame, values)
    answer = api.post(f"/labels/{one}/merge", json={"labels": [two, three]})
    assert answer.json()["changed"] == FRAMES * 500
    for frame in range(FRAMES):
        assert (annotation(api, frame) == np.array([one, one, one, 0])[which_car()]).all()
    assert [entry["id"] for entry in api.get("/labels").json()] == [one]
    assert api.get("/edits").json()[0]["summary"] == "merge 'two', 'three' into 'one'"
    api.post("/undo")
    assert (annotation(api, 2) == values).all()
    assert [entry["name"] for entry in api.get("/labels").json()] == ["one", "two", "three"]
    api.post("/redo")
    assert set(np.unique(annotation(api, 2))) == {0, one}


def test_what_cannot_be_merged_or_split_is_refused(api: httpx.Client) -> None:
    one, two = label(api, "one"), label(api, "two", locked=True)
    put(api, 0, np.full(len(which_car()), one))
    refused = {
        422: [f"/labels/{one}/merge", {"labels": [one]}],
        404: [f"/labels/{one}/merge", {"labels": [77]}],
        409: [f"/labels/{one}/merge", {"labels": [two]}],
    }
    for status, (path, body) in refused.items():
        assert api.post(path, json=body).status_code == status
    assert api.post(f"/labels/{two}/split", json={"frame": 0}).status_code == 409
    assert api.post(f"/labels/{one}/split", json={"frame": 99}).status_code == 404
    assert (annotation(api, 0) == one).all()
