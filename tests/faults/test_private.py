"""Other users of the machine read nothing, and clients are told nothing of its folders."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import httpx
import numpy as np
import pytest
from waiting import eventually

from tests.faults.clients import ENDED
from tests.faults.server import TOKEN, ServerProcess, running
from tests.forked import run
from tests.serving import add_sequence, settings_in, surface
from tests.web.test_ending import children

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
SECRET = "open-sesame"


def scan(points: int = 5_000) -> bytes:
    file = io.BytesIO()
    np.save(file, surface(points, 0).xyz)
    return file.getvalue()


def ended(api: httpx.Client, job: dict[str, str]) -> dict[str, str]:
    def now() -> dict[str, str] | None:
        found: dict[str, str] = api.get(f"/jobs/{job['id']}").json()
        return found if found["state"] in ENDED else None

    return eventually(now)


def upload(api: httpx.Client, name: str, data: bytes) -> dict[str, str]:
    answer = api.post("/sequences", files={"files": (name, data)})
    job: dict[str, str] = answer.raise_for_status().json()
    return job


def readable_by_others(folder: Path) -> list[str]:
    paths = [folder]
    for place, folders, files in os.walk(folder):
        paths += [Path(place, name) for name in (*folders, *files)]
    found = []
    for path in paths:
        # The server removes an upload once it is imported.
        with suppress(FileNotFoundError):
            if not path.is_symlink() and path.lstat().st_mode & 0o077:
                found.append(str(path))
    return found


def test_files_are_their_owners_alone(tmp_path: Path) -> None:
    before = os.umask(0o022)
    try:
        settings = settings_in(tmp_path)
        add_sequence(settings, "wall", frames=1, points=2_000)  # as an earlier version left it
        assert readable_by_others(settings.workspace)
        with running(settings.workspace, POINTBRUSH_TLS="1") as server:
            headers = {"Authorization": f"Bearer {TOKEN}"}
            url = f"{server.url}/api/v1"
            with httpx.Client(base_url=url, headers=headers, verify=False) as api:
                api.post("/sequences/wall/labels", json={"name": "pin"}).raise_for_status()
                job = ended(api, upload(api, "scan.npy", scan()))
                assert job["state"] == "done", job
            assert readable_by_others(settings.workspace) == []
            port = server.url.rsplit(":", 1)[1]
            check = [sys.executable, "-m", "pointbrush.web.health"]
            environment = os.environ | {"POINTBRUSH_PORT": port}
            assert subprocess.run(check, env=environment).returncode == 0
        assert subprocess.run(check, env=environment).returncode == 1
        copy = run("backup", str(tmp_path / "copy"), "--workspace", str(settings.workspace))
        assert copy.returncode == 0
        assert readable_by_others(tmp_path / "copy") == []
    finally:
        os.umask(before)


def command_line(pid: int) -> str:
    return Path(f"/proc/{pid}/cmdline").read_bytes().decode(errors="replace")


def test_a_database_password_is_in_no_process_list_and_no_text(
    tmp_path: Path,
    labels_url: str,
) -> None:
    secret_url = labels_url.replace("postgres@", f"postgres:{SECRET}@")
    arguments = ["serve", "--port", "0", "--database", secret_url, "--workers", "1"]
    command = [sys.executable, "-m", "pointbrush.cli", *arguments]
    environment = os.environ | {
        "POINTBRUSH_WORKSPACE": str(tmp_path / "workspace"),
        "POINTBRUSH_TOKEN": TOKEN,
    }
    with subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as server:
        assert server.stdout is not None
        assert server.stderr is not None
        try:
            url = next(line for line in server.stdout if "ready at" in line).split()[-1]
            headers = {"Authorization": f"Bearer {TOKEN}"}
            with httpx.Client(base_url=f"{url}/api/v1", headers=headers) as api:
                assert ended(api, upload(api, "scan.npy", scan()))["state"] == "done"
            processes = {server.pid} | children(server.pid)
            assert len(processes) > 1
            assert not [pid for pid in processes if SECRET in command_line(pid)]
        finally:
            server.terminate()
        said = server.stderr.read()
    assert "could be read by other users" in said
    assert SECRET not in said


def test_a_password_comes_from_a_file(tmp_path: Path, labels_url: str) -> None:
    (tmp_path / "password").write_text(f"{SECRET}/@\n")
    options = {
        "POINTBRUSH_DATABASE": labels_url,
        "POINTBRUSH_DATABASE_PASSWORD_FILE": str(tmp_path / "password"),
    }
    with running(tmp_path / "workspace", **options) as server, server.api() as api:
        assert api.get("/sequences").json() == []


@pytest.mark.parametrize("place", ["127.0.0.1:1/none", "127.0.0.1:x/none", "nowhere.invalid/x"])
def test_a_database_that_cannot_be_used_is_named_without_its_password(
    tmp_path: Path, place: str
) -> None:
    url = f"postgresql://ann:{SECRET}@{place}"
    environment = os.environ | {"POINTBRUSH_DATABASE": url}
    found = run("info", "--workspace", str(tmp_path), environment=environment)
    assert found.returncode == 1
    assert found.stderr.startswith("pointbrush: ")
    assert SECRET not in found.stderr + found.stdout
    assert "Traceback" not in found.stderr


def test_no_text_tells_where_the_server_keeps_things(tmp_path: Path) -> None:
    with running(tmp_path / "workspace") as server, server.api() as api:
        job = ended(api, upload(api, "scan.npy", b"no scan at all"))
        assert job["state"] == "failed"
        assert "scan.npy" in str(job["error"])
        assert str(tmp_path) not in api.get("/jobs").text


def open_files(server: ServerProcess) -> list[str]:
    found = []
    for entry in Path(f"/proc/{server.process.pid}/fd").iterdir():
        try:
            found.append(str(entry.readlink()))
        except OSError:
            continue
    return found


def test_a_large_upload_waits_on_the_workspaces_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("TMPDIR", raising=False)
    with running(tmp_path / "workspace") as server:

        def body() -> object:
            yield b'--x\r\nContent-Disposition: form-data; name="files"; filename="a.npy"\r\n\r\n'
            yield bytes(4 << 20)
            servers = str(tmp_path / "workspace" / "servers")
            eventually(lambda: any(path.startswith(servers) for path in open_files(server)))
            yield b"\r\n--x--\r\n"

        kind = {"Content-Type": "multipart/form-data; boundary=x"}
        with server.api() as api:
            answer = api.post("/sequences", content=body(), headers=kind)  # type: ignore[arg-type]
            assert answer.status_code == 202, answer.text
