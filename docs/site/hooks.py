"""Pages of the site that are written from the program, and files above docs/."""

from __future__ import annotations

import argparse
import re
import tempfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from pointbrush import client
from pointbrush.cli import parser
from pointbrush.settings import Settings
from pointbrush.web.app import create_app
from pointbrush.workspace import Workspace

ROOT = Path(__file__).parents[2]


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are no files of docs/."""
    pages = {
        "reference/cli.md": command_line(),
        "reference/rest.md": rest(),
        "reference/python.md": python(),
        "reference/changelog.md": above("CHANGELOG.md"),
        "explanation/architecture.md": above("ARCHITECTURE.md"),
    }
    for place, text in pages.items():
        files.append(File.generated(config, place, content=text))
    return files


def above(name: str) -> str:
    """Return a page of the repository's top, whose links into docs/ lead to the site's pages."""
    text = (ROOT / name).read_text(encoding="utf-8")
    return re.sub(r"\]\(docs/", "](../", text)


PYTHON = """# The Python client

`Client` blocks; `AsyncClient` has the same calls as coroutines. A method that says `Steps[T]` here
returns a `T`, which `AsyncClient` awaits. Examples are in [scripting](../scripting.md).

::: pointbrush.client.Client
    options:
      inherited_members: true

::: pointbrush.client.AsyncClient

PARTS

## Errors
What a server refuses raises the error that its problem names.

::: pointbrush.errors
    options:
      show_root_heading: false
"""


def python() -> str:
    """Return the reference of the client, class by class."""
    parts = [name for name in client.__all__ if not name.endswith("Client")]
    return PYTHON.replace("PARTS", "\n\n".join(f"::: pointbrush.client.{name}" for name in parts))


def command_line() -> str:
    """Return the reference of all commands, from the parser."""
    lines = ["# The command line", "", "What the flags mean in full: [options](../options.md).", ""]
    for name, command in _commands(parser()):
        lines += [f"## pointbrush {name}", "", f"{_sentence(command.description or name)}", ""]
        usage = command.format_usage().removeprefix("usage: ").rstrip()
        lines += ["```text", re.sub(r"\s*\n\s*", "\n    ", usage), "```", ""]
        lines += ["| argument | meaning |", "|---|---|", *_arguments(command), ""]
    return "\n".join(lines)


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}."


def _commands(top: argparse.ArgumentParser) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    for action in top._actions:
        if isinstance(action, argparse._SubParsersAction):
            yield from action.choices.items()


def _arguments(command: argparse.ArgumentParser) -> Iterator[str]:
    for action in command._actions:
        if isinstance(action, argparse._HelpAction):
            continue
        names = ", ".join(f"`{flag}`" for flag in action.option_strings)
        metavar = action.metavar or action.dest.upper()
        shown = names or f"`{metavar if isinstance(metavar, str) else ' '.join(metavar)}`"
        if action.choices:
            shown += f" ({', '.join(map(str, action.choices))})"
        yield f"| {_cell(shown)} | {_cell(action.help or '')} |"


def rest() -> str:
    """Return the reference of all calls, from the OpenAPI description."""
    with tempfile.TemporaryDirectory() as folder:
        settings = Settings(workspace=Path(folder) / "workspace")
        with closing(Workspace(settings)) as workspace:
            described = create_app(workspace, settings).openapi()
    lines = [
        "# REST",
        "",
        "Every call is below the server's address. A running server shows the same with all",
        "schemas at `/api/v1/docs`, and as OpenAPI at `/api/v1/openapi.json`. Errors are",
        "`application/problem+json`.",
        "The role that a call needs: [security](../security.md#roles).",
        "",
    ]
    groups: dict[str, list[str]] = {}
    for path, verbs in described["paths"].items():
        for verb, call in verbs.items():
            group = groups.setdefault((call.get("tags") or ["server"])[0], [])
            group += _call(f"{verb.upper()} {path}", call)
    for tag, group in groups.items():
        lines += [f"## {tag.capitalize()}", "", *group]
    return "\n".join(lines)


def _call(title: str, call: dict[str, Any]) -> Iterator[str]:
    yield from (f"### `{title}`", "", call.get("description", call.get("summary", "")), "")
    parameters = [each for each in call.get("parameters", []) if each["in"] != "path"]
    rows = [
        (f"`{each['name']}` ({each['in']})", each.get("description", ""), _kind(each["schema"]))
        for each in parameters
    ]
    content = call.get("requestBody", {}).get("content", {})
    rows += [(f"body `{kind}`", "", _kind(each["schema"])) for kind, each in content.items()]
    answers = [
        f"{status}: {kind.rsplit('/', 1)[-1]} {_kind(each['schema'])}"
        for status, answer in call["responses"].items()
        if status.startswith("2")
        for kind, each in answer.get("content", {}).items()
    ]
    rows += [("answer", "", answer) for answer in answers]
    if rows:
        yield from ("| part | meaning | type |", "|---|---|---|")
        yield from (f"| {' | '.join(map(_cell, row))} |" for row in rows)
        yield ""


def _kind(schema: dict[str, Any]) -> str:
    """Return a schema in a few words."""
    if "$ref" in schema:
        return f"`{schema['$ref'].rsplit('/', 1)[-1]}`"
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
