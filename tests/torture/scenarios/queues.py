"""A queue that people at two servers work off while one of them is killed, and its webhook."""

from __future__ import annotations

import json
import random
import threading
import time
import uuid
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, Protocol

import httpx

from pointbrush.teamwork.store import WorkspaceStore
from tests.faults.server import ServerProcess, running
from tests.serving import add_sequence, settings_in
from tests.torture.authors import quiet
from tests.torture.framework import Arena, Tally, scenario

PEOPLE = 4
FRAMES = 6
"""Frames of a recording, each of which is a task."""
FAILS = 0.1
"""Share of events that the receiver refuses."""
DELIVERED_SECONDS = 120.0
"""Longest wait for events that a killed server had taken."""
QUEUE = "/projects/default/tasks"


class Hears(Protocol):
    """Takes the events of a webhook in."""

    def hear(self, body: bytes) -> int:
        """Take an event; returns the status."""


class Work:
    """Steps that were answered: who took each task; and events that were taken in."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        self.taken: dict[int, set[str]] = {}
        self.events: dict[str, tuple[int, str]] = {}
        self.lock = threading.Lock()
        self.servers: list[ServerProcess] = []

    def hear(self, body: bytes) -> int:
        """Take an event in, or refuse it; returns the status."""
        with self.lock:
            if self.rng.random() < FAILS:
                return 500
            event = json.loads(body)
            self.events[event["id"]] = event["task"]["number"], event["task"]["state"]
            return 204

    def label(self, name: str, token: str, tally: Tally) -> None:
        """Take tasks and hand them in, at either server, until there are none."""
        headers = {"Authorization": f"Bearer {token}"}
        while True:
            with self.lock:
                url = f"{self.rng.choice(self.servers).url}/api/v1{QUEUE}"
            try:
                answer = httpx.post(f"{url}/next", json={}, headers=headers)
                if not tally.status(answer.status_code, answer.text, away=True):
                    continue
                task = answer.json()
                if task is None:
                    return
                with self.lock:
                    self.taken.setdefault(task["number"], set()).add(name)
                done = {"state": "done"}
                answer = httpx.patch(f"{url}/{task['number']}", json=done, headers=headers)
                tally.status(answer.status_code, answer.text, away=True)
            except httpx.TransportError:
                time.sleep(0.05)  # the server was killed: the other one answers


@contextmanager
def receiving(work: Hears) -> Iterator[str]:
    """A receiver of events; gives its address."""

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = self.rfile.read(int(self.headers["Content-Length"]))
            self.send_response(work.hear(body))
            self.end_headers()

        def log_message(self, *_: Any) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}/"
        finally:
            server.shutdown()
            thread.join()


def _worked_off(arena: Arena, url: str) -> None:
    settings = settings_in(arena.folder, database=url)
    environment = {"POINTBRUSH_WEBHOOK_PRIVATE": "true"} | (
        {"POINTBRUSH_DATABASE": url} if url else {}
    )
    for name in ("one", "two"):
        add_sequence(settings, name, frames=FRAMES, points=50)
    work = Work(arena.seed)
    receiver = arena.stack.enter_context(receiving(work))

    def serve() -> ServerProcess:
        return arena.stack.enter_context(running(settings.workspace, **environment))

    work.servers = [serve(), serve()]
    store = WorkspaceStore(settings.database_url)
    people = {f"p{n}": store.tokens.add("annotator", f"p{n}", None) for n in range(PEOPLE)}
    store.close()
    with work.servers[0].api() as api:
        asked = {"url": receiver, "topics": ["task"]}
        api.post("/projects/default/webhooks", json=asked).raise_for_status()
    pool = arena.stack.enter_context(ThreadPoolExecutor(PEOPLE))
    for _ in arena.rounds():
        with work.servers[0].api() as api:
            asked = {"every": 1, "id": str(uuid.uuid4())}
            made = api.post(QUEUE, json=asked).raise_for_status().json()
        at_work = [pool.submit(work.label, *each, arena.tally) for each in people.items()]
        time.sleep(arena.rng.uniform(0.05, 0.4))
        killed = arena.rng.randrange(2)
        work.servers[killed].kill()
        fresh = serve()
        with work.lock:
            work.servers[killed] = fresh
        for each in at_work:
            each.result()
        _compare(work, [task["number"] for task in made], arena.tally)
        _accept(work.servers[0], made)
    for server in work.servers:
        quiet(server, arena.tally)


def _compare(work: Work, numbers: list[int], tally: Tally) -> None:
    """Compare the tasks with what was answered, and the events with the tasks' histories."""
    steps: Counter[tuple[int, str]] = Counter()
    with work.servers[0].api() as api:
        for number in numbers:
            history = api.get(f"{QUEUE}/{number}/history").raise_for_status().json()
            steps.update((number, each["state"]) for each in history)
            states = [each["state"] for each in history]
            who = {each["assignee"] for each in history} - {""}
            if states != ["done", "taken", "open"] or len(who) != 1:
                tally.count("differs", f"task {number} went {states} with {who}")
            if not work.taken.get(number, set()) <= who:
                tally.count("differs", f"task {number} of {who} was given {work.taken[number]}")
    end = time.monotonic() + DELIVERED_SECONDS
    while (missing := steps - _told(work, numbers)) and time.monotonic() < end:
        time.sleep(0.2)
    if missing:
        tally.count("lost", f"events that never came: {dict(missing)}")
    if more := _told(work, numbers) - steps:
        tally.count("differs", f"events of steps that there were not: {dict(more)}")


def _told(work: Work, numbers: list[int]) -> Counter[tuple[int, str]]:
    with work.lock:
        return Counter(step for step in work.events.values() if step[0] in set(numbers))


def _accept(server: ServerProcess, made: list[dict[str, Any]]) -> None:
    """Let the frames have tasks again."""
    with server.api() as api:
        for task in made:
            accepted = {"state": "accepted"}
            api.patch(f"{QUEUE}/{task['number']}", json=accepted).raise_for_status()


@scenario("four people work a queue off at two SQLite servers, one is killed, a webhook fails", 1)
def queue(arena: Arena) -> None:
    """No task is two people's or nobody's, and each event comes, told apart by its id."""
    _worked_off(arena, "")


@scenario("the same on PostgreSQL", 1)
def queue_postgres(arena: Arena) -> None:
    """The same rows, locked there."""
    _worked_off(arena, arena.postgres().new_labels())
