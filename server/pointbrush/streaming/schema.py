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
    """Return the JSON schema of a page's messages; fields with a default are optional."""
    return TypeAdapter[Any](ClientMessage).json_schema(mode="validation")


def server_schema() -> dict[str, Any]:
    """Return the JSON schema of the server's messages; every field is present."""
    return TypeAdapter[Any](ServerMessage).json_schema(mode="serialization")


@cache
def schema_hash() -> str:
    """Return 12 hexadecimal digits that change with any message, field, type or limit.

    Titles and descriptions are left out, so that a page stays valid if only their wording changes.
    """
    shape = [_without_prose(client_schema()), _without_prose(server_schema())]
    text = json.dumps(shape, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def subprotocol() -> str:
    """Return the WebSocket subprotocol of page and server."""
    return SUBPROTOCOL_PREFIX + schema_hash()


def _without_prose(node: Any, *, names: bool = False) -> Any:
    """Remove ``title`` and ``description`` of schemas, but keep fields of these names."""
    if isinstance(node, dict):
        return {
            key: _without_prose(value, names=key in ("properties", "$defs") and not names)
            for key, value in node.items()
            if names or key not in ("title", "description")
        }
    if isinstance(node, list):
        return [_without_prose(item) for item in node]
    return node
