"""Services of the operator's own, a selector and a model, answer wrongly or not at all."""

from __future__ import annotations

import gzip
import io
import threading
import time
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import httpx
import numpy as np

from tests.faults.clients import SEQUENCE
from tests.faults.server import ServerProcess, running
from tests.torture.authors import Authors, quiet
from tests.torture.framework import Arena, Tally, scenario

RAYS = {"positives": [{"origin": [0.0, 0.0, 0.0], "direction": [0.0, 0.0, 1.0]}]}
BOMB_BYTES = 1 << 30
"""Of an answer, unpacked: more than any bound."""
MOST_GROWTH = 1_500 << 20
"""Bytes that a server may grow by: one answer within its bound, packed and unpacked, and room."""
LEFT = 60.0
"""Longest wait for a refusal of an answer that does come to an end."""
QUICK = ("flood", "gzip", "zip bomb", "dtype", "shape", "numbers", "redirect", "status", "closed",
         "noise")  # fmt: skip
ENDLESS = ("silent", "drips")
"""Answers that the server waits for as long as a model may take."""


def _npz(**arrays: Any) -> bytes:
    out = io.BytesIO()
    np.savez(out, **arrays)
    return out.getvalue()


def _zip_bomb() -> bytes:
    """An archive of some megabytes with an array of ``BOMB_BYTES``."""
    head = io.BytesIO()
    shape = {"descr": "|u1", "fortran_order": False, "shape": (BOMB_BYTES,)}
    np.lib.format.write_array_header_1_0(head, shape)
    out = io.BytesIO()
    with (
        zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open("state.npy", "w", force_zip64=True) as entry,
    ):
        entry.write(head.getvalue())
        for _ in range(BOMB_BYTES >> 26):
            entry.write(bytes(1 << 26))
    return out.getvalue()


WRONG = {
    "dtype": _npz(state=np.zeros(3, "<U9"), scores=np.array(["a"]), takes=np.zeros(2)),
    "shape": _npz(state=np.zeros((2, 2), np.uint8), scores=np.zeros((3, 1, 2), np.float32)),
    "numbers": _npz(
        state=np.zeros(0, np.uint8),
        scores=np.array([np.nan], np.float32),
        indices_0=np.array([-(2**62), 2**62]),
    ),
    "noise": b"\x93NUMPY" + bytes(range(256)) * 8,
}


class Service:
    """Answers every call in the way of ``manner``; ``sound`` are calls that are answered well."""

    def __init__(self) -> None:
        self.manner = "status"
        self.ended = threading.Event()
        self.bomb = _zip_bomb()

    def answer(self, handler: BaseHTTPRequestHandler) -> None:
        handler.rfile.read(int(handler.headers["Content-Length"]))
        manner = self.manner
        if handler.path.endswith("about") and manner not in ("silent", "drips", "closed"):
            about = {"takes": np.array("points"), "learns": np.array(False)}
            return self._send(handler, _npz(**about, classes=np.array(["a", "b"])))
        if manner in WRONG:
            return self._send(handler, WRONG[manner])
        if manner == "zip bomb":
            return self._send(handler, self.bomb)
        if manner == "gzip":
            return self._send(handler, gzip.compress(bytes(1 << 26)), ("Content-Encoding", "gzip"))
        if manner == "status":
            return handler.send_error(500)
        if manner == "redirect":
            return self._send(handler, b"", ("Location", "http://127.0.0.1:1/"), status=302)
        if manner == "silent":
            self.ended.wait()
        elif manner in ("flood", "drips"):
            self._without_end(handler, 1 << 20 if manner == "flood" else 1)
        return None

    def _send(
        self, handler: BaseHTTPRequestHandler, body: bytes, *headers: tuple[str, str], status=200
    ) -> None:
        handler.send_response(status)
        for name, value in (("Content-Length", str(len(body))), *headers):
            handler.send_header(name, value)
        handler.end_headers()
        handler.wfile.write(body)

    def _without_end(self, handler: BaseHTTPRequestHandler, size: int) -> None:
        handler.send_response(200)
        handler.end_headers()
        while not self.ended.is_set():
            handler.wfile.write(bytes(size))
            if size == 1:
                time.sleep(0.1)


@contextmanager
def serving(service: Service) -> Iterator[str]:
    """Serve until the context ends; gives the address."""

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            with suppress(OSError):
                service.answer(self)

        def log_message(self, *_: Any) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        server.daemon_threads = True
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            service.ended.set()
            server.shutdown()


def resident(process: int, name: str = "VmRSS") -> int:
    """Return the bytes of memory of a process, by a name of its status."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return next(int(line.split()[1]) << 10 for line in lines if line.startswith(f"{name}:"))


def _ask(server: ServerProcess, tally: Tally, manner: str) -> None:
    """Ask both services; each must be refused with 503 that names it."""
    with server.api(timeout=LEFT) as api:
        for path, body, name in (
            ("object", RAYS, "selector"),
            ("prediction", {"classifier": "own"}, "model own"),
        ):
            try:
                answer = api.post(f"/sequences/{SEQUENCE}/frames/0/{path}", json=body)
                # While the server prepares the frame, it does not ask the selector.
                while answer.status_code == 200 and not answer.json().get("ready", True):
                    time.sleep(0.1)
                    answer = api.post(f"/sequences/{SEQUENCE}/frames/0/{path}", json=body)
            except httpx.TransportError as error:
                tally.count("errors", f"{manner}: {name}: {error!r}")
                continue
            if answer.status_code != 503 or name not in answer.json()["detail"]:
                tally.count("differs", f"{manner}: {name}: {answer.status_code} {answer.text}")
            else:
                tally.refused += 1


def _leave_waiting(server: ServerProcess) -> list[threading.Thread]:
    """Ask more often than a service may be asked at a time, and do not wait."""

    def ask() -> None:
        with suppress(httpx.HTTPError), server.api(timeout=2.0) as api:
            api.post(f"/sequences/{SEQUENCE}/frames/0/object", json=RAYS)

    threads = [threading.Thread(target=ask, daemon=True) for _ in range(12)]
    for thread in threads:
        thread.start()
    return threads


@scenario("a selector and a model over HTTP hang, flood or lie, while six authors edit", 2)
def own_models_hostile(arena: Arena) -> None:
    """Edits are answered, each refusal names the service, and memory stays bounded."""
    authors = Authors(arena.folder / "workspace", arena.seed)
    service, tally = Service(), arena.tally
    address = arena.stack.enter_context(serving(service))
    options = {"POINTBRUSH_SELECTOR": address, "POINTBRUSH_MODELS": f"own={address}"}
    server = arena.stack.enter_context(running(arena.folder / "workspace", **options))
    with authors.editing(lambda: [server.url]):
        time.sleep(1.0)  # labels to learn from
    authors.settle(server, tally)
    with server.api() as api:
        made = {"name": "own", "recordings": [SEQUENCE], "model": "own"}
        api.post("/classifiers", json=made).raise_for_status()
    before = resident(server.process.pid)
    for number in arena.rounds():
        with authors.editing(lambda: [server.url]):
            for service.manner in arena.rng.sample(QUICK, len(QUICK)):
                _ask(server, tally, service.manner)
            service.manner = ENDLESS[number % len(ENDLESS)]
            for thread in _leave_waiting(server):
                thread.join()
        authors.settle(server, tally)
        grown = resident(server.process.pid, "VmHWM") - before
        if grown > MOST_GROWTH:
            tally.count("errors", f"the server grew by {grown >> 20} MiB")
    quiet(server, tally)
