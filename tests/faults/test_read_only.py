"""A workspace that may not be written: it is looked at, exported and checked, never changed."""

from __future__ import annotations

import io
import os
import shutil
import subprocess
import sys
import tempfile
import uuid
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import httpx
import msgpack
import numpy as np
import psycopg
import pytest

from pointbrush.errors import ReadOnlyError
from pointbrush.values.runs import TrackingRequest
from pointbrush.workspace import Workspace
from tests import forked
from tests.faults.clients import SEQUENCE, SocketTalk
from tests.faults.server import TOKEN, running
from tests.serving import add_sequence, settings_in
from tests.waiting import PATIENCE

STROKE = {"label": 1, "radius": 0.3, "samples": [{"origin": [0.0, 0.0, 3.0]}]}
NOBODY = ("setpriv", "--reuid=65534", "--regid=65534", "--clear-groups")


@dataclass
class ReadOnly:
    """A workspace with one label and 1,000 painted points; ``prefix`` runs a command in it."""

    workspace: Path
    prefix: tuple[str, ...]

    def run(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        arguments += ("--workspace", str(self.workspace))
        if not self.prefix:
            return forked.run(*arguments, cwd=Path("/"))
        command = [*self.prefix, sys.executable, "-m", "pointbrush.cli", *arguments]
        return subprocess.run(command, capture_output=True, text=True, cwd="/")

    def require_refusal(self, *arguments: str) -> None:
        refused = self.run(*arguments)
        assert refused.returncode == 1, refused.stdout
        assert "read-only" in refused.stderr.splitlines()[-1], refused.stderr
        assert "Traceback" not in refused.stderr


def painted(folder: Path) -> Path:
    """A new workspace that was closed in order."""
    settings = settings_in(folder)
    add_sequence(settings, SEQUENCE, frames=2, points=20_000)
    workspace = Workspace(settings)
    workspace.labels.create_label(SEQUENCE, "ann", name="pin")
    label = np.zeros(20_000, np.uint16)
    label[:1000] = 1
    workspace.annotations.put(SEQUENCE, 0, label, author="ann")
    workspace.close()
    return settings.workspace


@pytest.fixture(params=["mounted", "forbidden"])
def read_only(request: pytest.FixtureRequest) -> Iterator[ReadOnly]:
    """On a file system that is mounted for reading only, or for a user who may not write."""
    folder = Path(tempfile.mkdtemp(dir="/tmp"))  # pytest's own folder is closed to other users
    folder.chmod(0o755)
    workspace = painted(folder)
    if request.param == "mounted":
        try:
            mount("--bind", str(workspace), str(workspace))
            mount("-o", "remount,ro,bind", str(workspace))
            yield ReadOnly(workspace, ())
        finally:
            subprocess.run(["umount", "-l", str(workspace)], capture_output=True)
            shutil.rmtree(folder)
        return
    for path in (workspace, *workspace.rglob("*")):
        path.chmod(0o755 if path.is_dir() else 0o644)
    try:
        found = [*NOBODY, sys.executable, "-c", "import pointbrush"]
        if os.geteuid() or shutil.which("setpriv") is None or subprocess.run(found).returncode:
            pytest.skip("no other user can run pointbrush here")
        yield ReadOnly(workspace, NOBODY)
    finally:
        shutil.rmtree(folder)


def mount(*arguments: str) -> None:
    if shutil.which("mount") is None or subprocess.run(["mount", *arguments]).returncode:
        pytest.skip("this user may not mount a folder read-only")


def everything_in(folder: Path) -> dict[str, tuple[int, int]]:
    return {
        str(path.relative_to(folder)): (path.stat().st_size, path.stat().st_mtime_ns)
        for path in folder.rglob("*")
    }


def require_refused(response: httpx.Response) -> None:
    assert response.status_code == 403, response.text
    assert response.json()["title"] == "Read-only"
    assert "read-only" in response.json()["detail"]


def test_it_is_served_for_viewing(read_only: ReadOnly) -> None:
    before = everything_in(read_only.workspace)
    base = f"/sequences/{SEQUENCE}"
    with running(read_only.workspace, prefix=read_only.prefix) as server, server.api() as api:
        assert api.get("/sequences").json()[0]["revision"] == 2
        labels = np.load(io.BytesIO(api.get(f"{base}/frames/0/annotation").content))
        assert np.count_nonzero(labels == 1) == 1000
        assert len(np.load(io.BytesIO(api.get(f"{base}/frames/1/points").content))) == 20_010
        exported = api.get(f"{base}/export?format=ply").raise_for_status()
        assert "000001.ply" in zipfile.ZipFile(io.BytesIO(exported.content)).namelist()
        assert httpx.get(f"{server.url}/readyz").status_code == 200
        origin = {"Origin": server.url}
        signed = httpx.post(f"{server.url}/api/v1/session", json={"token": TOKEN}, headers=origin)
        assert signed.status_code == 200, signed.text

        body = {**STROKE, "id": str(uuid.uuid4())}
        require_refused(api.post(f"{base}/frames/0/strokes", json=body))
        require_refused(api.post(f"{base}/labels", json={"name": "bottle"}))
        require_refused(api.patch(base, json={"name": "another"}))
        require_refused(api.post(f"{base}/tracking", json={"start": 0, "stop": 1}))
        require_refused(api.post("/sequences", files={"files": ("a.xyz", b"1 2 3\n")}))
        require_refused(api.delete(base))
        with SocketTalk(server.url, TOKEN, "ann") as ann:
            seen = set()
            while seen != {0, 1}:
                message = msgpack.unpackb(ann.socket.recv(timeout=PATIENCE))
                if message["type"] == "frame":
                    seen.add(message["frame"])
                    ann.send(type="credit", frames=1)
            edit = {"kind": "stroke", "id": body["id"], "frame": 0, "stroke": dict(STROKE)}
            with pytest.raises(Exception, match="read-only"):
                ann.do(edit)
        assert api.get(f"{base}/labels").json()[0]["name"] == "pin"
        assert server.stop() == 0
    assert "read-only" in server.stderr
    assert "Traceback" not in server.stderr
    assert everything_in(read_only.workspace) == before
    copies = f"pointbrush-readonly-{server.process.pid}-*"
    assert not list(Path(tempfile.gettempdir()).glob(copies))
    read_only.require_refusal("token", "add", "ann")
    assert everything_in(read_only.workspace) == before


@pytest.mark.parametrize("read_only", ["mounted"], indirect=True)
def test_the_commands_look_at_it_and_change_nothing(read_only: ReadOnly) -> None:
    before = everything_in(read_only.workspace)
    listed = read_only.run("info")
    assert (listed.returncode, SEQUENCE in listed.stdout) == (0, True), listed.stderr
    told = read_only.run("info", SEQUENCE)
    assert "label 1" in told.stdout
    checked = read_only.run("check")
    assert (checked.returncode, "sound" in checked.stdout) == (0, True), checked.stdout
    out = Path(tempfile.mkdtemp(dir="/tmp"))
    out.chmod(0o777)
    try:
        exported = read_only.run("export", SEQUENCE, "--format", "ply", "--out", str(out / "x"))
        assert exported.returncode == 0, exported.stderr
        assert (out / "x" / "000001.ply").stat().st_size > 0
        source = out / "a.xyz"
        source.write_text("1 2 3\n")
        source.chmod(0o644)
        read_only.require_refusal("import", str(source))
        read_only.require_refusal("serve", "--tls")
    finally:
        shutil.rmtree(out)
    assert everything_in(read_only.workspace) == before


def test_a_database_that_may_only_be_read(tmp_path: Path, labels_url: str) -> None:
    settings = settings_in(tmp_path, database=labels_url)
    add_sequence(settings, SEQUENCE, frames=2, points=20_000)
    workspace = Workspace(settings)
    workspace.labels.create_label(SEQUENCE, "ann", name="pin")
    workspace.close()
    add_sequence(settings, "late", frames=1, points=1_000)  # which the database does not know
    name = labels_url.rpartition("/")[2]
    with psycopg.connect(labels_url, autocommit=True) as connection:
        connection.execute(f"ALTER DATABASE {name} SET default_transaction_read_only = on")
    workspace = Workspace(settings)
    try:
        assert "read-only" in workspace.read_only
        assert [label.name for label in workspace.labels.palette(SEQUENCE)] == ["pin"]
        assert workspace.listing.problems(SEQUENCE) == []
        workspace.export(SEQUENCE, "ply", tmp_path / "out")
        with pytest.raises(ReadOnlyError, match="read-only"):
            workspace.labels.create_label(SEQUENCE, "ann", name="bottle")
        with pytest.raises(ReadOnlyError, match="read-only"):
            workspace.strokes.apply(SEQUENCE, 0, STROKE, "ann")
        with pytest.raises(ReadOnlyError, match="read-only"):
            workspace.tracking.start(SEQUENCE, TrackingRequest(start=0, stop=1), "ann")
    finally:
        workspace.close()
