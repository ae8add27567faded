"""An option of the program: one definition gives its flag, variable and line of the docs.

Secrets do not stay on the command line: every user of a machine may read a process's arguments.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Sequence
from dataclasses import MISSING, dataclass, field, fields
from itertools import groupby
from typing import Any, get_type_hints
from urllib.parse import parse_qs, urlsplit

from pointbrush.errors import BadInputError

PREFIX = "POINTBRUSH_"
UNBOUNDED = sys.maxsize
WORKSPACE = "workspace"
HEAD = ("| flag | variable | default | meaning |", "|---|---|---|---|")
DATABASE_VARIABLE = f"{PREFIX}DATABASE"


@dataclass(frozen=True)
class Definition:
    """Everything about an option but its name, type and default, which are its field's."""

    help: str
    where: tuple[str, ...]
    """Commands that take it as a flag; none means every one that opens a workspace."""
    unit: str = ""
    """Of a number: bytes, seconds, points; empty where it counts what the help names."""
    least: int = 1
    most: int = UNBOUNDED
    group: str = WORKSPACE
    """Heading in a command's help."""


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
        """The default with its unit, empty where nothing is the default."""
        if self.kind is bool:
            return "on" if self.default else "off"
        return f"{self.default} {self.definition.unit}".strip()

    def taken_by(self, command: str) -> bool:
        """Return whether ``command``, which opens a workspace, has the flag."""
        return not self.definition.where or command in self.definition.where

    def parse(self, text: str) -> Any:
        """Return the value that ``text`` gives.

        Raises BadInputError, which does not name the option, for a text of the wrong form.
        """
        if self.kind is bool:
            return _switch(text)
        if self.kind is int:
            return _integer(text, self.definition.least, self.definition.most)
        return self.kind(text)


def option(default: Any, help_text: str, *, where: tuple[str, ...], **more: Any) -> Any:
    """Return the field of a dataclass of options; ``more`` is as in ``Definition``."""
    definition = Definition(help_text, where, **more)
    return field(default=default, metadata={"definition": definition})


def choice(default: Any, help_text: str, **more: Any) -> Any:
    """Return the field of a dataclass of choices for one call; ``more`` as in ``Definition``."""
    return option(default, help_text, where=(), **more)


def chosen(kind: type, source: object) -> dict[str, Any]:
    """Return the choices of a dataclass among the attributes of ``source``, by name."""
    return {each.name: getattr(source, each.name) for each in fields(kind)}


def options_of(kind: type) -> tuple[Option, ...]:
    """Return the options that are the fields of the dataclass ``kind``, in their order."""
    hints = get_type_hints(kind)
    assert all(each.default is not MISSING for each in fields(kind))  # noqa: S101
    return tuple(
        Option(each.name, hints[each.name], each.default, each.metadata["definition"])
        for each in fields(kind)
    )


def markdown(options: Iterable[Option]) -> str:
    """Return a heading and a table for each set of commands, ending in a newline."""

    def commands(each: Option) -> tuple[str, ...]:
        return each.definition.where

    # Sorted by the number of commands: what all take comes first; the order within stays.
    ordered = sorted(options, key=lambda each: (_width(commands(each)), commands(each)))
    parts = []
    for where, group in groupby(ordered, key=commands):
        lines = [
            f"## {_heading(where)}",
            "",
            *HEAD,
        ]
        lines += [_row(each) for each in group]
        parts.append("\n".join(lines) + "\n")
    return "\n".join(parts)


def _width(where: Sequence[str]) -> int:
    return -len(where) if where else -UNBOUNDED


def _heading(where: Sequence[str]) -> str:
    if not where:
        return "Every command that opens a workspace"
    return "Of " + " and ".join(filter(None, (", ".join(where[:-1]), where[-1])))


def _row(each: Option) -> str:
    text = each.definition.help.replace("|", "\\|")
    default = f"`{each.shown_default}`" if each.shown_default else "–"
    return f"| `{each.flag}` | `{each.variable}` | {default} | {text} |"


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
    """Start this program again with the URL of ``--database`` in its environment, if it is secret.

    The arguments could be read until then: a warning says so.  Raises BadInputError where a
    program cannot be replaced by itself.
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
