"""Imports, tracking runs and exports by REST, over a real server."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from plyfile import PlyData, PlyElement

from tests.serving import Served, surface
from tests.waiting import eventually
from tests.web.calls import new_label, stroke, wait
from tests.web.test_auth import problem


def write_ply(path: Path, seed: int, count: int = 500) -> None:
    frame = surface(count, seed)
    assert frame.rgb is not None
    rows = np.empty(
        count,
        [("x", "f4"), ("y", "f4"), ("z", "f4"), ("red", "u1"), ("green", "u1"), ("blue", "u1")],
    )
    for column, name in enumerate("xyz"):
        rows[name] = frame.xyz[:, column]
    for column, name in enumerate(("red", "green", "blue")):
        rows[name] = frame.rgb[:, column]
    PlyData([PlyElement.describe(rows, "vertex")]).write(str(path))


def imported(api: httpx.Client, response: httpx.Response) -> dict[str, Any]:
    """The manifest of what an import has brought in."""
    assert response.status_code == 202, response.text
    job = wait(api, response.json())
    assert job["state"] == "done", job
    manifest: dict[str, Any] = api.get(f"/sequences/{job['result']['sequence']}").json()
    return manifest


def test_a_folder_within_the_roots_is_imported_by_its_path(
    served: Served, api: httpx.Client
) -> None:
    folder = served.workspace.settings.roots[0] / "take one"
    folder.mkdir()
    for number in range(3):
        write_ply(folder / f"{number}.ply", number)
    response = api.post("/sequences", json={"path": str(folder), "name": "take", "fps": 10.0})
    manifest = imported(api, response)
    assert (manifest["name"], manifest["fps"], manifest["points"]) == ("take", 10.0, [500] * 3)
    assert api.delete(f"/sequences/{manifest['id']}").status_code == 204
    problem(api.get(f"/sequences/{manifest['id']}"), 404)


def test_uploaded_files_are_imported(served: Served, api: httpx.Client, tmp_path: Path) -> None:
    write_ply(tmp_path / "a.ply", 1)
    write_ply(tmp_path / "b.ply", 2)
    files = [("files", (name, (tmp_path / name).read_bytes())) for name in ("a.ply", "b.ply")]
    response = api.post("/sequences", files=files, data={"name": "uploaded", "fps": "15"})
    manifest = imported(api, response)
    assert (manifest["frames"], manifest["fps"]) == (2, 15.0)
    uploads = served.workspace.settings.workspace / "uploads"
    eventually(lambda: not any(uploads.iterdir()))
    api.delete(f"/sequences/{manifest['id']}")


def test_import_of_a_broken_file_fails_and_leaves_nothing(
    api: httpx.Client, tmp_path: Path
) -> None:
    write_ply(tmp_path / "a.ply", 1)
    body = (tmp_path / "a.ply").read_bytes()[:-100]
    response = api.post("/sequences", files=[("files", ("broken.ply", body))])
    job = wait(api, response.json())
    assert job["state"] == "failed"
    assert job["error"]
    assert [entry["id"] for entry in api.get("/sequences").json()] == ["wall"]


@pytest.mark.parametrize("path", ["/etc", "/etc/passwd", "inbox/../../..", "~"])
def test_import_outside_the_roots(api: httpx.Client, path: str) -> None:
    problem(api.post("/sequences", json={"path": path}), 403)


def test_import_through_a_symlink_out_of_the_roots(served: Served, api: httpx.Client) -> None:
    link = served.workspace.settings.roots[0] / "link"
    link.symlink_to("/etc")
    problem(api.post("/sequences", json={"path": str(link)}), 403)
    link.unlink()


@pytest.mark.parametrize("name", ["../x.ply", "..", ".hidden", "", "a\x00b"])
def test_no_name_of_an_upload_leads_out_of_its_folder(
    api: httpx.Client, served: Served, name: str
) -> None:
    response = api.post("/sequences", files=[("files", (name, b"data"))])
    assert response.status_code in (202, 400, 422)
    if response.status_code == 202:
        wait(api, response.json())
    outside = served.workspace.settings.workspace
    assert not list(outside.glob("*.ply"))


def test_upload_without_files(api: httpx.Client) -> None:
    problem(api.post("/sequences", files=[("other", ("a.ply", b"x"))]), 422)
    headers = {"Content-Type": "multipart/form-data; boundary=x"}
    problem(api.post("/sequences", content=b"--y", headers=headers), 400)
    headers = {"Content-Type": "text/plain"}
    problem(api.post("/sequences", content=b"hi", headers=headers), 415)


def test_a_tracking_run_is_started_and_its_tracks_are_told(api: httpx.Client) -> None:
    label = new_label(api, "moving")
    api.post("/sequences/wall/frames/0/strokes", json=stroke(label, radius=0.5))
    body = {"labels": [label], "start": 0, "stop": 2, "method": "icp"}
    response = api.post("/sequences/wall/tracking", json=body)
    assert response.status_code == 202, response.text
    job = wait(api, response.json())
    assert job["state"] == "done", job
    tracks = [
        track for track in api.get("/sequences/wall/tracks").json() if track["label"] == label
    ]
    assert {track["frame"] for track in tracks} >= {1, 2}
    assert all(len(track["pose"]) == 16 for track in tracks)
    assert all(0 <= track["confidence"] <= 1 for track in tracks)


def test_tracking_up_to_the_next_painted_frame(api: httpx.Client) -> None:
    label = new_label(api, "corrected")
    for frame in (0, 1):
        api.post(f"/sequences/wall/frames/{frame}/strokes", json=stroke(label, radius=0.5))
    body = {"labels": [label], "start": 0, "stop": 3, "method": "icp"}
    for until, frames in ((True, {0, 1}), (False, {0, 1, 2, 3})):
        request = {**body, "until_painted": until, "continue_lost": True}
        assert wait(api, api.post("/sequences/wall/tracking", json=request).json())["result"]
        tracks = api.get("/sequences/wall/tracks").json()
        assert {track["frame"] for track in tracks if track["label"] == label} == frames


@pytest.mark.parametrize(
    ("change", "status"),
    [
        ({"stop": 99}, 404),
        ({"stop": 0}, 422),
        ({"labels": [61_000]}, 404),
        ({"labels": []}, 422),
        ({"method": "guess"}, 422),
        ({"overwrite": "maybe"}, 422),
    ],
    ids=str,
)
def test_a_tracking_run_that_cannot_be_is_refused(
    api: httpx.Client, change: dict[str, Any], status: int
) -> None:
    label = new_label(api, "tracked")
    api.post("/sequences/wall/frames/0/strokes", json=stroke(label, radius=0.5))
    body = {"labels": [label], "start": 0, "stop": 2, "method": "icp"} | change
    problem(api.post("/sequences/wall/tracking", json=body), status)


def test_export_streams_a_zip(api: httpx.Client) -> None:
    import zipfile

    response = api.get("/sequences/wall/export?format=npz&frames=0:2")
    assert response.status_code == 200
    assert response.headers["content-type"] == "application/zip"
    names = zipfile.ZipFile(io.BytesIO(response.content)).namelist()
    assert len([name for name in names if name.endswith(".npz")]) == 2
    problem(api.get("/sequences/wall/export?format=npz&frames=3:9"), 422)
