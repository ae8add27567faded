"""The reference of REST, from the OpenAPI description: calls in groups, and their schemas."""

from __future__ import annotations

import json
import tempfile
import textwrap
from collections.abc import Iterator, Mapping
from contextlib import closing
from functools import cache
from http import HTTPStatus
from pathlib import Path
from typing import Any

from examples import EXCHANGES, WITHOUT_ONE

from pointbrush.settings import Settings
from pointbrush.web.app import create_app
from pointbrush.workspace import Workspace

GROUPS: dict[str, tuple[str, ...]] = {
    "Recordings": ("sequences", "imports", "export"),
    "Frames": ("frames", "annotations"),
    "Palette": ("labels", "taxonomy"),
    "Edits": ("edits", "objects"),
    "Tracking": ("tracking",),
    "Boxes": ("boxes",),
    "By example": ("classifiers",),
    "Review": ("review",),
    "Projects": ("projects", "tasks", "agreement", "snapshots", "webhooks"),
    "People": ("accounts",),
    "Studies": ("studies",),
    "Headset checks": ("headset checks",),
    "Server and jobs": ("server", "jobs"),
}
"""Pages, and the tags of the calls on each."""
WIDTH = 76
"""Characters in a line of an example, which a window of 1280 pixels shows whole."""


@cache
def description() -> dict[str, Any]:
    """Return the OpenAPI description of a server."""
    with tempfile.TemporaryDirectory() as folder:
        settings = Settings(workspace=Path(folder) / "workspace")
        with closing(Workspace(settings)) as workspace:
            found: dict[str, Any] = create_app(workspace, settings).openapi()
    return found


def overview() -> str:
    """Return tables of all calls, which follow the introduction in ``docs/reference/rest.md``."""
    lines = [""]
    for title, tags in GROUPS.items():
        lines += [f"## [{title}](rest/{_name(title)}.md)", "", "| call | does |", "|---|---|"]
        calls = _of_tags(description(), tags)
        lines += [f"| `{call}` | {_cell(_first(about))} |" for call, about in calls]
        lines.append("")
    return "\n".join([*lines, "The bodies and answers have [schemas](rest/schemas.md)."])


def pages() -> dict[str, str]:
    """Return the pages of the groups and of the schemas, by their places."""
    exchanges = json.loads(EXCHANGES.read_text(encoding="utf-8"))
    schemas = description()["components"]["schemas"]
    made = {"reference/rest/schemas.md": "\n".join(_schemas(schemas))}
    for title, tags in GROUPS.items():
        parts = [f"# REST: {title.lower()}", ""]
        for call, about in _of_tags(description(), tags):
            parts += _call(call, about, exchanges.get(call, {}))
        made[f"reference/rest/{_name(title)}.md"] = "\n".join(parts)
    return made


def _name(title: str) -> str:
    return title.lower().replace(" ", "-")


def _of_tags(
    described: Mapping[str, Any], tags: tuple[str, ...]
) -> Iterator[tuple[str, dict[str, Any]]]:
    for path, verbs in described["paths"].items():
        for verb, call in verbs.items():
            if (call.get("tags") or ["server"])[0] in tags:
                yield f"{verb.upper()} {path}", call


def _first(call: Mapping[str, Any]) -> str:
    return str(call.get("description", call.get("summary", ""))).split("\n\n")[0]


def _call(title: str, call: dict[str, Any], exchange: dict[str, Any]) -> Iterator[str]:
    yield from (f"## `{title}`", "", call.get("description", call.get("summary", "")), "")
    parameters = [each for each in call.get("parameters", []) if each["in"] != "path"]
    rows = [
        (f"`{each['name']}` ({each['in']})", _kind(each["schema"]), _meaning(each))
        for each in parameters
    ]
    content = call.get("requestBody", {}).get("content", {})
    rows += [
        (f"body, `{kind}`", _kind(each["schema"]), _about(each["schema"]))
        for kind, each in content.items()
    ]
    rows += [
        (
            f"answer {status}, `{kind}`",
            _kind(each["schema"]),
            _about(each["schema"]) or answer["description"],
        )
        for status, answer in call["responses"].items()
        if status.startswith("2")
        for kind, each in answer.get("content", {}).items()
    ]
    if rows:
        yield from ("| part | type | meaning |", "|---|---|---|")
        yield from (f"| {' | '.join(map(_cell, row))} |" for row in rows)
        yield ""
    if exchange:
        yield from _exchange(title.split()[0], exchange, list(content))
    elif title in WITHOUT_ONE:
        yield from (WITHOUT_ONE[title], "")


def _meaning(parameter: Mapping[str, Any]) -> str:
    """Return the description of a parameter, and the meanings of its values."""
    schema = parameter["schema"]
    parts = (parameter, schema, *schema.get("anyOf", []))
    return " ".join(dict.fromkeys(part["description"] for part in parts if "description" in part))


def _about(schema: dict[str, Any]) -> str:
    """Return the first paragraph about a body or an answer."""
    schema = schema.get("items", schema)
    if "$ref" in schema:
        name = schema["$ref"].rsplit("/", 1)[-1]
        schema = description()["components"]["schemas"][name]
    return str(schema.get("description", "")).split("\n\n")[0]


def _exchange(verb: str, exchange: dict[str, Any], kinds: list[str]) -> Iterator[str]:
    """Write a request and its answer as they went over the wire."""
    status = HTTPStatus(exchange["status"])
    yield from ("```http", f"{verb} {exchange['target']} HTTP/1.1", "Authorization: Bearer TOKEN")
    if "request" in exchange:
        yield from ("Content-Type: application/json", "", _json(exchange["request"]))
    elif kinds:
        yield f"Content-Type: {kinds[-1]}"
    yield from ("```", "", "```http", f"HTTP/1.1 {status.value} {status.phrase}")
    if "answer" in exchange:
        yield from ("Content-Type: application/json", "", _json(exchange["answer"]))
    yield from ("```", "")


def _json(value: Any, indent: str = "") -> str:
    """Return JSON in lines of at most ``WIDTH`` characters, except longer texts."""
    short = json.dumps(value, ensure_ascii=False)
    if len(indent) + len(short) <= WIDTH or not isinstance(value, dict | list):
        return short
    inner = indent + "  "
    if isinstance(value, dict):
        lines = [f"{json.dumps(name)}: {_json(each, inner)}" for name, each in value.items()]
    elif any(isinstance(each, dict | list) for each in value):
        lines = [_json(each, inner) for each in value]
    else:
        return textwrap.fill(short, WIDTH, subsequent_indent=indent + " ", break_long_words=False)
    opening, closing = "{}" if isinstance(value, dict) else "[]"
    return f"{opening}\n{inner}" + f",\n{inner}".join(lines) + f"\n{indent}{closing}"


def _schemas(schemas: Mapping[str, Any]) -> Iterator[str]:
    yield from ("# REST: schemas", "", "Fields that are not required have a default.", "")
    for name, schema in sorted(schemas.items(), key=lambda each: _short(each[0])):
        yield from (f"## {_short(name)} {{#{name}}}", "", schema.get("description", ""), "")
        required = schema.get("required", [])
        yield from ("| field | type | default | meaning |", "|---|---|---|---|")
        for field, about in schema.get("properties", {}).items():
            given = f"`{json.dumps(about['default'])}`" if "default" in about else "none"
            default = "required" if field in required else given
            row = (f"`{field}`", _bounded(about), default, about.get("description", ""))
            yield f"| {' | '.join(map(_cell, row))} |"
        yield ""


def _short(name: str) -> str:
    """Return a schema's name; one that several modules have says its module."""
    *modules, last = name.split("__")
    return f"{last} ({modules[-1]})" if modules else last


def _bounded(schema: dict[str, Any]) -> str:
    """Return a schema in a few words, with the bounds of its values."""
    signs = {"minimum": "≥", "exclusiveMinimum": ">", "maximum": "≤", "exclusiveMaximum": "<"}
    bounds = [f"{sign} {schema[key]:g}" for key, sign in signs.items() if key in schema]
    return " ".join([_kind(schema), ", ".join(bounds)]).strip()


def _kind(schema: dict[str, Any]) -> str:
    """Return a schema in a few words."""
    if "$ref" in schema:
        name = schema["$ref"].rsplit("/", 1)[-1]
        return f"[{_short(name)}](schemas.md#{name})"
    for several in ("anyOf", "oneOf", "allOf"):
        if several in schema:
            return " or ".join(dict.fromkeys(map(_kind, schema[several])))
    if "enum" in schema:
        return ", ".join(f"`{each}`" for each in schema["enum"])
    if schema.get("type") == "array":
        return f"list of {_kind(schema.get('items', {}))}"
    if schema.get("type") == "object":
        fields = schema.get("properties", {})
        return ", ".join(f"`{name}`" for name in fields) or "object"
    return str(schema.get("format") or schema.get("type") or "any")


def _cell(text: str) -> str:
    return text.replace("\n", " ").replace("|", "\\|")
