"""The published files: built, installed where nothing else is, and used for the main job."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import tarfile
import venv
import zipfile
from pathlib import Path

import httpx
import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
NODE_MODULES = ROOT / "webxr_client" / "node_modules"
TOKEN = "token-of-the-wheel-test"
MINUTES = 60


def build(source: Path, kind: str, target: Path) -> Path:
    """Build the sdist or the wheel of a source tree as a release does."""
    command = [sys.executable, "-m", "build", f"--{kind}", "--outdir", target, source]
    subprocess.run(command, check=True, capture_output=True, timeout=4 * MINUTES)
    (made,) = target.glob("*.whl" if kind == "wheel" else "*.tar.gz")
    return made


def install(wheel: Path, folder: Path) -> Path:
    """Install a wheel into a fresh environment; returns the folder of its programs."""
    venv.create(folder, with_pip=True)
    programs = folder / "bin"
    # Nothing is compiled ahead: most of it is never imported here.
    command = [programs / "python", "-m", "pip", "install", "--quiet", "--no-compile", "-c"]
    subprocess.run([*command, ROOT / "constraints.txt", wheel], check=True, timeout=6 * MINUTES)
    return programs


@pytest.mark.timeout(15 * MINUTES)
def test_what_is_published_does_the_main_job_alone(tmp_path: Path) -> None:
    with tarfile.open(build(ROOT, "sdist", tmp_path / "dist")) as archive:
        archive.extractall(tmp_path / "source", filter="data")
    (source,) = (tmp_path / "source").iterdir()
    assert not (source / "data").exists(), "recordings are not published"
    if NODE_MODULES.is_dir():  # saves fetching them again
        (source / "webxr_client" / "node_modules").symlink_to(NODE_MODULES)
    wheel = build(source, "wheel", tmp_path / "dist")
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    assert {"pointbrush/py.typed", "pointbrush/web/page/index.html"} <= set(names)
    assert not [name for name in names if name.startswith(("tests/", "webxr_client/"))]

    programs = install(wheel, tmp_path / "fresh")
    environment = {
        "PATH": os.pathsep.join([str(programs), "/usr/bin", "/bin"]),
        "HOME": str(tmp_path),
        "POINTBRUSH_TOKEN": TOKEN,
        "POINTBRUSH_WORKSPACE": str(tmp_path / "workspace"),
    }

    def run(*arguments: str) -> None:
        command = [programs / "pointbrush", *arguments]
        subprocess.run(command, check=True, env=environment, cwd=tmp_path, timeout=4 * MINUTES)

    demo = [programs / "pointbrush", "demo", "--sample-frames", "2", "--port", "0"]
    with subprocess.Popen(
        demo, env=environment, cwd=tmp_path, stdout=subprocess.PIPE, text=True
    ) as server:
        assert server.stdout is not None
        url = next(line.split()[-1] for line in server.stdout if "ready at" in line).split("/?")[0]
        try:
            sequence, changed = paint(url)
        finally:
            server.send_signal(signal.SIGTERM)
            server.wait(MINUTES)
    run("track", sequence, "--from", "0", "--to", "1", "--method", "icp")
    run("export", sequence, "--format", "npz", "--out", str(tmp_path / "out"))
    first, second = (np.load(path)["label"] for path in sorted((tmp_path / "out").rglob("*.npz")))
    assert np.count_nonzero(first) == changed
    assert np.count_nonzero(second) > changed // 2


def paint(url: str) -> tuple[str, int]:
    """Open the page, then paint a ball of the first frame; returns the recording and the count."""
    with httpx.Client(base_url=url, headers={"Authorization": f"Bearer {TOKEN}"}) as api:
        assert '<script type="module"' in api.get("/").raise_for_status().text
        (sequence,) = api.get("/api/v1/sequences").raise_for_status().json()
        base = f"/api/v1/sequences/{sequence['id']}"
        label = api.post(f"{base}/labels", json={"name": "pin"}).raise_for_status().json()
        points = np.load(io.BytesIO(api.get(f"{base}/frames/0/points").raise_for_status().content))
        stroke = {
            "label": label["id"],
            "shape": "sphere",
            "radius": 0.1,
            "samples": [{"origin": points["xyz"][len(points) // 2].tolist()}],
        }
        answer = api.post(f"{base}/frames/0/strokes", json=stroke).raise_for_status().json()
        return str(sequence["id"]), int(answer["changed"])
