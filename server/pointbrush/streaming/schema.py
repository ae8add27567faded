"""The schema of every message of the WebSocket, and the hash that names it in the subprotocol."""

from __future__ import annotations

import hashlib
import json
from functools import cache
from typing import Any

from pydantic import TypeAdapter

from pointbrush.streaming.messages import ClientMessage, ServerMessage

SUBPROTOCOL_PREFIX = "pointbrush."


def client_schema() -> dict[str, Any]:
    """JSON schema of what a page may send: fields with a default may be left out."""
    return TypeAdapter[Any](ClientMessage).json_schema(mode="validation")


def server_schema() -> dict[str, Any]:
    """JSON schema of what the server sends: every field is there."""
    return TypeAdapter[Any](ServerMessage).json_schema(mode="serialization")


@cache
def schema_hash() -> str:
    """12 hexadecimal digits that change with any message, field, type or limit.

    Titles and descriptions are left out, so that better wording does not refuse a page.
    """
    shape = [_without_prose(client_schema()), _without_prose(server_schema())]
    text = json.dumps(shape, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def subprotocol() -> str:
    """The WebSocket subprotocol that page and server agree on."""
    return SUBPROTOCOL_PREFIX + schema_hash()


def _without_prose(node: Any, *, names: bool = False) -> Any:
    """Drop ``title`` and ``description`` of schemas, but not fields that are called so."""
    if isinstance(node, dict):
        return {
            key: _without_prose(value, names=key in ("properties", "$defs") and not names)
            for key, value in node.items()
            if names or key not in ("title", "description")
        }
    if isinstance(node, list):
        return [_without_prose(item) for item in node]
    return node
