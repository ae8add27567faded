"""The answer to connections that are too many: in words, and then they are closed."""

from __future__ import annotations

from starlette.types import Receive, Scope, Send

from pointbrush.web.problems import problem


async def too_many_connections(scope: Scope, receive: Receive, send: Send) -> None:
    """Answer any request; an ASGI application."""
    detail = "the server has as many connections as it may; try again when one has ended"
    headers = {"Connection": "close"}
    await problem(503, detail, "Temporarily unavailable", headers)(scope, receive, send)
