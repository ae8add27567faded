"""Answer the object tool's clicks in your own service: a toy model over HTTP.

    python docs/examples/selector_server.py --port 9000
    pointbrush serve --selector http://127.0.0.1:9000

The toy returns the points within several distances of the clicks.  Replace ``regions`` by your
promptable network: it receives a frame once (``prepare``) and then the clicks on it
(``candidates``).  docs/object-tool.md describes the calls.
"""

from __future__ import annotations

import argparse
import io
from collections import OrderedDict
from collections.abc import Callable, Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, ClassVar

import numpy as np

DISTANCES = (0.05, 0.1, 0.2, 0.4, 0.8)
"""Metres; a candidate for each."""
KEPT_FRAMES = 16
LONGEST_BODY = 1 << 30

frames: OrderedDict[bytes, np.ndarray] = OrderedDict()


def prepare(arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Store a frame and return its name."""
    xyz = arrays["xyz"]
    name = b"frame-%d" % hash(xyz.tobytes())
    frames[name] = xyz
    while len(frames) > KEPT_FRAMES:
        frames.popitem(last=False)
    return {"state": np.frombuffer(name, np.uint8)}


def candidates(arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the regions for clicks on a frame, the best first."""
    xyz = frames[arrays["state"].tobytes()]
    found = regions(xyz, arrays["positives"], arrays["negatives"])
    answer = {f"indices_{i}": numbers for i, numbers in enumerate(found)}
    answer["scores"] = np.linspace(1, 0.5, len(found), dtype=np.float32)
    return answer


def regions(xyz: np.ndarray, positives: np.ndarray, negatives: np.ndarray) -> list[np.ndarray]:
    """Return the points near a positive click that are farther from all negative clicks."""
    near = distance(xyz, positives)
    kept = near < distance(xyz, negatives)
    found = [np.flatnonzero(kept & (near < reach)) for reach in DISTANCES]
    return [numbers for numbers in found if len(numbers)]


def distance(xyz: np.ndarray, clicks: np.ndarray) -> np.ndarray:
    """Return the distance in metres from each point (N,) to the nearest click."""
    away = [np.linalg.norm(xyz - click, axis=1) for click in clicks]
    return np.min(away, axis=0) if away else np.full(len(xyz), np.inf)


Calls = Mapping[str, Callable[[dict[str, np.ndarray]], dict[str, np.ndarray]]]


class Handler(BaseHTTPRequestHandler):
    """Answers POST requests; bodies and answers are .npz files."""

    calls: ClassVar[Calls] = {}

    def do_POST(self) -> None:
        """Answer a call."""
        length = int(self.headers.get("Content-Length", "0"))
        call = self.calls.get(self.path)
        if call is None or not 0 < length <= LONGEST_BODY:
            self.send_error(404 if call is None else 400)
            return
        try:
            with np.load(io.BytesIO(self.rfile.read(length)), allow_pickle=False) as body:
                answer = call(dict(body.items()))
        except KeyError:
            self.send_error(410, "the frame is not stored (any more): prepare it again")
            return
        data = io.BytesIO()
        np.savez(data, **answer)
        self.send_response(200)
        self.send_header("Content-Type", "application/x-npz")
        self.send_header("Content-Length", str(data.tell()))
        self.end_headers()
        self.wfile.write(data.getvalue())

    def log_message(self, *_: Any) -> None:
        """Log nothing."""


def serve(calls: Calls, name: str, port: int) -> None:
    """Serve on loopback until interrupted, at ``port`` or at the port of ``--port``."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--port", type=int, default=port)
    handler = type("Calls", (Handler,), {"calls": calls})
    server = ThreadingHTTPServer(("127.0.0.1", parser.parse_args().port), handler)
    print(f"{name} ready at http://127.0.0.1:{server.server_port}", flush=True)
    server.serve_forever()


if __name__ == "__main__":
    serve({"/v1/prepare": prepare, "/v1/candidates": candidates}, "selector", 9000)
