"""Uploads of folders: their structure and name come with them, and lead nowhere else."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pytest
from PIL import Image

from tests.serving import Served, serving, settings_in
from tests.waiting import eventually

Files = dict[str, bytes]


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving(settings_in(tmp_path_factory.mktemp("uploads"))) as running:
        yield running


def npy(count: int) -> bytes:
    out = io.BytesIO()
    np.save(out, np.random.default_rng(0).uniform(-1, 1, (count, 3)).astype(np.float32))
    return out.getvalue()


def kitti() -> Files:
    """Two scans in the layout of SemanticKITTI."""
    rng = np.random.default_rng(0)
    files: Files = {"calib.txt": b"Tr: 1 0 0 0 0 1 0 0 0 0 1 0\n"}
    files["poses.txt"] = b"1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 0\n"
    for i in range(2):
        scan = rng.uniform(-20, 20, (300, 4)).astype(np.float32)
        files[f"velodyne/{i:06}.bin"] = scan.tobytes()
        files[f"labels/{i:06}.label"] = np.full(300, 10, np.uint32).tobytes()
    return files


def rgbd() -> Files:
    """Two depth and colour images in the layout of TUM RGB-D."""
    files: Files = {"camera.json": b'{"fx": 50, "fy": 50, "cx": 32, "cy": 24}'}
    lists: dict[str, list[str]] = {"rgb": [], "depth": []}
    for i in range(2):
        for kind, image in (
            ("rgb", np.full((48, 64, 3), 90, np.uint8)),
            ("depth", np.full((48, 64), 5000 + 100 * i, np.uint16)),
        ):
            out = io.BytesIO()
            Image.fromarray(image).save(out, "PNG")
            files[f"{kind}/{i}.png"] = out.getvalue()
            lists[kind].append(f"{i}.0 {kind}/{i}.png")
    return files | {f"{kind}.txt": "\n".join(lines).encode() for kind, lines in lists.items()}


def rig() -> Files:
    """The clouds of two sensors, in a folder each."""
    return {f"{side}/{i}.npy": npy(50 + i) for side in ("front", "rear") for i in range(2)}


def ended(api: httpx.Client, answer: httpx.Response) -> dict[str, Any]:
    assert answer.status_code == 202, answer.text

    def job() -> dict[str, Any] | None:
        found: dict[str, Any] = api.get(f"/jobs/{answer.json()['id']}").json()
        return found if found["state"] in ("done", "failed") else None

    return eventually(job)  # type: ignore[no-any-return]


def post(api: httpx.Client, files: Files) -> httpx.Response:
    return api.post("/sequences", files=[("files", item) for item in files.items()])


@pytest.mark.parametrize("layout", [kitti, rgbd, rig])
def test_a_folder_is_read_as_the_same_in_a_zip(api: httpx.Client, layout: Any) -> None:
    files = layout()
    name = f"drive {layout.__name__}"
    folder = ended(api, post(api, {f"{name}/{path}": data for path, data in files.items()}))
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for path, data in files.items():
            archive.writestr(f"{name}/{path}", data)
    zipped = ended(api, post(api, {f"{name}.zip": packed.getvalue()}))
    assert folder["state"] == zipped["state"], (folder, zipped)
    if layout is rig:
        assert "front" in folder["error"]
        assert "front" in zipped["error"]
        return
    one, other = (
        api.get(f"/sequences/{job['result']['sequence']}").json() for job in (folder, zipped)
    )
    for field in ("frames", "points", "fields", "fps", "bounds"):
        assert one[field] == other[field]
    assert one["name"] == name


@pytest.mark.parametrize(
    "name",
    [
        "../up.npy",
        "a/../../up.npy",
        "/root.npy",
        "a//b.npy",
        "a/./b.npy",
        ".hidden/a.npy",
        "a/.hidden.npy",
        "..\\up.npy",
        "a/con.npy",
        "a/b:c.npy",
        "/".join(["deep"] * 40) + "/a.npy",
        "long" * 100 + "/a.npy",
    ],
)
def test_hostile_names_are_refused_and_write_nothing(
    api: httpx.Client, served: Served, name: str
) -> None:
    def files() -> set[str]:
        root = served.workspace.settings.workspace.parent
        return {str(path) for path in root.rglob("*.npy") if "frames" not in path.parts}

    before = files()
    answer = post(api, {"fine/a.npy": npy(10), name: npy(10)})
    assert answer.status_code in (400, 422), answer.text
    assert answer.json()["detail"].startswith("files: expected")
    assert files() == before


def test_a_name_that_is_a_file_and_a_folder(api: httpx.Client) -> None:
    answer = post(api, {"a/b": npy(10), "a/b/c.npy": npy(10)})
    assert answer.status_code in (400, 422)
    assert "a file or a folder, got both" in answer.json()["detail"]
