"""Receivers of webhooks and providers of sign-ins that never answer, drip, flood or bomb."""

from __future__ import annotations

import itertools
import json
import threading
import time
import uuid
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack

import httpx

from tests.faults.clients import FRAMES, SEQUENCE
from tests.faults.server import ServerProcess, running
from tests.torture.authors import Authors, quiet
from tests.torture.framework import Arena, scenario
from tests.torture.hostile import KINDS, HostilePeer
from tests.torture.machine import peak_memory, resident
from tests.torture.scenarios.queues import receiving
from tests.waiting import PATIENCE, eventually

EACH = 3
"""Hostile webhooks of each kind."""
GOOD = 2
"""Other webhooks."""
EDIT_SECONDS = 1.5
"""Time of a round in which authors edit."""
FAR = 60.0
"""Longest wait for events that others are to hear meanwhile."""
MOST_MEMORY = 160 << 20
"""Bytes that a server may grow by meanwhile."""
HOOKS, TASKS = "/projects/default/webhooks", "/projects/default/tasks"
STEPS = ("taken", "done", "accepted")
ENDLESS = ("silent", "dripping")
"""Kinds of providers that are waited for until the deadline; too many bytes end a call at once."""
STRANGERS = 45
"""More than the threads that answer REST."""


class Heard:
    """Steps of tasks that a receiver was told."""

    def __init__(self) -> None:
        self.steps: Counter[tuple[int, str]] = Counter()

    def hear(self, body: bytes) -> int:
        """Take an event; one may come twice."""
        task = json.loads(body)["task"]
        self.steps[task["number"], task["state"]] = 1
        return 204


class Memory:
    """Memory of a server from now on."""

    def __init__(self, arena: Arena, server: ServerProcess) -> None:
        self._arena, self._process = arena, server.process.pid
        self._before = resident(self._process)

    def look(self) -> None:
        """Count it as a difference if the server has grown too much, even for a moment."""
        grown = peak_memory(self._process) - self._before
        if grown > MOST_MEMORY:
            self._arena.tally.count("differs", f"the server grew by {grown:,} bytes")


@scenario("webhook receivers hang, drip, flood, bomb or redirect, while six authors edit", 1)
def hostile_receivers(arena: Arena) -> None:
    """The other webhooks are told at once, memory is bounded, and no redirection is followed."""
    workspace = arena.folder / "workspace"
    authors = Authors(workspace, arena.seed)
    server = arena.stack.enter_context(running(workspace, POINTBRUSH_WEBHOOK_PRIVATE="true"))
    peer = arena.stack.enter_context(HostilePeer())
    good = [Heard() for _ in range(GOOD)]
    memory, told = Memory(arena, server), Counter[tuple[int, str]]()

    def missing() -> list[Counter[tuple[int, str]]]:
        return [told - each.steps for each in good if each.steps != told]

    with server.api() as api:
        for each in good:
            url = arena.stack.enter_context(receiving(each))
            api.post(HOOKS, json={"url": url, "topics": ["task"]}).raise_for_status()
        for _ in arena.rounds():
            with ExitStack() as hooks:
                for number, kind in itertools.product(range(EACH), KINDS):
                    asked = {"url": f"{peer.url}/{number}/{kind}", "topics": ["task"]}
                    made = api.post(HOOKS, json=asked).raise_for_status().json()
                    hooks.callback(api.delete, f"{HOOKS}/{made['id']}")
                told.update(_tasks_made(api))
                eventually(lambda: peer.met.keys() == set(KINDS) and peer.hanging, FAR)
                with authors.editing(lambda: [server.url]):
                    time.sleep(EDIT_SECONDS)
                told.update(_tasks_made(api))
                with arena.tally.expect("lost"):
                    eventually(lambda: not missing(), FAR)
            with arena.tally.expect("differs"):
                eventually(lambda: not peer.hanging, FAR)
            memory.look()
            authors.settle(server, arena.tally)
            peer.met.clear()
    if peer.strayed:
        arena.tally.count("differs", f"{peer.strayed} redirections were followed")
    quiet(server, arena.tally)


def _tasks_made(api: httpx.Client) -> Counter[tuple[int, str]]:
    """Have a task of each frame done; returns the steps that webhooks are to be told."""
    asked = {"every": 1, "id": str(uuid.uuid4())}
    made = api.post(TASKS, json=asked).raise_for_status().json()
    assert len(made) == FRAMES
    steps = [(task["number"], state) for task in made for state in STEPS]
    for number, state in steps:
        api.patch(f"{TASKS}/{number}", json={"state": state}).raise_for_status()
    return Counter(steps) + Counter((task["number"], "open") for task in made)


@scenario("a sign-in provider hangs, drips, floods or bombs, strangers sign in, six edit", 1)
def hostile_provider(arena: Arena) -> None:
    """REST is answered while strangers wait; one server knows the provider, another does not."""
    workspace, secret = arena.folder / "workspace", arena.folder / "secret"
    secret.write_text("s3cret")
    authors = Authors(workspace, arena.seed)
    peer = arena.stack.enter_context(HostilePeer())
    options = {
        "POINTBRUSH_OIDC_ISSUER": peer.url,
        "POINTBRUSH_OIDC_CLIENT_ID": "us",
        "POINTBRUSH_OIDC_CLIENT_SECRET_FILE": str(secret),
    }
    server = arena.stack.enter_context(running(workspace, **options))
    memory = Memory(arena, server)
    for number in arena.rounds():
        kind = KINDS[number % len(KINDS)]
        peer.description, peer.token = "", kind
        _besieged(arena, server, authors, peer, kind, with_codes=True)
        peer.description = kind
        with running(workspace, **options) as other:
            fresh = Memory(arena, other)
            _besieged(arena, other, authors, peer, kind, with_codes=False)
            fresh.look()
        memory.look()
        authors.settle(server, arena.tally)
    if peer.strayed:
        arena.tally.count("differs", f"{peer.strayed} redirections were followed")
    quiet(server, arena.tally)


def _besieged(
    arena: Arena, server: ServerProcess, authors: Authors, peer: HostilePeer, kind: str, *,
    with_codes: bool,
) -> None:  # fmt: skip
    """Have strangers sign in, with made-up codes or from the beginning, and edit meanwhile."""
    waiting = threading.Semaphore(0)

    def sign_in(begun: httpx.Response | None) -> httpx.Response:
        with httpx.Client(base_url=f"{server.url}/api/v1", timeout=PATIENCE) as browser:
            waiting.release()
            if begun is None:
                return browser.get("/oidc/login")
            browser.cookies.update(begun.cookies)
            state = httpx.URL(begun.headers["location"]).params["state"]
            return browser.get("/oidc/callback", params={"code": "made up", "state": state})

    begun = [
        httpx.get(f"{server.url}/api/v1/oidc/login") if with_codes else None
        for _ in range(STRANGERS)
    ]
    peer.met.clear()
    with ThreadPoolExecutor(STRANGERS) as pool:
        tries = [pool.submit(sign_in, each) for each in begun]
        for _ in tries:
            waiting.acquire()
        eventually(lambda: peer.met[kind] or all(each.done() for each in tries))
        with server.api() as api:
            looked = api.get(f"/sequences/{SEQUENCE}")
            arena.tally.status(looked.status_code, looked.text)
        if kind in ENDLESS and all(each.done() for each in tries):
            arena.tally.count("differs", "REST was answered after the strangers")
        with authors.editing(lambda: [server.url]):
            time.sleep(EDIT_SECONDS)
    for each in tries:
        answer = each.result()
        arena.tally.status(answer.status_code, answer.text, away=True)
        if answer.is_success or answer.headers.get("location") == "/":
            arena.tally.count("differs", f"a stranger is in: {answer.status_code} {answer.text}")
