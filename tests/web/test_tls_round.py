"""A whole round over HTTPS and WSS, as a browser makes it: upload, stream, stroke, undo."""

from __future__ import annotations

import io
import ssl
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from tests.streaming.acting import run
from tests.streaming.client import Viewer, viewer
from tests.waiting import eventually
from tests.web.test_server import started

POINTS = 60_000


def scan() -> bytes:
    """One frame as an .npz file."""
    stream = io.BytesIO()
    xyz = np.random.default_rng(3).uniform(-1, 1, (POINTS, 3)).astype(np.float32)
    np.savez(stream, xyz=xyz)
    return stream.getvalue()


def uploaded(client: httpx.Client, address: str) -> str:
    """Import a frame; the id of the recording."""
    job = client.post(
        f"{address}/api/v1/sequences",
        files=[("files", ("0000.npz", scan())), ("files", ("0001.npz", scan()))],
        headers={"Origin": address},
    )
    assert job.status_code == 202, job.text
    place = f"{address}/api/v1/jobs/{job.json()['id']}"

    def ended() -> dict[str, Any] | None:
        told: dict[str, Any] = client.get(place).json()
        return told if told["state"] in ("done", "failed") else None

    job_now = eventually(ended, 120, 0.1)
    assert job_now["state"] == "done", job_now
    return str(job_now["sequence"])


async def holds_all(client: Viewer, frame: int) -> None:
    while not (frame in client.frames and client.frames[frame].points == POINTS):
        await client.receive(30)


@contextmanager
def encrypted(folder: Path) -> Iterator[tuple[str, str, ssl.SSLContext]]:
    """A server with TLS: its URL with a token, its address, and a context that trusts it."""
    with started(folder, "--tls") as url:
        authority = folder / "w" / "tls" / "authority.pem"
        yield url, url.partition("/?")[0], ssl.create_default_context(cafile=str(authority))


def test_upload_stream_stroke_and_undo_over_tls(tmp_path: Path) -> None:
    with encrypted(tmp_path) as (url, address, trusted):
        with httpx.Client(verify=trusted, timeout=60) as client:
            cookies = client.get(url).headers.get_list("set-cookie")
            assert all("; Secure" in cookie for cookie in cookies)
            sequence = uploaded(client, address)
            label = client.post(
                f"{address}/api/v1/sequences/{sequence}/labels",
                json={"name": "box"},
                headers={"Origin": address},
            ).json()["id"]
            cookie = "; ".join(f"{name}={value}" for name, value in client.cookies.items())

        async def scenario() -> None:
            page = {"headers": {"Cookie": cookie}, "origin": address, "ssl": trusted}
            async with (
                viewer(address, "", **page) as painter,  # type: ignore[arg-type]
                viewer(address, "", **page) as watcher,  # type: ignore[arg-type]
            ):
                for one in (painter, watcher):
                    await one.hello()
                    await one.open(sequence, frame=0)
                    await holds_all(one, 0)
                stroke = str(uuid.uuid4())
                brush = {"label": label, "radius": 0.5}
                await painter.send(type="stroke_begin", id=stroke, frame=0, brush=brush)
                sample = {"origin": [0.0, 0.0, 0.0]}
                await painter.send(type="stroke_samples", id=stroke, samples=[sample])
                await painter.send(type="stroke_end", id=stroke)
                done = await painter.until("stroke_result", 30, id=stroke, final=True)
                assert done["changed"] > 0
                seen = await watcher.until("annotation", 30, frame=0, revision=done["revision"])
                assert seen["revision"] == done["revision"]
                # The other tab of the same browser takes it back.
                undo = str(uuid.uuid4())
                await watcher.send(type="undo", id=undo)
                undone = await watcher.until("stroke_result", 30, id=undo, final=True)
                assert undone["changed"] == done["changed"]

        run(scenario)


def test_plain_http_to_the_encrypted_port_leaves_the_server_well(tmp_path: Path) -> None:
    with encrypted(tmp_path) as (_, address, trusted):
        for _ in range(20):
            with pytest.raises(httpx.TransportError):
                httpx.get(address.replace("https://", "http://"))
        assert httpx.get(f"{address}/healthz", verify=trusted).status_code == 200
