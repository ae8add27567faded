"""Writes docs/protocol.md from the models, so that what is written is what is spoken.

``python -m pointbrush.streaming.reference`` writes it; a test fails when it is stale.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from pointbrush.streaming.schema import client_schema, schema_hash, server_schema
from pointbrush.streaming.typescript import type_of

TARGET = Path(__file__).parents[3] / "docs" / "protocol.md"
HEAD = """# The socket's messages

Written from `server/pointbrush/streaming/messages/` by
`python -m pointbrush.streaming.reference`.

`GET /api/v1/stream` as a WebSocket, with the subprotocol `pointbrush.{hash}` (it changes with any
message, so that a stale page is refused instead of misread), a bearer token or the page's cookie,
and no compression.  Each message is one binary msgpack map with `type`; bytes are little-endian.
Points are numbered in stored order: level by level, a prefix of a frame is the frame decimated.
How the messages play together is told in [streaming.md](streaming.md).

A message that cannot be used is answered with `error`, and the session goes on; one that is too
large closes the socket with 1009, text with 1003, the server's end with 1001.
"""


def generate() -> str:
    """The whole page, ending in a newline."""
    client, server = client_schema(), server_schema()
    parts = [HEAD.format(hash=schema_hash())]
    parts += ["## From the client", *_messages(client, complete=False)]
    parts += ["## From the server", *_messages(server, complete=True)]
    used = {_name(option) for schema in (client, server) for option in schema["oneOf"]}
    shared = {**server["$defs"], **client["$defs"]}
    parts.append("## Shared pieces")
    for name in sorted(shared.keys() - used):
        parts.append(_section(name, shared[name], complete=False))
    return "\n".join(parts).rstrip() + "\n"


def _name(option: dict[str, Any]) -> str:
    return str(option["$ref"]).rpartition("/")[2]


def _messages(schema: dict[str, Any], *, complete: bool) -> list[str]:
    definitions = [schema["$defs"][_name(option)] for option in schema["oneOf"]]
    return [
        _section(definition["properties"]["type"]["const"], definition, complete=complete)
        for definition in definitions
    ]


def _section(title: str, definition: dict[str, Any], *, complete: bool) -> str:
    required = set(definition.get("required", ()))
    lines = [f"### {title}", "", _prose(definition.get("description", "")), ""]
    fields = {k: v for k, v in definition["properties"].items() if k != "type"}
    if fields:
        lines += ["| field | type | |", "|---|---|---|"]
    for name, schema in fields.items():
        note = "" if complete or name in required else "may be left out"
        note = "; ".join(filter(None, (note, _prose(schema.get("description", "")))))
        kind = type_of(schema).replace("|", "\\|")
        lines.append(f"| `{name}` | `{kind}` | {note} |")
    return "\n".join([*lines, ""])


def _prose(text: str) -> str:
    """Docstrings' markup as Markdown's."""
    return re.sub(r"\s*\n\s*", " ", text.strip()).replace("``", "`").replace("|", "\\|")


def main() -> None:
    """Write the file."""
    TARGET.write_text(generate(), encoding="utf-8")


if __name__ == "__main__":
    main()
