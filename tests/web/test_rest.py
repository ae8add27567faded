"""The contract's REST calls, over a real server."""

from __future__ import annotations

import io
import re
import socket
import uuid
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import httpx
import numpy as np
import pytest

from tests.serving import Served, surface
from tests.waiting import PATIENCE
from tests.web.calls import load, new_label, npy, stroke
from tests.web.test_auth import problem


def test_the_manifest_tells_frames_points_fields_and_bounds(api: httpx.Client) -> None:
    manifest = api.get("/sequences/wall").json()
    assert [entry["id"] for entry in api.get("/sequences").json()] == ["wall"]
    assert manifest["frames"] == 4
    assert manifest["points"] == [3000, 3010, 3020, 3030]
    assert set(manifest["fields"]) >= {"xyz", "rgb"}
    lo, hi = np.array(manifest["bounds"]["lo"]), np.array(manifest["bounds"]["hi"])
    xyz = surface(3000, 0).xyz
    assert (lo <= xyz.min(axis=0) + 1e-6).all()
    assert (hi >= xyz.max(axis=0) - 1e-6).all()


def test_points_are_the_sources_own(api: httpx.Client) -> None:
    given = surface(3010, 1)
    points = load(api.get("/sequences/wall/frames/1/points"))
    np.testing.assert_array_equal(points["xyz"], given.xyz)
    np.testing.assert_array_equal(points["rgb"], given.rgb)
    archive = load(api.get("/sequences/wall/frames/1/points?format=npz"))
    np.testing.assert_array_equal(archive["xyz"], given.xyz)
    np.testing.assert_array_equal(archive["rgb"], given.rgb)


def test_stroke_paints_the_ball_and_only_once(api: httpx.Client) -> None:
    label = new_label(api)
    body = stroke(label, id=str(uuid.uuid4()))
    first = api.post("/sequences/wall/frames/0/strokes", json=body)
    assert first.status_code == 200
    again = api.post("/sequences/wall/frames/0/strokes", json=body)
    assert again.json() == first.json()
    inside = np.linalg.norm(surface(3000, 0).xyz - np.float32([0.2, 0.1, 3.0]), axis=1) <= 0.4
    values = load(api.get("/sequences/wall/frames/0/annotation"))
    assert first.json()["changed"] == inside.sum() > 0
    np.testing.assert_array_equal(values == label, inside)
    provenance = load(api.get("/sequences/wall/frames/0/annotation?layer=provenance"))
    np.testing.assert_array_equal(provenance == 1, inside)


def test_concurrent_resends_apply_once(api: httpx.Client) -> None:
    label = new_label(api)
    body = stroke(label, id=str(uuid.uuid4()))
    with ThreadPoolExecutor(8) as pool:
        answers = list(
            pool.map(
                lambda _: api.post("/sequences/wall/frames/3/strokes", json=body).json(), range(8)
            )
        )
    assert all(answer == answers[0] for answer in answers)


def test_undo_redo_and_history(api: httpx.Client) -> None:
    label = new_label(api)
    before = load(api.get("/sequences/wall/frames/2/annotation"))
    done = api.post("/sequences/wall/frames/2/strokes", json=stroke(label)).json()
    painted = load(api.get("/sequences/wall/frames/2/annotation"))
    request = {"id": str(uuid.uuid4())}
    undone = api.post("/sequences/wall/undo", json=request)
    assert undone.status_code == 200
    assert api.post("/sequences/wall/undo", json=request).json() == undone.json()
    assert (load(api.get("/sequences/wall/frames/2/annotation")) == before).all()
    assert api.post("/sequences/wall/redo").status_code == 200
    assert (load(api.get("/sequences/wall/frames/2/annotation")) == painted).all()
    history = api.get("/sequences/wall/edits?limit=50").json()
    assert history[0]["revision"] > history[1]["revision"]
    entry = next(edit for edit in history if edit["id"] == done["edit"])
    assert entry["author"] == "owner"
    assert entry["frames"] == [2]
    assert entry["points"] == done["changed"]
    assert re.fullmatch(r"paint [\d,]+ points as 'pin'", entry["summary"])
    page = api.get(f"/sequences/wall/edits?before={history[1]['revision']}&limit=1").json()
    assert page == history[2:3]


def test_who_has_done_nothing_can_undo_nothing(served: Served) -> None:
    secret = served.workspace.labels.tokens.add("annotator", "newcomer")
    headers = {"Authorization": f"Bearer {secret}"}
    problem(httpx.post(f"{served.url}/api/v1/sequences/wall/undo", headers=headers), 409)


def test_annotation_round_trip_with_etag(api: httpx.Client) -> None:
    label = new_label(api)
    url = "/sequences/wall/frames/1/annotation"
    response = api.get(url)
    tag = response.headers["etag"]
    assert api.get(url, headers={"If-None-Match": tag}).status_code == 304
    values = load(response).copy()
    assert values.dtype == np.uint16
    values[:100] = label
    put = api.put(url, content=npy(values), headers={"If-Match": tag})
    assert put.status_code == 200
    assert put.headers["etag"] != tag
    np.testing.assert_array_equal(load(api.get(url)), values)
    problem(api.put(url, content=npy(values), headers={"If-Match": tag}), 409)
    problem(api.put(url, content=npy(values), headers={"If-Match": "nonsense"}), 422)


def test_the_deleted_layer_is_put_and_read_back(api: httpx.Client) -> None:
    url = "/sequences/wall/frames/1/annotation?layer=deleted"
    deleted = load(api.get(url)).copy()
    assert deleted.dtype == np.bool_
    deleted[7] = True
    assert api.put(url, content=npy(deleted)).json()["changed"] == 1
    np.testing.assert_array_equal(load(api.get(url)), deleted)


@pytest.mark.parametrize(
    ("body", "status"),
    [
        (b"", 400),
        (b"no npy at all", 400),
        (b"\x93NUMPY\x09\x00\x10\x00", 400),
        (b"\x93NUMPY\x01\x00\x10\x00{'descr': nonsen", 400),
        (npy(np.zeros(3010, np.uint16))[:-1], 400),
        (npy(np.zeros(3010, np.uint16)) + b"more", 400),
        (npy(np.zeros(3011, np.uint16)), 422),
        (npy(np.zeros((3010, 1), np.uint16)), 422),
        (npy(np.zeros(3010, np.int64)), 422),
        (npy(np.zeros(3010, np.float32)), 422),
        (npy(np.full(3010, 60_000, np.uint16)), 422),
        (npy(np.zeros(100_000, np.uint16))[:150_000], 413),
    ],
    ids=lambda value: f"{len(value)}" if isinstance(value, bytes) else value,
)
def test_bad_annotations_change_nothing(api: httpx.Client, body: bytes, status: int) -> None:
    url = "/sequences/wall/frames/1/annotation"
    before = api.get(url)
    problem(api.put(url, content=body), status)
    problem(api.put(url, content=iter([body])), status)
    assert api.get(url).headers["etag"] == before.headers["etag"]


def test_a_body_stated_too_large_is_refused_before_it_comes(served: Served) -> None:
    host, port = served.url.removeprefix("http://").split(":")
    with socket.create_connection((host, int(port)), timeout=PATIENCE) as raw:
        raw.sendall(
            b"PUT /api/v1/sequences/wall/frames/1/annotation HTTP/1.1\r\n"
            b"Host: localhost\r\nContent-Length: 30000000000\r\n"
            + f"Authorization: Bearer {served.token}\r\n\r\n".encode()
        )
        assert raw.recv(100).startswith(b"HTTP/1.1 413")


def test_pickles_are_refused(api: httpx.Client) -> None:
    stream = io.BytesIO()
    np.save(stream, np.array([{"a": 1}] * 3010, object), allow_pickle=True)
    problem(api.put("/sequences/wall/frames/1/annotation", content=stream.getvalue()), 422)


def test_a_label_is_made_changed_and_deleted(api: httpx.Client) -> None:
    number = new_label(api, "club", category="prop", color="#12ab34")
    url = f"/sequences/wall/labels/{number}"
    assert api.get(url).json() == {
        "id": number, "name": "club", "category": "prop", "color": "#12ab34",
        "locked": False, "visible": True,
    }  # fmt: skip
    assert api.patch(url, json={"name": "ball", "visible": False}).json()["name"] == "ball"
    assert api.get(url).json()["visible"] is False
    assert api.delete(url).status_code == 200
    problem(api.get(url), 404)
    hidden = new_label(api, "hidden", visible=False, locked=True)
    assert api.get(f"/sequences/wall/labels/{hidden}").json()["locked"] is True


def test_a_change_of_the_palette_that_is_sent_again_counts_once(api: httpx.Client) -> None:
    def history() -> list[str]:
        return [edit["id"] for edit in api.get("/sequences/wall/edits").json()]

    before = len(history())
    url, ids = "/sequences/wall/labels", [str(uuid.uuid4()) for _ in range(3)]
    body = {"name": "n" * 200, "locked": True}
    made = [api.post(url, params={"edit": ids[0]}, json=body).json() for _ in range(2)]
    assert made[0] == made[1]
    assert made[0]["locked"] is True
    url += f"/{made[0]['id']}"
    free = {"locked": False}
    assert [api.patch(url, params={"edit": ids[1]}, json=free).json() for _ in range(2)] == [
        made[0] | free
    ] * 2
    gone = [api.delete(url, params={"edit": ids[2]}).json() for _ in range(2)]
    assert gone[0] == gone[1]
    assert history()[: len(history()) - before] == ids[::-1]


def test_locked_labels_are_never_changed(api: httpx.Client) -> None:
    label, other = new_label(api, "done"), new_label(api, "other")
    api.post("/sequences/wall/frames/0/strokes", json=stroke(label))
    api.patch(f"/sequences/wall/labels/{label}", json={"locked": True})
    before = load(api.get("/sequences/wall/frames/0/annotation"))
    problem(api.post("/sequences/wall/frames/0/strokes", json=stroke(label)), 409)
    problem(api.delete(f"/sequences/wall/labels/{label}"), 409)
    api.post("/sequences/wall/frames/0/strokes", json=stroke(other, radius=1.0))
    after = load(api.get("/sequences/wall/frames/0/annotation"))
    np.testing.assert_array_equal(after == label, before == label)
    api.patch(f"/sequences/wall/labels/{label}", json={"locked": False})


def test_a_stretch_is_accepted_and_cleared_by_one_call_each(api: httpx.Client) -> None:
    label = new_label(api, "stretch")
    body = {"labels": [label], "start": 1, "stop": 0, "id": str(uuid.uuid4())}
    for what in ("accept", "clear"):
        path = f"/sequences/wall/{what}"
        answers = [api.post(path, json=body | {"id": str(uuid.uuid4())}).json() for _ in range(2)]
        assert [answer["changed"] for answer in answers] == [0, 0]
        problem(api.post(path, json=body | {"stop": 1_000_000}), 404)
        problem(api.post(path, json=body | {"labels": []}), 422)


def test_if_match_is_of_one_frame(api: httpx.Client) -> None:
    label = new_label(api)

    def url(frame: int, layer: str = "label") -> str:
        return f"/sequences/wall/frames/{frame}/annotation?layer={layer}"

    def tags() -> list[int]:
        return [int(api.get(url(frame)).headers["etag"].strip('"')) for frame in range(3)]

    def put(values: np.ndarray[Any, Any], tag: int) -> httpx.Response:
        return api.put(url(0), content=npy(values), headers={"If-Match": f'"{tag}"'})

    before, zeros = tags(), np.zeros_like(np.load(io.BytesIO(api.get(url(0)).content)))
    wide = stroke(label) | {"radius": 100.0}
    painted = api.post("/sequences/wall/frames/1/strokes", json=wide).json()["revision"]
    assert tags() == [before[0], painted, before[2]]
    for layer in ("provenance", "deleted"):
        assert api.get(url(1, layer)).headers["etag"] == f'"{painted}"'
    # Somebody painted in frame 1; frame 0 is as it was, also for who knows a newer revision.
    first = put(zeros + label, before[0])
    assert first.headers["etag"] == f'"{first.json()["revision"]}"'
    second = put(zeros, first.json()["revision"])
    assert second.status_code == 200
    refused = problem(put(zeros, painted), 409)
    assert "frame 0 was changed at revision" in refused
    future = second.json()["revision"] + 1
    assert "expected at most" in problem(put(zeros, future), 409)
    # What changes nothing is an edit, but no change of the frame.
    idle = put(zeros, second.json()["revision"])
    assert idle.headers["etag"] == second.headers["etag"]
    # Deleting a label changes the frames that it is in, and so does undoing that.
    gone = api.delete(f"/sequences/wall/labels/{label}").json()["revision"]
    assert tags() == [second.json()["revision"], gone, before[2]]
    back = api.post("/sequences/wall/undo").json()["revision"]
    assert tags() == [second.json()["revision"], back, before[2]]
    api.delete(f"/sequences/wall/labels/{label}")


BAD_STROKES = [
    ({"radius": -1.0}, 422),
    ({"radius": 0}, 422),
    ({"radius": "NaN"}, 422),
    ({"label": 60_001}, 404),
    ({"label": 0}, 422),
    ({"label": 70_000}, 422),
    ({"shape": "ray", "samples": [{"origin": [0, 0, 0], "direction": [0, 0, 0]}]}, 422),
    ({"samples": []}, 422),
    ({"samples": [{"origin": [0, 0]}]}, 422),
    ({"samples": [{"origin": [0, 0, "x"]}]}, 422),
    ({"samples": "abc"}, 422),
    ({"shape": "heart"}, 422),
    ({"shape": "lasso"}, 422),
    ({"shape": "box", "size": [1, 1, -1], "center": [0, 0, 0]}, 422),
    ({"tool": "burn"}, 422),
    ({"hidden": [-1]}, 422),
    ({"hidden": 3}, 422),
    ({"hidden": [1] * 65_536}, 422),
    ({"id": "not a uuid"}, 422),
    ({"surprise": 1}, 422),
]


@pytest.mark.parametrize(("change", "status"), BAD_STROKES, ids=lambda v: str(v)[:40])
def test_bad_strokes_change_nothing(api: httpx.Client, change: dict[str, Any], status: int) -> None:
    label = new_label(api)
    before = api.get("/sequences/wall").json()["revision"]
    response = api.post("/sequences/wall/frames/0/strokes", json=stroke(label) | change)
    assert problem(response, status)
    assert api.get("/sequences/wall").json()["revision"] == before


@pytest.mark.parametrize(
    ("content", "status"),
    [
        (b"{", 400),
        (b"\xff\xfe", 400),
        (b'{"label": NaN}', 422),
        (b"[]", 422),
        (b"[" * 100_000, 400),
        (b" " * 300_000, 413),
    ],
    ids=["open", "binary", "nan", "list", "deep", "large"],
)
def test_json_that_is_none_or_too_large_is_refused(
    api: httpx.Client, content: bytes, status: int
) -> None:
    headers = {"Content-Type": "application/json"}
    url = "/sequences/wall/frames/0/strokes"
    problem(api.post(url, content=content, headers=headers), status)
    # The same without a stated length.
    problem(api.post(url, content=iter([content]), headers=headers), status)


@pytest.mark.parametrize(
    ("method", "path", "status"),
    [
        ("GET", "/sequences/nothing", 404),
        ("GET", "/sequences/..%2f..", 404),
        ("GET", "/sequences/UPPER", 422),
        ("GET", "/sequences/wall/frames/4/points", 404),
        ("GET", "/sequences/wall/frames/-1/points", 422),
        ("GET", "/sequences/wall/frames/x/points", 422),
        ("GET", "/sequences/wall/frames/99999999999999999999/points", 422),
        ("GET", "/sequences/wall/frames/0/annotation?layer=colour", 422),
        ("GET", "/sequences/wall/frames/0/chunks/999", 404),
        ("GET", "/sequences/wall/labels/60000", 404),
        ("GET", "/sequences/wall/labels/0", 422),
        ("GET", "/sequences/wall/export?format=fax", 422),
        ("GET", "/sequences/wall/export", 422),
        ("GET", "/sequences/wall/edits?limit=0", 422),
        ("GET", f"/jobs/{uuid.UUID(int=0)}", 404),
        ("DELETE", f"/jobs/{uuid.UUID(int=0)}", 404),
        ("GET", "/nothing", 404),
        ("PUT", "/sequences/wall", 405),
        ("GET", "/sequences/wall/undo", 405),
    ],
)
def test_addresses_of_nothing_are_refused(
    api: httpx.Client, method: str, path: str, status: int
) -> None:
    problem(api.request(method, path), status)


def test_chunks_are_immutable_and_complete(api: httpx.Client) -> None:
    table = api.get("/sequences/wall/frames/0/chunks").json()
    assert sum(chunk["count"] for chunk in table["chunks"]) == table["points"] == 3000
    for chunk in table["chunks"]:
        url = f"/sequences/wall/frames/0/chunks/{chunk['index']}"
        response = api.get(url, params={"identity": table["identity"]})
        assert len(response.content) == chunk["nbytes"]
        assert "immutable" in response.headers["cache-control"]
        unnamed = api.get(url)
        assert unnamed.content == response.content
        assert unnamed.headers["cache-control"] == "private, no-cache"
        tag = response.headers["etag"]
        assert not tag.startswith("W/")
        again = api.get(response.request.url.path[7:], headers={"If-None-Match": tag})
        assert again.status_code == 304


def test_docs_are_self_contained(anyone: httpx.Client) -> None:
    page = anyone.get("/api/v1/docs")
    assert page.status_code == 200
    for name in ("docs.js", "docs.css"):
        text = anyone.get(f"/api/v1/docs/{name}").text
        assert "http://" not in text
        assert "https://" not in text
    assert "https://" not in page.text


def test_metrics_count_requests_and_memory(api: httpx.Client) -> None:
    text = api.get("/metrics").text
    assert "pointbrush_requests_total" in text
    assert "process_resident_memory_bytes" in text


def test_large_headers_and_odd_methods(anyone: httpx.Client) -> None:
    response = anyone.request("BREW", "/api/v1/sequences")
    assert response.status_code == 405
    assert anyone.options("/api/v1/sequences").status_code == 405


def test_the_list_tells_what_a_start_page_shows(api: httpx.Client) -> None:
    label = new_label(api)
    api.post("/sequences/wall/frames/1/strokes", json=stroke(label)).raise_for_status()
    listed = {each["id"]: each for each in api.get("/sequences").json()}["wall"]
    frames = range(api.get("/sequences/wall").json()["frames"])
    urls = [f"/sequences/wall/frames/{frame}/annotation" for frame in frames]
    assert listed["labelled"] == sum(load(api.get(url)).any() for url in urls) >= 1
    assert listed["labels"] >= listed["labels_used"] >= 1
    new_label(api, "nobody painted this")
    (later,) = (each for each in api.get("/sequences").json() if each["id"] == "wall")
    assert (later["labels"], later["labels_used"]) == (listed["labels"] + 1, listed["labels_used"])
    assert listed["created"].endswith(("Z", "+00:00"))
    assert listed["created"] < listed["changed"] < later["changed"]
    picture = api.get("/sequences/wall/frames/0/thumbnail")
    assert picture.headers["content-type"] == "image/jpeg"
    assert picture.content[:3] == b"\xff\xd8\xff"
    assert api.get("/sequences/wall/frames/99/thumbnail").status_code == 404


def test_what_a_call_has_not_is_refused_in_words(api: httpx.Client) -> None:
    said = problem(api.get("/sequences/wall/edits", params={"befor": 3}), 422)
    assert said == "query: expected only before, limit, got 'befor'"
    said = problem(api.get("/sequences/wall/labels", params={"limit": 3}), 422)
    assert said == "query: expected no parameters, got 'limit'"
    assert "/api/v1/nowhere" in problem(api.get("/nowhere"), 404)
    assert "expected GET, POST for /api/v1/sequences, got PUT" in problem(
        api.put("/sequences"), 405
    )
    headers = {"content-type": "application/json"}
    said = problem(api.post("/sequences/wall/labels", content=b"{bad", headers=headers), 400)
    assert "body: JSON decode error at character 1" in said
