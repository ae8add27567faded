"""The server's log as lines of JSON: requests, edits and jobs with their ids, never a token."""

from __future__ import annotations

import json
import logging
import re
import secrets
import time
from collections.abc import Callable, MutableMapping
from contextvars import ContextVar
from datetime import UTC, datetime
from typing import Any

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from pointbrush.database.job import Job
from pointbrush.labels import Commit
from pointbrush.web.problems import loggable
from pointbrush.work.events import Event
from pointbrush.workspace import Workspace

FORMATS = ("text", "json")
SECRET = re.compile(r"(?i)(token=|bearer\s+|pointbrush_(?:session|account|oidc)\w*=)[^\s&\"';,]+")
LONGEST_METHOD = 20
"""Characters of a request's method that are logged."""
HIDDEN = "[hidden]"
REQUEST_ID = re.compile(r"[\w.-]{1,64}", re.ASCII)
MORE = ("method", "path", "status", "milliseconds", "edit", "job", "sequence", "revision", "state")
"""Fields of a line besides its message; each is an attribute of the record."""

log = logging.getLogger(__name__)
request_id: ContextVar[str] = ContextVar("request_id", default="")


class JsonFormatter(logging.Formatter):
    """Formats a record as one line of JSON without tokens."""

    def __init__(self, *hidden: str) -> None:
        """``hidden``: secrets that are removed from every line."""
        super().__init__()
        self._hidden = [secret for secret in hidden if secret]

    def format(self, record: logging.LogRecord) -> str:
        """Return the line."""
        line: dict[str, Any] = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
        }
        if request := request_id.get():
            line["request"] = request
        line |= {name: getattr(record, name) for name in MORE if hasattr(record, name)}
        if record.exc_info:
            line["exception"] = self.formatException(record.exc_info)
        return json.dumps({name: self._shown(value) for name, value in line.items()})

    def _shown(self, value: Any) -> Any:
        if not isinstance(value, str):
            return value
        for secret in self._hidden:
            value = value.replace(secret, HIDDEN)
        return SECRET.sub(rf"\1{HIDDEN}", value)


class RequestLog:
    """ASGI layer that gives each request an id and logs its answer."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Call the app, then log; keep the request id of a proxy."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        given = dict(scope["headers"]).get(b"x-request-id", b"").decode("ascii", "replace")
        known = given if REQUEST_ID.fullmatch(given) else secrets.token_hex(8)
        mark, begun = request_id.set(known), time.monotonic()
        status = 0

        async def with_id(message: Message) -> None:
            nonlocal status
            if message["type"] in ("http.response.start", "websocket.http.response.start"):
                status = message["status"]
                headers: MutableMapping[str, Any] = message
                headers["headers"] = [*message["headers"], (b"x-request-id", known.encode())]
            await send(message)

        try:
            await self.app(scope, receive, with_id)
        finally:
            fields = {
                "method": scope.get("method", "WEBSOCKET")[:LONGEST_METHOD],
                "path": loggable(scope["path"]),
                "known": scope.get("state", {}).get("known", False),
                "milliseconds": round(1000 * (time.monotonic() - begun), 1),
            }
            log.info("answered", extra=fields | ({"status": status} if status else {}))
            request_id.reset(mark)


def write_json(*hidden: str) -> None:
    """Log on stderr as lines of JSON; ``hidden`` as of ``JsonFormatter``."""
    handler = logging.StreamHandler()
    handler.setFormatter(JsonFormatter(*hidden))
    root = logging.getLogger()
    root.handlers[:] = [handler]
    logging.getLogger("pointbrush").setLevel(logging.INFO)


def log_events(workspace: Workspace) -> Callable[[], None]:
    """Log edits and new states of jobs from now on; return a function that ends it."""
    states: dict[str, str] = {}

    def log_event(event: Event) -> None:
        if isinstance(event, Commit):
            fields = {"edit": event.edit, "revision": event.revision, "sequence": event.sequence}
            log.info("edit %s", event.kind, extra=fields)
        elif isinstance(event, Job) and states.get(event.id) != event.state:
            states[event.id] = event.state
            fields = {"job": event.id, "state": event.state, "sequence": event.sequence}
            edit_field = {"edit": event.edit} if event.edit else {}
            log.info("job %s", event.kind, extra=fields | edit_field)
            if event.state in ("done", "failed", "cancelled"):
                del states[event.id]

    return workspace.subscribe(log_event)
