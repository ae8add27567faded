"""The process: what it prints, where it refuses to listen, how it ends, HTTPS."""

from __future__ import annotations

import multiprocessing
import os
import signal
import ssl
import stat
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import httpx
import pytest
from cryptography import x509
from waiting import PATIENCE, eventually

from pointbrush.errors import BadInputError
from pointbrush.settings import Settings
from pointbrush.web.security import tls
from pointbrush.web.security.clients import is_loopback
from pointbrush.web.server import expect_tracking, listen, page_url, require_safe
from pointbrush.workspace import Workspace
from tests.forked import ForkedCommand, first_line, run
from tests.serving import add_sequence, settings_in


@contextmanager
def started(folder: Path, *arguments: str) -> Iterator[str]:
    """The URL that a ``pointbrush serve`` prints; it has ended in order afterwards."""
    stdout, stderr = folder / "stdout", folder / "stderr"
    command = ("serve", "--port", "0", "--workspace", str(folder / "w"), *arguments)
    process = ForkedCommand(command, os.environ, stdout, stderr)
    line = first_line(process, stdout)
    assert line.startswith("pointbrush ready at http"), stderr.read_text()
    try:
        yield line.split()[-1]
    finally:
        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE) in (0, -signal.SIGTERM)
    assert "Traceback" not in stdout.read_text() + stderr.read_text()


def test_it_says_where_it_is_and_ends_in_order(tmp_path: Path) -> None:
    with started(tmp_path) as url:
        assert url.startswith("http://127.0.0.1:")
        with httpx.Client() as client:
            response = client.get(url)
            assert response.status_code == 303
            address = url.partition("/?")[0]
            assert client.get(f"{address}/api/v1/me").json()["role"] == "admin"
            # A headset is told how to come to HTTPS, and where.
            page = client.get(f"{address}/trust").text
            assert address.replace("http://", "https://") + "/" in page
            assert "--tls" in page
            code = client.get(f"{address}/trust/address.svg")
            assert code.headers["content-type"] == "image/svg+xml"
            assert b"<svg" in code.content
            assert client.get(f"{address}/trust/authority.crt").status_code == 404


def test_who_paints_finds_a_worker_ready(tmp_path: Path) -> None:
    settings = settings_in(tmp_path)
    add_sequence(settings, "walls", frames=1, points=500)
    with closing(Workspace(settings)) as workspace:
        expect_tracking(workspace, after=0.0)
        before = len(multiprocessing.active_children())
        workspace.labels.create_label("walls", "somebody", name="wall", color="#ff0000")
        eventually(lambda: len(multiprocessing.active_children()) > before)


def test_a_taken_port_is_one_clear_line(tmp_path: Path) -> None:
    with listen("127.0.0.1", 0) as taken:
        taken.listen()
        port = taken.getsockname()[1]
        done = run("serve", "--workspace", str(tmp_path), "--port", str(port))
    assert done.returncode == 1
    assert len(done.stderr.strip().splitlines()) == 1
    assert str(port) in done.stderr


def test_plain_http_stays_on_this_machine() -> None:
    require_safe(Settings(host="127.0.0.1"), None)
    require_safe(Settings(host="0.0.0.0", insecure=True), None)
    require_safe(Settings(host="0.0.0.0"), tls.Certificate(Path("a"), Path("b")))
    for host in ("0.0.0.0", "::", "192.168.1.2", "example.org"):
        assert not is_loopback(host)
        with pytest.raises(BadInputError, match="tls"):
            require_safe(Settings(host=host), None)


@pytest.mark.parametrize(
    ("host", "url"),
    [("127.0.0.1", "http://127.0.0.1:8/?token=t"), ("::1", "http://[::1]:8/?token=t")],
)
def test_the_page_is_addressed_with_host_port_and_token(host: str, url: str) -> None:
    assert page_url(Settings(host=host), 8, "t", secure=False) == url


def test_https_with_an_authority_that_is_kept(tmp_path: Path) -> None:
    workspace = tmp_path / "w"
    with started(tmp_path, "--tls") as url:
        address = url.partition("/?")[0]
        assert address.startswith("https://127.0.0.1:")
        folder = workspace / "tls"
        context = ssl.create_default_context(cafile=str(folder / "authority.pem"))
        with httpx.Client(verify=context) as client:
            response = client.get(url)
            assert "secure" in response.headers["set-cookie"].lower()
            page = client.get(f"{address}/trust").text
            downloaded = client.get(f"{address}/trust/authority.crt").content
            assert client.get(f"{address}/api/v1/me").status_code == 200
    assert downloaded == (folder / "authority.pem").read_bytes()
    assert b"PRIVATE" not in downloaded
    assert x509.load_pem_x509_certificate(downloaded).subject
    assert "{fingerprint}" not in page
    for device in ("Quest", "Pico", "Galaxy XR", "Vision Pro", "Vive"):
        assert device in page
    for name in ("authority.key", "server.key"):
        assert stat.S_IMODE((folder / name).stat().st_mode) == 0o600
    before = (folder / "authority.pem").read_bytes(), (folder / "server.pem").read_bytes()
    settings = Settings(workspace=workspace, tls=True)
    tls.certificate(settings)
    assert before == ((folder / "authority.pem").read_bytes(), (folder / "server.pem").read_bytes())
    # A new name needs a new certificate, under the same authority.
    tls.certificate(Settings(workspace=workspace, tls=True, allowed_hosts="studio.lan"))
    assert (folder / "authority.pem").read_bytes() == before[0]
    assert (folder / "server.pem").read_bytes() != before[1]


def test_given_certificates_must_be_there(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match="keyfile"):
        tls.certificate(Settings(certfile="a.pem"))
    with pytest.raises(BadInputError, match="exist"):
        tls.certificate(Settings(certfile=str(tmp_path / "a"), keyfile=str(tmp_path / "b")))
    assert tls.certificate(Settings()) is None


@pytest.mark.skipif(sys.platform != "linux", reason="glibc's settings")
def test_large_blocks_are_given_back_to_the_system() -> None:
    code = """
import re, pathlib, numpy as np, threading
from pointbrush.web.server import give_large_blocks_back
give_large_blocks_back()
def resident():
    return int(re.search(r"RssAnon:\\s+(\\d+)", pathlib.Path("/proc/self/status").read_text())[1])
def work():
    kept = []
    for i in range(40):
        frame = np.ones(6_000_000 + 1000 * i, np.uint8)
        kept.append(np.ones(1000))
        del frame
before = resident()
threads = [threading.Thread(target=work) for _ in range(8)]
[t.start() for t in threads]; [t.join() for t in threads]
print(resident() - before)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert int(done.stdout) < 6_000
