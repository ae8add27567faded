"""Calls for things of a closed project by people outside it, and a look for traces of these."""

from __future__ import annotations

import io
import random
import threading
import uuid
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import Any

import httpx
import msgpack
from websockets.exceptions import WebSocketException
from websockets.sync.client import connect

from pointbrush.streaming.schema import subprotocol
from tests.faults.server import ServerProcess
from tests.routes import ROUTES
from tests.torture.framework import Tally

SOCKET_SECONDS = 0.1
"""Longest wait for a message before the recording is asked for again."""
STROKE = {"label": 1, "radius": 0.3, "samples": [{"origin": [0.0, 0.0, 1.0]}]}
BODIES: Mapping[str, Any] = {
    "POST /sequences/{seq}/frames/{i}/strokes": STROKE,
    "POST /sequences/{seq}/labels": {"name": "of a stranger"},
    "PATCH /sequences/{seq}/labels/{id}": {"name": "of a stranger"},
    "PATCH /sequences/{seq}": {"name": "of a stranger"},
    "PATCH /projects/{p}": {"name": "of a stranger"},
    "PATCH /projects/{p}/tasks/{t}": {"note": "of a stranger"},
    "POST /projects/{p}/snapshots": {"name": "of a stranger"},
    "PUT /sequences/{seq}/review": {"first": 0, "last": 0, "state": "review", "note": ""},
    "PUT /sequences/{seq}/frames/{i}/review": {"state": "review", "note": ""},
    "POST /sequences/{seq}/tracking": {"labels": [1], "start": 0, "stop": 1, "method": "icp"},
}
"""Bodies of calls; {} of others."""
QUERIES: Mapping[str, Mapping[str, Any]] = {
    "GET /sequences": {"deleted": True},
    "GET /sequences/{seq}/events": {"after": 0},
    "GET /sequences/{seq}/export": {"format": "npz"},
}
"""Queries of half of the calls; others have none."""
CALLS = sorted(each for each in ROUTES if each[0] != "WEBSOCKET" and each[1] != "/session")
READS = [each for each in CALLS if each[0] == "GET"]


@dataclass
class Secrets:
    """Marks of what is of a project, by project, and values that a path may name."""

    marks: dict[str, set[bytes]] = field(default_factory=dict)
    jobs: list[str] = field(default_factory=lambda: [str(uuid.UUID(int=0))])
    snapshots: list[str] = field(default_factory=lambda: ["none"])

    def add(self, project: str, *marks: str | bytes) -> None:
        """Add marks that occur in no answer to others."""
        found = {each.encode() if isinstance(each, str) else each for each in marks}
        self.marks[project] = self.marks.get(project, set()) | found


@dataclass(frozen=True)
class Stranger:
    """A person with a role outside of ``closed`` projects."""

    name: str
    token: str
    closed: tuple[str, ...]


def call(
    api: httpx.Client, chosen: tuple[str, str], secrets: Secrets, rng: random.Random, **names: str
) -> httpx.Response:
    """Call a route of the table with ``names`` of a recording and a project, seq and p."""
    method, template = chosen
    values = {"i": "0", "c": "0", "t": str(rng.randint(1, 3)), "w": "0" * 16, "a": "ann"}
    values |= {"id": rng.choice(secrets.jobs) if "jobs" in template else "1"}
    values |= {"s": rng.choice(secrets.snapshots), "camera": "front", "number": "1"} | names
    path = template
    for name, value in values.items():
        path = path.replace(f"{{{name}}}", value)
    body = None if method in ("GET", "DELETE") else BODIES.get(f"{method} {template}", {})
    query = QUERIES.get(f"{method} {template}", {}) if rng.random() < 0.5 else {}
    return api.request(method, path, params=query, json=body)


def traces(content: bytes, marks: Iterable[bytes]) -> set[bytes]:
    """Find the marks that are in an answer, or in the members of its archive."""
    parts = [content]
    if content.startswith(b"PK"):
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            parts += [archive.read(name) for name in archive.namelist()]
            parts += ["\n".join(archive.namelist()).encode()]
    return {mark for mark in marks if any(mark in part for part in parts)}


def require_unseen(
    stranger: Stranger, what: str, content: bytes, secrets: Secrets, tally: Tally
) -> None:
    """Count marks of closed projects in the answer to ``what`` of a stranger as a difference."""
    for project in stranger.closed:
        marks = [mark for mark in secrets.marks.get(project, ()) if mark not in what.encode()]
        if found := traces(content, marks):
            shown = content.decode(errors="replace")[:300]
            tally.count("differs", f"{stranger.name}: {what} tells {found} of {project}: {shown}")


@contextmanager
def looking(
    server: ServerProcess,
    people: Iterable[Stranger],
    secrets: Secrets,
    tally: Tally,
    seed: int,
    **names: list[str],
) -> Iterator[None]:
    """Have everyone read all that they can by REST and by the socket until the context ends."""
    stop = threading.Event()
    threads = [
        threading.Thread(target=target, args=(server, one, secrets, tally, stop, seed, names))
        for one in people
        for target in (_read, _listen)
    ]
    with ExitStack() as stack:
        for thread in threads:
            thread.start()
            stack.callback(thread.join)
        stack.callback(stop.set)
        yield


def _read(
    server: ServerProcess, one: Stranger, secrets: Secrets, tally: Tally, stop: threading.Event,
    seed: int, names: dict[str, list[str]],
) -> None:  # fmt: skip
    rng = random.Random(f"{seed} {one.name}")
    with server.api(one.token) as api:
        while not stop.is_set():
            chosen = rng.choice(READS)
            picked = {name: rng.choice(values) for name, values in names.items()}
            answer = call(api, chosen, secrets, rng, **picked)
            tally.status(answer.status_code, f"{answer.url} {answer.text[:300]}")
            require_unseen(one, f"{answer.url}", answer.content, secrets, tally)


def _listen(
    server: ServerProcess, one: Stranger, secrets: Secrets, tally: Tally, stop: threading.Event,
    _: int, names: dict[str, list[str]],
) -> None:  # fmt: skip
    hello = [{"type": "hello", "name": one.name}]
    opened = [{"type": "open", "sequence": name} for name in names["seq"]]
    while not stop.is_set():
        try:
            with connect(
                server.url.replace("http", "ws", 1) + "/api/v1/stream",
                additional_headers={"Authorization": f"Bearer {one.token}"},
                subprotocols=[subprotocol()],  # type: ignore[list-item]
                max_size=None,
            ) as socket:
                for message in hello:
                    socket.send(msgpack.packb(message))
                while not stop.is_set():
                    try:
                        heard = socket.recv(timeout=SOCKET_SECONDS)
                    except TimeoutError:
                        for message in (*opened, {"type": "credit", "frames": 8}):
                            socket.send(msgpack.packb(message))
                        continue
                    assert isinstance(heard, bytes)
                    require_unseen(one, "a message", heard, secrets, tally)
        except WebSocketException:
            continue
