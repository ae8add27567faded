"""A durable stroke at 217,088 points: the server's processor time, and what clients wait.

python benchmarks/bench_strokes.py [--strokes 300] [--rounds 3]

REST and the socket take turns with each other and with ``GET /healthz``, one client that waits for
each answer before it goes on.  A stroke over the socket is three messages; its wait is from the
last one to the durable answer.  Goals: 3.5 ms of processor time a stroke; REST p50 4 ms and p95
8 ms, the socket p50 3 ms, on a quiet machine.
"""

from __future__ import annotations

import argparse
import asyncio
import http.client
import json
import os
import statistics
import sys
import tempfile
import time
import uuid
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from bench_large import server
from bench_streaming import TOKEN, WALL, add_label, pointbrush, recording
from light_viewer import connect_light
from stroke_viewer import StrokeViewer

RADIUS = 0.05
TICK = os.sysconf("SC_CLK_TCK")


def processor_seconds(process: int) -> float:
    """Seconds that all threads of a process have computed so far."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICK


@dataclass
class Figures:
    """What the strokes of one way took: each one's wait, and the server's processor time."""

    waits: list[float] = field(default_factory=list)
    busy: float = 0.0

    def line(self, name: str) -> str:
        """A row of the table, in milliseconds."""
        p50, p95 = 1e3 * np.percentile(self.waits, [50, 95])
        each = 1e3 * self.busy / len(self.waits)
        return f"| {name} | {len(self.waits)} | {each:.2f} | {p50:.2f} | {p95:.2f} |"


def origin(turn: int) -> list[float]:
    """A point of the wall, elsewhere than the last ones, so that there is something to change."""
    v, u = divmod(6 * turn, 480)
    point: list[float] = WALL[12 + 12 * (v % 33), 16 + u].tolist()
    return point


def by_rest(url: str, label: int, turns: range) -> list[float]:
    """Seconds of each stroke, one request after the other over one connection."""
    connection, waits = http.client.HTTPConnection(url.removeprefix("http://")), []
    for turn in turns:
        samples = [{"origin": origin(turn)}]
        body = {"id": str(uuid.uuid4()), "label": label, "radius": RADIUS, "samples": samples}
        start = time.perf_counter()
        connection.request(
            "POST",
            "/api/v1/sequences/kinect/frames/0/strokes",
            json.dumps(body),
            {"Authorization": f"Bearer {TOKEN}", "Content-Type": "application/json"},
        )
        answer = connection.getresponse()
        said = answer.read()
        waits.append(time.perf_counter() - start)
        assert answer.status == 200, said
    connection.close()
    return waits


def healthy(url: str, turns: range) -> list[float]:
    """Seconds of as many answers that need nothing."""
    connection, waits = http.client.HTTPConnection(url.removeprefix("http://")), []
    for _ in turns:
        start = time.perf_counter()
        connection.request("GET", "/healthz")
        connection.getresponse().read()
        waits.append(time.perf_counter() - start)
    connection.close()
    return waits


async def by_socket(url: str, label: int, turns: range) -> list[float]:
    """Seconds from each stroke's end to its durable answer."""
    client, waits = await connect_light(StrokeViewer, url, TOKEN), []
    client.send(type="open", sequence="kinect")
    await asyncio.sleep(0.5)
    for turn in turns:
        brush = {"label": label, "radius": RADIUS}
        sent = client.stroke(0, brush, [{"origin": origin(turn)}])
        waits.append(await asyncio.wait_for(sent, 10))
    client.close()
    return waits


def measured(figures: Figures, work: Callable[[], list[float]]) -> None:
    """Add what a piece of work took."""
    process = server()
    busy = processor_seconds(process)
    figures.waits += work()
    figures.busy += processor_seconds(process) - busy


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--strokes", type=int, default=300)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    rest, socket, health = Figures(), Figures(), Figures()
    with tempfile.TemporaryDirectory() as folder:
        workspace = Path(folder) / "workspace"
        recording(workspace)
        with pointbrush(workspace) as url:
            label = add_label(url)
            by_rest(url, label, range(30))  # what is imported and compiled at the first stroke
            each, turn = given.strokes // given.rounds, 30
            for _ in range(given.rounds):
                measured(health, lambda: healthy(url, range(each)))
                turns = range(turn, turn + each)
                measured(rest, lambda turns=turns: by_rest(url, label, turns))
                turns = range(turn + each, turn + 2 * each)
                measured(socket, lambda turns=turns: asyncio.run(by_socket(url, label, turns)))
                turn += 2 * each
    print("| | n | processor ms each | p50 ms | p95 ms |\n|---|---|---|---|---|")
    print(health.line("healthz"))
    print(rest.line("stroke, REST"))
    print(socket.line("stroke, socket"))
    print(
        f"load {os.getloadavg()[0]:.1f}; median of healthz waits "
        f"{1e3 * statistics.median(health.waits):.2f} ms"
    )


if __name__ == "__main__":
    main()
