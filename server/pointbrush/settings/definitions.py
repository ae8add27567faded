"""An option of the program: one definition gives its flag, variable and line of the docs.

Passwords are removed from the command line: every user of a machine can read its processes'
arguments.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Collection
from dataclasses import MISSING, dataclass, field, fields
from functools import cache
from typing import Any, get_type_hints
from urllib.parse import parse_qs, urlsplit

from pointbrush.errors import BadInputError
from pointbrush.settings.command_sets import SERVERS, WORKSPACE

PREFIX = "POINTBRUSH_"
UNBOUNDED = sys.maxsize
DATABASE_VARIABLE = f"{PREFIX}DATABASE"


@dataclass(frozen=True)
class Definition:
    """Properties of an option beside its name, type and default."""

    help: str
    where: tuple[str, ...]
    """Commands that take the flag."""
    client_help: str = ""
    """Help of commands that take ``--server``; empty: ``help``."""
    shown: tuple[str, ...] | None = None
    """Commands that list the flag in their help; None: all in ``where``."""
    unit: str = ""
    """Unit of a number: bytes, seconds; empty for a count that the help names."""
    least: int = 1
    """Smallest value of a number."""
    most: int = UNBOUNDED
    """Largest value of a number."""
    group: str = WORKSPACE
    """Heading in a command's help and in the docs."""


@dataclass(frozen=True)
class Option:
    """An option with its name, type and default; ``name`` is as Python spells it."""

    name: str
    kind: type
    default: Any
    definition: Definition

    @property
    def flag(self) -> str:
        """The flag on the command line, ``--max-body``."""
        return f"--{self.name.replace('_', '-')}"

    @property
    def variable(self) -> str:
        """The variable of the environment, ``POINTBRUSH_MAX_BODY``."""
        return PREFIX + self.name.upper()

    @property
    def shown_default(self) -> str:
        """The default with its unit; empty for an empty text."""
        if self.kind is bool:
            return "on" if self.default else "off"
        return f"{self.default} {self.definition.unit}".strip()

    def taken_by(self, command: str) -> bool:
        """Return whether ``command`` takes the flag."""
        return command in self.definition.where

    def help_in(self, command: str, clients: Collection[str]) -> str | None:
        """Return the help in ``command``; None: hidden.  ``clients`` take ``--server``."""
        shown = self.definition.shown
        if shown is not None and command not in shown:
            return None
        own = self.definition.client_help if command in clients else ""
        return own or self.definition.help

    def parse(self, text: str) -> Any:
        """Return the value of ``text``.

        Raises BadInputError without the option's name for a text of the wrong form.
        """
        if self.kind is bool:
            return _switch(text)
        if self.kind is int:
            return _integer(text, self.definition.least, self.definition.most)
        return self.kind(text)


def option(default: Any, help_text: str, *, where: tuple[str, ...] = SERVERS, **more: Any) -> Any:
    """Return the field of a dataclass of options; ``more``: fields of ``Definition``."""
    definition = Definition(help_text, where, **more)
    return field(default=default, metadata={"definition": definition})


def values_of(kind: type, source: object) -> dict[str, Any]:
    """Return the fields of dataclass ``kind`` as ``source``'s attributes have them, by name."""
    return {each.name: getattr(source, each.name) for each in fields(kind)}


@cache
def options_of(kind: type) -> tuple[Option, ...]:
    """Return the options of the dataclass ``kind``, in the order of its fields."""
    hints = get_type_hints(kind)
    assert all(each.default is not MISSING for each in fields(kind))  # noqa: S101
    return tuple(
        Option(each.name, hints[each.name], each.default, each.metadata["definition"])
        for each in fields(kind)
    )


def _switch(text: str) -> bool:
    if text.lower() in ("1", "true", "yes", "on"):
        return True
    if text.lower() in ("", "0", "false", "no", "off"):
        return False
    raise BadInputError(f"expected 1 or 0, got {text!r}")


def _integer(text: str, least: int, most: int) -> int:
    wanted = f"an integer from {least}" + (f" to {most}" if most < UNBOUNDED else "")
    try:
        value = int(text)
    except ValueError:
        raise BadInputError(f"expected {wanted}, got {text!r}") from None
    if not least <= value <= most:
        raise BadInputError(f"expected {wanted}, got {value}")
    return value


def has_password(url: str) -> bool:
    """Return whether a database URL holds a password."""
    parts = urlsplit(url)
    return bool(parts.password) or "password" in parse_qs(parts.query)


def hide_password(url: str | None) -> None:
    """Restart this program with the URL of ``--database`` in its environment if it is secret.

    A warning says that the arguments were readable until then.  Raises BadInputError on systems
    on which a process cannot replace itself.
    """
    if url is None or not has_password(url):
        return
    if os.name != "posix":
        raise BadInputError(
            f"--database: expected no password in it; set {DATABASE_VARIABLE} instead"
        )
    print(
        "pointbrush: the password in --database could be read by other users of this machine "
        f"while the program began; set {DATABASE_VARIABLE}, --database-password-file or PGPASSFILE "
        "instead",
        file=sys.stderr,
        flush=True,
    )
    kept = without_database(sys.orig_argv[1:])
    os.execve(  # noqa: S606 – this very program
        sys.executable, [sys.executable, *kept], os.environ | {DATABASE_VARIABLE: url}
    )


def without_database(arguments: list[str]) -> list[str]:
    """Return ``arguments`` without ``--database URL`` or ``--database=URL``."""
    kept: list[str] = []
    rest = iter(arguments)
    for argument in rest:
        if argument == "--database":
            next(rest, None)
        elif not argument.startswith("--database="):
            kept.append(argument)
    return kept
