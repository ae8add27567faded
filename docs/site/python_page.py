"""The reference of the Python client: classes with fields, and an example of each method."""

from __future__ import annotations

import dataclasses
import inspect
import re
import typing
from collections.abc import Iterator

import griffe
from examples import calls

from pointbrush import client
from pointbrush.values.base import descriptions

CLIENTS = """

::: pointbrush.client.Client
    options:
      inherited_members: true

::: pointbrush.client.AsyncClient
"""
ERRORS = """## Errors

If the server refuses a call, the client raises the error that the answer names.

::: pointbrush.errors
    options:
      show_root_heading: false
"""
PACKAGE = "pointbrush.client."
MODULES = re.compile(r"pointbrush\.(client|values)\.(\w+\.)?(?=[A-Z])|collections\.abc\.|typing\.")


def python() -> str:
    """Return the reference, class by class, which follows the introduction of the page."""
    parts = [CLIENTS]
    for name in client.__all__:
        if name.endswith("Client"):
            continue
        parts.append(f"::: {PACKAGE}{name}\n")
        kind = getattr(client, name)
        if isinstance(kind, type) and dataclasses.is_dataclass(kind):
            parts.append("\n".join(_fields(kind)) + "\n")
    return "\n".join([*parts, ERRORS])


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
        """Look for an example of what was read."""
        if not obj.path.startswith(PACKAGE):
            return
        name = obj.name if obj.is_class else ".".join(obj.path.split(".")[-2:])
        # What both clients do is written in the class of both.
        code = self._calls.get(name.replace("Server.", "Client."))
        if code and obj.docstring:
            obj.docstring.value = f"{obj.docstring.value}\n\n```python\n{code}\n```"
