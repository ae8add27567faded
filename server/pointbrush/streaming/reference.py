"""Write the pages of messages from the models.

``python -m pointbrush.streaming.reference`` writes them; a test fails when one is stale.
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

from pointbrush.streaming.schema import client_schema, schema_hash, server_schema
from pointbrush.streaming.typescript import type_of

TARGET = Path(__file__).parents[3] / "docs"
SOURCES = Path(__file__).parent / "messages"
HEAD = """# {title}

This page lists the fields of each message; [protocol.md](protocol.md) describes a session.  The
pages are: messages from the [client](messages.md), messages from the [server](messages-server.md),
and [pieces](messages-pieces.md) of both.  Types are TypeScript's; `?` marks an optional field.
Bytes are little-endian.  The subprotocol is `pointbrush.{hash}`.

`python -m pointbrush.streaming.reference` writes the pages from
`server/pointbrush/streaming/messages/`.
"""


def generate() -> dict[str, str]:
    """Return the pages by their names, each ending in a newline."""
    client, server = client_schema(), server_schema()
    used = {_name(option) for schema in (client, server) for option in schema["oneOf"]}
    shared = {**server["$defs"], **client["$defs"]}
    pieces = [_section(name, shared[name], complete=False) for name in sorted(shared.keys() - used)]
    pages = {
        "messages.md": ("Messages from the client", _messages(client, complete=False)),
        "messages-server.md": ("Messages from the server", _messages(server, complete=True)),
        "messages-pieces.md": ("Pieces of messages", pieces),
    }
    return {
        name: "\n".join([HEAD.format(title=title, hash=schema_hash()), *parts]).rstrip() + "\n"
        for name, (title, parts) in pages.items()
    }


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
    lines = [f"## {title}", "", _prose(definition.get("description", "")), ""]
    notes = _notes(definition["title"])
    for name, schema in definition["properties"].items():
        if name == "type":
            continue
        kind = type_of(schema)
        if not (complete or name in required):
            name, kind = f"{name}?", kind + _default(schema)
        note = _prose(schema.get("description") or notes.get(name.rstrip("?"), ""))
        lines.append(f"- `{name}: {kind}`" + (f": {note}" if note else ""))
    return "\n".join([*lines, ""])


def _notes(name: str) -> dict[str, str]:
    """Return the docstrings of a model's fields; a generated model has them in its schema."""
    for path in SOURCES.glob("*.py"):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef) and node.name == name:
                return dict(_documented(node))
    return {}


def _documented(model: ast.ClassDef) -> Iterator[tuple[str, str]]:
    for field, note in pairwise(model.body):
        match field, note:
            case (
                ast.AnnAssign(target=ast.Name(id=name)),
                ast.Expr(value=ast.Constant(value=str(text))),
            ):
                yield name, text


def _default(schema: dict[str, Any]) -> str:
    """Return the default of an optional field, or nothing if the default is empty."""
    default = schema.get("default")
    return f" = {json.dumps(default)}" if default not in (None, "", []) else ""


def _prose(text: str) -> str:
    """Return the Markdown of a docstring."""
    line = re.sub(r"\s*\n\s*", " ", text.strip()).replace("``", "`")
    return re.sub(r"docs/([\w-]+\.md)", r"[\1](\1)", line)


def main() -> None:
    """Write the files."""
    for name, text in generate().items():
        (TARGET / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
