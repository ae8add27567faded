"""Two servers tell the events of one webhook, and one of them is killed."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import httpx

from tests.faults.server import ServerProcess, running
from tests.serving import add_sequence, settings_in
from tests.torture.authors import quiet
from tests.torture.framework import Arena, scenario
from tests.waiting import eventually

FRAMES = 30
LONGEST = 120.0
"""Seconds until all has arrived: an event of a killed server waits for its lease, 30 s."""


class Receiver:
    """Keeps the events that it has taken; ``slow``: seconds that each takes."""

    def __init__(self) -> None:
        self.slow = 0.1
        self.heard: list[tuple[str, bytes]] = []

    def bodies(self) -> dict[str, set[bytes]]:
        found: dict[str, set[bytes]] = {}
        for name, body in list(self.heard):
            found.setdefault(name, set()).add(body)
        return found


@contextmanager
def receiving(receiver: Receiver) -> Iterator[str]:
    """Serve a receiver; gives its address."""

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = self.rfile.read(int(self.headers["Content-Length"]))
            receiver.heard.append((str(self.headers["webhook-id"]), body))
            time.sleep(receiver.slow)
            with suppress(OSError):
                self.send_response(204)
                self.end_headers()

        def log_message(self, *_: Any) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            yield f"http://127.0.0.1:{server.server_port}/hook"
        finally:
            server.shutdown()


def _events(api: httpx.Client, hook: str) -> list[dict[str, Any]]:
    path = f"/projects/default/webhooks/{hook}/deliveries"
    found: list[dict[str, Any]] = api.get(path).raise_for_status().json()
    return found


@scenario("one of two servers that tell a webhook's events is killed", 1)
def webhook_server_killed(arena: Arena) -> None:
    """Each event arrives, a second time only under the same id."""
    url, receiver, tally = arena.postgres().new_labels(), Receiver(), arena.tally
    settings = settings_in(arena.folder, database=url)
    add_sequence(settings, "wall", frames=FRAMES, points=50)
    address = arena.stack.enter_context(receiving(receiver))
    options = {"POINTBRUSH_DATABASE": url, "POINTBRUSH_WEBHOOK_PRIVATE": "true"}
    stays = arena.stack.enter_context(running(settings.workspace, **options))
    with stays.api() as api:
        body = {"url": address, "topics": ["task"]}
        hook = api.post("/projects/default/webhooks", json=body).raise_for_status().json()["id"]
        for _ in arena.rounds():
            with running(settings.workspace, **options) as killed:
                _work(stays, killed)
                time.sleep(arena.rng.uniform(0.2, 2.0))
                killed.kill()
                quiet(killed, tally)
            eventually(lambda: all(each["delivered"] for each in _events(api, hook)), LONGEST, 0.5)
            bodies = receiver.bodies()
            missing = {each["id"] for each in _events(api, hook)} - bodies.keys()
            if missing:
                tally.count("lost", f"events that did not arrive: {missing}")
            if any(len(each) > 1 for each in bodies.values()):
                tally.count("differs", f"other bodies under an id: {bodies}")
            tally.answered = len(bodies)
            for task in api.get("/projects/default/tasks").raise_for_status().json():
                api.delete(f"/projects/default/tasks/{task['number']}").raise_for_status()
    quiet(stays, tally)


def _work(*servers: ServerProcess) -> None:
    """Add a task for each frame by the one server, and take one by the other."""
    with servers[0].api() as here, servers[-1].api() as there:
        body = {"frames": f"0:{FRAMES}", "every": 1}
        here.post("/projects/default/tasks", json=body).raise_for_status()
        there.post("/projects/default/tasks/next", json={"work": "label"}).raise_for_status()
