"""The reference of the Python client: classes with fields, and an example of each method."""

from __future__ import annotations

import dataclasses
import inspect
import re
import typing
from collections.abc import Iterator
from typing import cast

import griffe
from examples import calls

from pointbrush import client
from pointbrush.values.base import descriptions

ERRORS = """# Errors of the Python client

If the server refuses a call, the client raises the error that the answer names.

::: pointbrush.errors
    options:
      show_root_heading: false
"""
OPTIONS = "    options:\n      show_root_heading: false\n      show_bases: false\n"
INHERITED = "      inherited_members: true\n"
"""Option of the page of ``Client``: its methods are written once for both clients."""
PACKAGE = "pointbrush.client."
MODULES = re.compile(r"pointbrush\.(client|values)\.(\w+\.)?(?=[A-Z])|collections\.abc\.|typing\.")


def overview() -> str:
    """Return a table of all classes, which follows the introduction of the page."""
    rows = [f"| [{name}](python/{_page(name)}) | {_first(kind)} |" for name, kind in _classes()]
    errors = "| [Errors](python/errors.md) | errors that the client raises |"
    return "\n".join(["", "", "| class | meaning |", "|---|---|", *rows, errors, ""])


def pages() -> dict[str, str]:
    """Return the pages of the classes and of the errors, by their places."""
    made = {"reference/python/errors.md": ERRORS}
    for name, kind in _classes():
        options = OPTIONS + INHERITED * (name == "Client")
        parts = [f"# {name}", "", f"::: {PACKAGE}{name}", options]
        parts += _fields(kind) if dataclasses.is_dataclass(kind) else []
        made[f"reference/python/{_page(name)}"] = "\n".join(parts)
    return made


def _classes() -> list[tuple[str, type]]:
    found = [(name, getattr(client, name)) for name in client.__all__]
    kinds = [(name, kind) for name, kind in found if isinstance(kind, type)]
    return sorted(kinds, key=lambda each: not each[0].endswith("Client"))


def _page(name: str) -> str:
    return f"{name.lower()}.md"


def _first(kind: type) -> str:
    """Return the first sentence of a class's description."""
    text = " ".join((inspect.getdoc(kind) or "").split("\n\n")[0].split())
    return re.split(r"(?<=\.) ", text)[0].replace("``", "`").replace("|", "\\|")


def _fields(kind: type) -> Iterator[str]:
    """Write a table of a dataclass's fields."""
    yield from ("| field | type | default | meaning |", "|---|---|---|---|")
    hints, texts = typing.get_type_hints(kind), descriptions(kind)
    for field in dataclasses.fields(kind):
        made = field.default_factory is not dataclasses.MISSING
        default = "made anew" if made else f"`{field.default!r}`"
        given = default if made or field.default is not dataclasses.MISSING else "required"
        shown = inspect.formatannotation(hints[field.name]).replace("|", "\\|")
        meaning = texts.get(field.name, "").replace("``", "`")
        yield f"| `{field.name}` | {_plain(shown)} | {given} | {meaning} |"
    yield ""


def _plain(annotation: str) -> str:
    """Return an annotation without the names of modules."""
    annotation = MODULES.sub("", annotation)
    return f"`{annotation}`" if "|" not in annotation else annotation


class Examples(griffe.Extension):
    """Put the example of a method, or of a class, behind its docstring."""

    def __init__(self) -> None:
        super().__init__()
        self._calls = calls()

    def on_instance(self, *, obj: griffe.Object, **_: object) -> None:
        """Look for an example, and show the value that a caller gets as a method's return type."""
        if not obj.path.startswith(PACKAGE):
            return
        if isinstance(obj, griffe.Function) and str(obj.returns).startswith("Steps["):
            obj.returns = cast("griffe.ExprSubscript", obj.returns).slice
        name = obj.name if obj.is_class else ".".join(obj.path.split(".")[-2:])
        # What both clients do is written in the class of both.
        code = self._calls.get(name.replace("Server.", "Client."))
        if code and obj.docstring:
            obj.docstring.value = f"{obj.docstring.value}\n\n```python\n{code}\n```"
