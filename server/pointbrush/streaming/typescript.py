"""Write the page's types of messages and values of REST from their definitions.

``python -m pointbrush.streaming.typescript --write`` writes ``messages.ts`` and ``values.ts`` in
``webxr_client/src/protocol``; ``--check`` fails when one is stale.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Set
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from pointbrush.streaming.schema import client_schema, schema_hash, server_schema
from pointbrush.values.base import Body
from pointbrush.values.classes import value_classes

TARGET = Path(__file__).parents[3] / "webxr_client" / "src" / "protocol"
WRITE = "python -m pointbrush.streaming.typescript --write"
LONGEST_TUPLE = 8
IMPORT = re.compile(r"import type \{([^}]*)\} from '[^']*/values'")
SCALARS = {"integer": "number", "number": "number", "boolean": "boolean", "null": "null"}

Schema = dict[str, Any]


def generate() -> dict[str, str]:
    """Return the TypeScript modules by name, each ending in a newline."""
    return {"messages.ts": messages(), "values.ts": values(imported())}


def imported(sources: Path = TARGET.parent) -> set[str]:
    """Return the names of values that the page's modules import."""
    found: set[str] = set()
    for file in sources.rglob("*.ts*"):
        for names in IMPORT.findall(file.read_text(encoding="utf-8")):
            found.update(name.split()[0] for name in names.split(",") if name.strip())
    return found


def values(names: Set[str]) -> str:
    """Return interfaces of REST's values with these names, and of the values inside them.

    Optional fields of bodies may be left out.
    """
    schemas = {
        kind: TypeAdapter(kind).json_schema(mode="serialization") for kind in value_classes()
    }
    inside = {
        name
        for kind, schema in schemas.items()
        if kind.__name__ in names
        for name in schema.get("$defs", ())
    }
    parts = [
        f"// Generated from values/ of server/pointbrush by\n// `{WRITE}`.\n"
        "// Do not edit: a stale file fails the tests.\n"
    ]
    for kind, schema in schemas.items():
        if kind.__name__ in names | inside:
            complete = not issubclass(kind, Body)
            parts.append(interface(kind.__name__, schema, complete=complete, fixed=True))
    return "\n".join(parts)


def messages() -> str:
    """Return the types of messages."""
    client, server = client_schema(), server_schema()
    parts = [
        "// Generated from streaming/messages/ of server/pointbrush by\n"
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
    parts.append(union("ClientMessage", client))
    parts.append(union("ServerMessage", server))
    return "\n".join(parts)


def interface(name: str, definition: Schema, *, complete: bool, fixed: bool = False) -> str:
    """Return a model as an ``export interface``; ``complete``: the sender fills in every field.

    ``fixed``: the fields and their arrays are ``readonly``.
    """
    readonly = "readonly " if fixed else ""
    required = set(definition.get("required", ()))
    lines = [*comment(definition, ""), f"export interface {name} {{"]
    for field, schema in definition["properties"].items():
        lines += comment(schema, "  ")
        sent = (complete and not schema.get("omitted")) or field in required or field == "type"
        kind = type_of(schema, readonly)
        lines.append(f"  {readonly}{field}{'' if sent else '?'}: {kind};")
    return "\n".join([*lines, "}\n"])


def type_of(schema: Schema, readonly: str = "") -> str:
    """Return a JSON schema as a TypeScript type; raise ValueError for an unsupported schema.

    ``readonly``: prefix of arrays.
    """
    if "$ref" in schema:
        return str(schema["$ref"]).rpartition("/")[2]
    if "const" in schema:
        return quoted(schema["const"])
    if "enum" in schema:
        return " | ".join(quoted(value) for value in schema["enum"])
    if "anyOf" in schema:
        return " | ".join(dict.fromkeys(type_of(option, readonly) for option in schema["anyOf"]))
    kind = schema.get("type")
    if kind == "array":
        return readonly + array_of(schema, readonly)
    if kind == "object":
        return record_of(schema, readonly)
    if kind == "string":
        return "Uint8Array" if schema.get("format") == "binary" else "string"
    if kind in SCALARS:
        return SCALARS[kind]
    raise ValueError(f"expected a schema that TypeScript can express, got {schema}")


def record_of(schema: Schema, readonly: str) -> str:
    """Return an object with values of one type; with known names, it may have some of them."""
    patterns = schema.get("patternProperties", {}).values()
    value = next(iter(patterns), schema.get("additionalProperties"))
    kind = type_of(value, readonly) if isinstance(value, dict) else "unknown"
    names = schema.get("propertyNames", {})
    if "enum" in names:
        return f"Readonly<Partial<Record<{type_of(names)}, {kind}>>>"
    return f"Readonly<Record<string, {kind}>>" if readonly else f"Record<string, {kind}>"


def array_of(schema: Schema, readonly: str = "") -> str:
    """Return a short array of fixed length as a tuple, any other as a plain array."""
    if "prefixItems" in schema:
        return "[" + ", ".join(type_of(each, readonly) for each in schema["prefixItems"]) + "]"
    item = type_of(schema["items"], readonly)
    length = schema.get("minItems")
    if length is not None and length == schema.get("maxItems") and length <= LONGEST_TUPLE:
        return "[" + ", ".join([item] * length) + "]"
    return f"({item})[]" if " " in item else f"{item}[]"


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
    """Exit 0 when the files are (now) up to date, 1 when ``--check`` finds a stale one."""
    parser = argparse.ArgumentParser(description=__doc__)
    mode = parser.add_mutually_exclusive_group(required=True)
    mode.add_argument("--write", action="store_true", help="write the files")
    mode.add_argument("--check", action="store_true", help="fail when a file is stale")
    parser.add_argument(
        "--target", type=Path, default=TARGET, help="their folder (default: %(default)s)"
    )
    options = parser.parse_args(arguments)
    stale = 0
    for name, text in generate().items():
        file: Path = options.target / name
        if options.write:
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        elif not file.is_file() or file.read_text(encoding="utf-8") != text:
            print(f"{file} is stale: run `{WRITE}`", file=sys.stderr)
            stale = 1
    return stale


if __name__ == "__main__":
    raise SystemExit(main())
