"""Writes the page's types of messages and reports from the models: the two never drift apart.

``python -m pointbrush.streaming.typescript --write`` writes ``webxr_client/src/protocol/
messages.ts``; ``--check`` fails when the file is stale.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from pointbrush.headset_report.model import HeadsetReport
from pointbrush.streaming.schema import client_schema, schema_hash, server_schema

TARGET = Path(__file__).parents[3] / "webxr_client" / "src" / "protocol" / "messages.ts"
WRITE = "python -m pointbrush.streaming.typescript --write"
LONGEST_TUPLE = 8
SCALARS = {"integer": "number", "number": "number", "boolean": "boolean", "null": "null"}

Schema = dict[str, Any]


def generate() -> str:
    """Return the whole TypeScript module, ending in a newline."""
    client, server, report = client_schema(), server_schema(), HeadsetReport.model_json_schema()
    parts = [
        "// Generated from streaming/messages/ and headset_report/ of server/pointbrush by\n"
        f"// `{WRITE}`.\n"
        "// Do not edit: a stale file fails the tests.\n",
        f"export const SCHEMA_HASH = '{schema_hash()}';\n"
        "export const SUBPROTOCOL = `pointbrush.${SCHEMA_HASH}`;\n",
    ]
    written: set[str] = set()
    for schema, complete in ((client, False), (server, True)):
        for name, definition in sorted(schema["$defs"].items()):
            if name not in written:
                parts.append(interface(name, definition, complete=complete))
                written.add(name)
    for name, definition in sorted((report["$defs"] | {"HeadsetReport": report}).items()):
        parts.append(interface(name, definition, complete=True))
    parts.append(union("ClientMessage", client))
    parts.append(union("ServerMessage", server))
    return "\n".join(parts)


def interface(name: str, definition: Schema, *, complete: bool) -> str:
    """Return a model as an ``export interface``; ``complete``: the sender fills in every field."""
    required = set(definition.get("required", ()))
    lines = [*comment(definition, ""), f"export interface {name} {{"]
    for field, schema in definition["properties"].items():
        lines += comment(schema, "  ")
        sent = complete or field in required or field == "type"
        lines.append(f"  {field}{'' if sent else '?'}: {type_of(schema)};")
    return "\n".join([*lines, "}\n"])


def type_of(schema: Schema) -> str:
    """Return a JSON schema as a TypeScript type; raise ValueError for an unsupported schema."""
    if "$ref" in schema:
        return str(schema["$ref"]).rpartition("/")[2]
    if "const" in schema:
        return quoted(schema["const"])
    if "enum" in schema:
        return " | ".join(quoted(value) for value in schema["enum"])
    if "anyOf" in schema:
        return " | ".join(dict.fromkeys(type_of(option) for option in schema["anyOf"]))
    kind = schema.get("type")
    if kind == "array":
        return array_of(schema)
    if kind == "object" and "additionalProperties" in schema:
        return f"Record<string, {type_of(schema['additionalProperties'])}>"
    if kind == "string":
        return "Uint8Array" if schema.get("format") == "binary" else "string"
    if kind in SCALARS:
        return SCALARS[kind]
    raise ValueError(f"expected a schema that TypeScript can express, got {schema}")


def array_of(schema: Schema) -> str:
    """Return a short array of fixed length as a tuple, any other as a plain array."""
    item = type_of(schema["items"])
    length = schema.get("minItems")
    if length is not None and length == schema.get("maxItems") and length <= LONGEST_TUPLE:
        return "[" + ", ".join([item] * length) + "]"
    return f"({item})[]" if "|" in item else f"{item}[]"


def union(name: str, schema: Schema) -> str:
    """Return the union of the messages of one side, discriminated by ``type``."""
    members = [type_of(option) for option in schema["oneOf"]]
    return "\n".join([f"export type {name} =", *(f"  | {member}" for member in members)]) + ";\n"


def comment(schema: Schema, indent: str) -> list[str]:
    """Return the description as the lines of a JSDoc block, or no lines."""
    text = schema.get("description")
    if not text:
        return []
    lines = str(text).strip().splitlines()
    if len(lines) == 1:
        return [f"{indent}/** {lines[0]} */"]
    body = [f"{indent} * {line}".rstrip() for line in lines]
    return [f"{indent}/**", *body, f"{indent} */"]


def quoted(value: object) -> str:
    """Return a string literal as prettier writes it."""
    return f"'{value}'" if isinstance(value, str) else str(value)


def main(arguments: list[str] | None = None) -> int:
    """Exit 0 when the file is (now) up to date, 1 when ``--check`` finds it stale."""
    parser = argparse.ArgumentParser(description=__doc__)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--write", action="store_true", help="write the file")
    what.add_argument("--check", action="store_true", help="fail when the file is stale")
    parser.add_argument(
        "--target", type=Path, default=TARGET, help="the file (default: %(default)s)"
    )
    options = parser.parse_args(arguments)
    text = generate()
    target: Path = options.target
    if options.write:
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
        return 0
    if not target.is_file() or target.read_text(encoding="utf-8") != text:
        print(f"{target} is stale: run `{WRITE}`", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
