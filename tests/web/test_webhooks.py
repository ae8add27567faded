"""Webhooks: signed, told until they are taken, of tasks, edits and jobs; never to this machine."""

from __future__ import annotations

import base64
import hashlib
import hmac
import json
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import Any

import pytest

from pointbrush.client import Client
from pointbrush.database.job import Job
from pointbrush.errors import ForbiddenError
from pointbrush.teamwork import delivering, webhooks
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.teamwork.tasks import Stretch
from tests.serving import TOKEN, add_sequence, serving, settings_in
from tests.waiting import PATIENCE, eventually


class Receiver:
    """A receiver that fails ``failures`` times and then takes events."""

    def __init__(self, failures: int) -> None:
        self.failures, self.heard = failures, list[tuple[Any, bytes, int]]()

    def answer(self, headers: Any, body: bytes) -> int:
        status = 500 if len(self.heard) < self.failures else 204
        self.heard.append((headers, body, status))
        return status

    def taken(self) -> list[dict[str, Any]]:
        return [json.loads(body) for _, body, status in self.heard if status == 204]


@contextmanager
def receiving(receiver: Receiver) -> Iterator[str]:
    """Serve a receiver; gives its address."""

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = self.rfile.read(int(self.headers["Content-Length"]))
            self.send_response(receiver.answer(self.headers, body))
            self.end_headers()

        def log_message(self, *_: Any) -> None:
            pass

    with HTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.05})
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}/hook"
        finally:
            server.shutdown()
            thread.join()


@pytest.fixture(autouse=True)
def hurried(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(webhooks, "FIRST_WAIT", 0.01)
    monkeypatch.setattr(delivering, "LOOK_SECONDS", 0.05)
    monkeypatch.setattr(delivering, "FOLD_SECONDS", 0.3)


def test_a_receiver_that_fails_is_told_again_and_each_event_is_signed(tmp_path: Path) -> None:
    settings, receiver = settings_in(tmp_path, webhook_private=True), Receiver(2)
    add_sequence(settings, "wall", frames=2, points=300)
    with (
        receiving(receiver) as url,
        serving(settings) as served,
        Client(served.url, TOKEN) as client,
    ):
        project, wall = client.projects["default"], client["wall"]
        wall.create_label("before")
        made = project.add_webhook(url)
        label = wall.create_label("brick").id
        for frame in (0, 1):
            wall.frames[frame].stroke(label=label, radius=0.2, samples=[[0, 0, 3]])
        project.add_tasks()
        project.next_task()

        def told() -> dict[str, list[dict[str, Any]]]:
            found: dict[str, list[dict[str, Any]]] = {}
            for event in receiver.taken():
                found.setdefault(event["type"], []).append(event[event["type"]])
            return found

        eventually(lambda: {"task", "labels"} == told().keys() and len(told()["task"]) == 2)
        since = len(wall.edits()) - 1
        eventually(lambda: sum(each["edits"] for each in told()["labels"]) == since)
        assert sorted(each["state"] for each in told()["task"]) == ["open", "taken"]
        assert {frame for each in told()["labels"] for frame in each["frames"]} == {0, 1}
        headers, body, _ = receiver.heard[0]
        signed = f"{headers['webhook-id']}.{headers['webhook-timestamp']}.".encode() + body
        digest = hmac.new(made.secret.encode(), signed, hashlib.sha256).digest()
        assert headers["webhook-signature"] == f"v1,{base64.b64encode(digest).decode()}"
        failed = {headers["webhook-id"] for headers, _, status in receiver.heard if status == 500}
        assert failed <= {event["id"] for event in receiver.taken()}
        eventually(lambda: all(each.delivered for each in project.deliveries(made.id)))
        assert not hasattr(project.webhooks()[0], "secret")
        project.delete_webhook(made.id)
        assert project.webhooks() == []


class Slow(Receiver):
    """A receiver that answers once it is let go."""

    def __init__(self) -> None:
        super().__init__(0)
        self.asked, self.let_go = threading.Event(), threading.Event()

    def answer(self, headers: Any, body: bytes) -> int:
        self.asked.set()
        assert self.let_go.wait(PATIENCE)
        return super().answer(headers, body)


def test_a_slow_receiver_delays_no_other(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'labels.sqlite'}"
    slow, quick = Slow(), Receiver(0)
    with closing(WorkspaceStore(url)) as store, receiving(slow) as place, receiving(quick) as other:
        store.recordings.register("wall", [10, 10])
        hooks = delivering.Hooks(store.team.webhooks, private=True)
        hooks.open()
        hooks.add("default", place, ["task"])
        store.team.tasks.add("default", "lead", [Stretch("wall", 0, 0)])
        assert slow.asked.wait(PATIENCE)
        hooks.add("default", other, ["task"])
        store.team.tasks.add("default", "lead", [Stretch("wall", 1, 1)])
        eventually(lambda: len(quick.taken()) == 1)
        assert slow.taken() == []
        slow.let_go.set()
        eventually(lambda: len(slow.taken()) == 2)
        hooks.close()


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_an_event_is_one_servers_and_comes_again_when_that_has_died(
    kind: str, tmp_path: Path, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    postgres = kind == "postgresql"
    url = f"sqlite:///{tmp_path / 'labels.sqlite'}"
    url = str(request.getfixturevalue("labels_url")) if postgres else url
    with closing(WorkspaceStore(url)) as here, closing(WorkspaceStore(url)) as there:
        here.recordings.register("wall", [10])
        here.team.webhooks.add("default", "https://example.org", ["task", "labels", "job"])
        here.team.tasks.add("default", "lead", [Stretch("wall", 0, 0)])
        here.create_label("wall", "ada", name="brick")
        here.jobs.add(
            Job(
                id="job",
                kind="tracking",
                sequence="wall",
                state="done",
                progress=1.0,
                created=4e9,
                owner="ada",
            )
        )
        for store in (here, there, here):
            store.team.webhooks.gather()
        monkeypatch.setattr(webhooks, "LEASE_SECONDS", 0.0)
        taken = here.team.webhooks.take(9)
        assert {each.topic for each in taken} == {"task", "labels", "job"}
        assert len(taken) == 3
        monkeypatch.setattr(webhooks, "LEASE_SECONDS", 60.0)
        again = there.team.webhooks.take(9)  # as the lease is over
        assert {each.id for each in again} == {each.id for each in taken}
        assert here.team.webhooks.take() == []
        for each in again:
            there.team.webhooks.note_delivery(each)
        assert here.team.webhooks.take() == []


@pytest.mark.parametrize("url", ["http://127.0.0.1:9/", "http://[::1]/", "http://localhost/"])
def test_no_webhook_leads_to_this_machine(url: str, tmp_path: Path) -> None:
    with closing(WorkspaceStore(f"sqlite:///{tmp_path / 'labels.sqlite'}")) as store:
        hooks = delivering.Hooks(store.team.webhooks, private=False)
        with pytest.raises(ForbiddenError, match="public"):
            hooks.add("default", url)


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_a_receiver_that_is_away_is_paused_and_told_everything_later(
    kind: str, tmp_path: Path, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    url = f"sqlite:///{tmp_path / 'labels.sqlite'}"
    url = str(request.getfixturevalue("labels_url")) if kind == "postgresql" else url
    monkeypatch.setattr(webhooks, "FIRST_WAIT", 60.0)
    with closing(WorkspaceStore(url)) as store:
        store.recordings.register("wall", [10] * 5)
        hooks = store.team.webhooks
        away = hooks.add("default", "https://away.example.org", ["task"])
        other = hooks.add("default", "https://other.example.org", ["task"])
        for frame in range(5):
            store.team.tasks.add("default", "lead", [Stretch("wall", frame, frame)])
        for _ in range(2):
            hooks.note_delivery(*hooks.take(1, away.id), "answered 503")
        assert [each.paused_until for each in hooks.all()] == [None, None]
        hooks.note_delivery(*hooks.take(1, away.id), "answered 503")
        paused = next(each for each in hooks.all() if each.id == away.id).paused_until
        assert paused is not None
        assert hooks.waiting() == [other.id]
        assert hooks.take(9, away.id) == []
        assert len(hooks.take(9, other.id)) == 5
        monkeypatch.setattr(store.team.webhooks._database, "now", lambda _: paused.timestamp() + 60)
        assert len(hooks.take(9, away.id)) == 5
