"""People who edit at random, over REST and over the socket, one edit after another."""

from __future__ import annotations

import random
import threading
import time
import uuid
from dataclasses import dataclass, field
from typing import Any

import httpx
import msgpack
from websockets.exceptions import WebSocketException
from websockets.sync.client import ClientConnection, connect

from pointbrush.streaming.schema import subprotocol
from tests.waiting import PATIENCE

SEQUENCE = "ball"
FRAMES = 4
STROKES = ["paint"] * 7 + ["erase", "delete", "delete", "restore"]
KINDS = ["stroke"] * 14 + ["undo"] * 4 + ["redo"] * 3 + ["create", "change", "remove", "track"]
ENDED = ("done", "failed", "cancelled")
Edit = dict[str, Any]


LOST = (OSError, EOFError, WebSocketException, httpx.TransportError)
"""The server went away before it answered."""


class RefusedError(Exception):
    """The server said no."""


class AwayError(RefusedError):
    """The server said 503: a part that it needs is away, and nothing was changed."""


AWAY_SECONDS = 0.1
"""Time that an author waits after it."""


@dataclass
class Asked:
    """One edit as its author sees it."""

    edit: Edit
    answer: dict[str, Any] | None = None
    refused: str | None = None
    revision: int | None = None
    """Where the journal has it, once a replay has come by."""


@dataclass
class Person:
    """An author: a token, a way to talk to the server, and what they asked for so far."""

    name: str
    token: str
    socket: bool
    rng: random.Random
    asked: list[Asked] = field(default_factory=list)
    waiting: Asked | None = None
    """Asked before the server died, without an answer; asked again first."""
    fault: BaseException | None = None
    away: int = 0
    """Edits that were answered with 503."""
    pause: float = 0.0
    """Seconds between an answer and the next edit."""

    def work(self, url: str, stop: threading.Event) -> None:
        """Edit until the server is gone or ``stop`` is set."""
        try:
            kind = SocketTalk if self.socket else RestTalk
            with kind(url, self.token) as talk:
                while not stop.is_set():
                    self._one(talk)
                    stop.wait(self.pause)
        except LOST:
            return
        except AwayError:  # as the socket was opened
            time.sleep(AWAY_SECONDS)
        except Exception as fault:
            self.fault = fault

    def _one(self, talk: RestTalk) -> None:
        asked = self.waiting
        if asked is None:
            self.waiting = asked = Asked(random_edit(self.rng, self.name, len(self.asked)))
            self.asked.append(asked)
        try:
            asked.answer = talk.do(asked.edit)
        except AwayError as why:
            asked.refused = str(why)
            self.away += 1
            time.sleep(AWAY_SECONDS)
        except RefusedError as why:
            asked.refused = str(why)
        self.waiting = None


def random_edit(rng: random.Random, author: str, number: int) -> Edit:
    """An edit as data; strokes are in the fields that REST takes."""
    kind = rng.choice(KINDS)
    edit: Edit = {"kind": kind, "id": str(uuid.UUID(int=rng.getrandbits(128), version=4))}
    if kind == "stroke":
        edit["frame"] = rng.randrange(FRAMES)
        edit["stroke"] = random_stroke(rng, edit["id"])
    elif kind == "create":
        edit["name"] = f"{author} {number}"
    elif kind in ("change", "remove"):
        edit["label"] = rng.randint(2, 8)
        flags = [{flag: value} for flag in ("locked", "visible") for value in (True, False)]
        edit["fields"] = rng.choice([{"name": f"{author} {number}"}, *flags])
    elif kind == "track":
        edit["start"], edit["stop"] = rng.choice([(0, 3), (1, 3), (3, 0)])
        edit["overwrite"] = rng.choice(["never", "tracked", "all"])
    return edit


def random_stroke(rng: random.Random, stroke_id: str) -> dict[str, Any]:
    samples = [
        {"origin": [rng.uniform(-0.4, 0.4), rng.uniform(-0.4, 0.4), rng.choice([1.0, 1.3])]}
        for _ in range(rng.randint(1, 3))
    ]
    tool = rng.choice(STROKES)
    return {
        "id": stroke_id,
        "label": rng.choice([1, 1, 2, 3]) if tool == "paint" else 0,
        "tool": tool,
        "shape": "sphere",
        "radius": rng.uniform(0.05, 0.3),
        "only_unlabeled": rng.random() < 0.2,
        "hidden": rng.choice([[], [], [], [0], [2], [1, 3]]),
        "samples": samples,
    }


class RestTalk:
    """Edits over REST."""

    def __init__(self, url: str, token: str) -> None:
        headers = {"Authorization": f"Bearer {token}"}
        self.api = httpx.Client(base_url=f"{url}/api/v1", headers=headers, timeout=PATIENCE)
        self.base = f"/sequences/{SEQUENCE}"

    def __enter__(self) -> RestTalk:
        return self

    def __exit__(self, *_: object) -> None:
        self.api.close()

    def call(self, method: str, path: str, **fields: Any) -> Any:
        response = self.api.request(method, path, **fields)
        if response.status_code == 503:
            raise AwayError(response.text)
        if response.status_code >= 500:
            raise AssertionError(f"{method} {path}: {response.status_code} {response.text}")
        if response.status_code >= 400:
            raise RefusedError(response.text)
        return response.json()

    def do(self, edit: Edit) -> dict[str, Any]:
        """The answer; raises RefusedError, or httpx.TransportError when the server died."""
        match edit["kind"]:
            case "stroke":
                path = f"{self.base}/frames/{edit['frame']}/strokes"
                return dict(self.call("POST", path, json=edit["stroke"]))
            case "undo" | "redo":
                path = f"{self.base}/{edit['kind']}"
                return dict(self.call("POST", path, json={"id": edit["id"]}))
            case "create":
                path, body = f"{self.base}/labels?edit={edit['id']}", {"name": edit["name"]}
                return {"label": self.call("POST", path, json=body)}
            case "change":
                path = f"{self.base}/labels/{edit['label']}?edit={edit['id']}"
                return {"label": self.call("PATCH", path, json=edit["fields"])}
            case "remove":
                path = f"{self.base}/labels/{edit['label']}?edit={edit['id']}"
                return dict(self.call("DELETE", path))
        return self.track(edit)

    def track(self, edit: Edit) -> dict[str, Any]:
        fields = {name: edit[name] for name in ("id", "start", "stop", "overwrite")}
        body = {**fields, "labels": [1], "method": "icp"}
        job = self.call("POST", f"{self.base}/tracking", json=body)
        while job["state"] not in ENDED:
            time.sleep(0.02)
            try:
                job = self.call("GET", f"/jobs/{job['id']}")
            except AwayError:
                time.sleep(AWAY_SECONDS)
        if job["state"] != "done" or job["result"]["edit"] is None:
            raise RefusedError(str(job["error"]))
        return dict(job["result"])


class SocketTalk(RestTalk):
    """Strokes, undo and redo over the socket; what the socket has no message for, over REST."""

    def __init__(self, url: str, token: str, name: str = "") -> None:
        """``name``: who this is, where the token does not say it."""
        super().__init__(url, token)
        self.socket: ClientConnection = connect(
            url.replace("http", "ws", 1) + "/api/v1/stream",
            additional_headers={"Authorization": f"Bearer {token}"},
            subprotocols=[subprotocol()],  # type: ignore[list-item]
            max_size=None,
            compression=None,
            close_timeout=0.2,
        )
        self.send(type="hello", name=name)
        self.until("welcome")
        self.send(type="open", sequence=SEQUENCE)
        self.until("sequence")

    def __exit__(self, *_: object) -> None:
        self.socket.close()
        super().__exit__()

    def send(self, **message: Any) -> None:
        self.socket.send(msgpack.packb(message))

    def until(self, kind: str, about: str | None = None) -> dict[str, Any]:
        """The message of this type (and final, about this id); raises RefusedError."""
        while True:
            message: dict[str, Any] = msgpack.unpackb(self.socket.recv(timeout=PATIENCE))
            if message["type"] == "frame":
                self.send(type="credit", frames=1)
            elif message["type"] == "error" and message["about"] == about:
                if message["status"] == 503:
                    raise AwayError(message["detail"])
                assert message["status"] < 500, message
                raise RefusedError(message["detail"])
            elif message["type"] == kind and (about is None or done(message, about)):
                return message

    def do(self, edit: Edit) -> dict[str, Any]:
        if edit["kind"] == "stroke":
            return self.stroke(edit)
        if edit["kind"] in ("undo", "redo"):
            self.send(type=edit["kind"], id=edit["id"])
            return self.until("stroke_result", edit["id"])
        return super().do(edit)

    def stroke(self, edit: Edit) -> dict[str, Any]:
        brush = {k: v for k, v in edit["stroke"].items() if k not in ("id", "samples")}
        self.send(type="stroke_begin", id=edit["id"], frame=edit["frame"], brush=brush)
        for sample in edit["stroke"]["samples"]:
            self.send(type="stroke_samples", id=edit["id"], samples=[sample])
        self.send(type="stroke_end", id=edit["id"])
        return self.until("stroke_result", edit["id"])


def done(message: dict[str, Any], about: str) -> bool:
    return bool(message["id"] == about and message["final"])
