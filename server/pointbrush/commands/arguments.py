"""Declarations of commands and their arguments, and the types of arguments."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields
from types import UnionType
from typing import Annotated, Any, Literal, TypeAlias, Union, get_args, get_origin, get_type_hints

from pointbrush.commands.answers import Answer
from pointbrush.errors import BadInputError
from pointbrush.settings.definitions import UNBOUNDED
from pointbrush.values.base import Meanings, Repeated, Value, default_of, descriptions

Run: TypeAlias = Callable[[argparse.Namespace, Any], Answer | None]
"""Runs a command with its given arguments at a place, see ``places.Place``."""


@dataclass(frozen=True, slots=True)
class Argument:
    """An argument with its ``options`` as ``argparse`` takes them."""

    name: str
    options: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Verb:
    """A command: its name, its one-line description, its arguments and its function."""

    name: str
    text: str
    arguments: tuple[Argument, ...]
    run: Run


def verb(*arguments: Argument) -> Callable[[Run], Verb]:
    """Declare a function as the command of its name; its docstring's first line describes it."""

    def declare(run: Run) -> Verb:
        text = (run.__doc__ or "").partition("\n")[0].removesuffix(".")
        name = run.__name__.removesuffix("_").replace("_", "-")
        return Verb(name, text[:1].lower() + text[1:], arguments, run)

    return declare


def argument(name: str, help: str, **options: Any) -> Argument:
    """Declare an argument or flag; ``options``: of ``ArgumentParser.add_argument``."""
    return Argument(name, {"help": help, **options})


def switch(name: str, help: str) -> Argument:
    """Declare a flag without a value."""
    return argument(name, help, action="store_true")


def flags_of(kind: type[Value], *names: str) -> Iterator[Argument]:
    """Yield a flag for each of the named fields of a value (none: all), with the field's sentence.

    The default of a flag is that of its field.
    """
    hints, texts = get_type_hints(kind, include_extras=True), descriptions(kind)
    for each in fields(kind):  # type: ignore[arg-type]
        if names and each.name not in names:
            continue
        types = list(_parts_of(hints[each.name]))
        text = " ".join(
            [texts.get(each.name, ""), *(part.text for part in types if isinstance(part, Meanings))]
        )
        text = text.replace("`", "").replace("null:", "default:").removesuffix(".")
        options: dict[str, Any] = {"default": default_of(each)}
        if options["default"]:
            text += f" (default: {options['default']})"
        if Repeated in types:
            options |= {"action": "append", "default": None}
        elif bool in types:
            optional = type(None) in types
            options["action"] = argparse.BooleanOptionalAction if optional else "store_true"
        elif float in types:
            options["type"] = positive
        elif get_origin(types[0]) is Literal:
            options["choices"] = get_args(types[0])
        yield argument(f"--{each.name.replace('_', '-')}", text[:1].lower() + text[1:], **options)


def _parts_of(hint: Any) -> Iterator[Any]:
    """Yield the types that a field may have, and their limits and meanings."""
    if get_origin(hint) in (Annotated, Union, UnionType):
        for each in get_args(hint):
            yield from _parts_of(each)
    else:
        yield hint


def usage_error(command: str, text: str) -> SystemExit:
    """Print the error of arguments that the parser accepts, and return the exit to raise."""
    print(f"pointbrush {command}: error: {text}", file=sys.stderr)
    return SystemExit(2)


def listed(text: str) -> list[str]:
    """Return the parts of a text that commas separate."""
    return [part.strip() for part in text.split(",") if part.strip()]


def required(name: str, value: str | None) -> str:
    """Return a required argument; raises BadInputError if it was not given."""
    if not value:
        raise BadInputError(f"{name}: expected a value, got none")
    return value


def positive(text: str) -> float:
    """Parse a number above 0."""
    value = _number(text)
    if not 0 < value < 1e6:
        raise argparse.ArgumentTypeError(f"expected a number above 0, got {text!r}")
    return value


def share(text: str) -> float:
    """Parse a number from 0 to 1."""
    value = _number(text)
    if not 0 <= value <= 1:
        raise argparse.ArgumentTypeError(f"expected a number from 0 to 1, got {text!r}")
    return value


def _number(text: str) -> float:
    """Return the number of a text, NaN for another text."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def whole(wanted: str, least: int, most: int = UNBOUNDED) -> Callable[[str], int]:
    """Return a parser of integers from ``least`` to ``most``; ``wanted`` describes them."""

    def read(text: str) -> int:
        if not text.isdecimal() or not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(f"expected {wanted}, got {text!r}")
        return int(text)

    return read


FROM_ONE = whole("an integer from 1", 1)
ANY_SEQUENCE = "id or name of a recording, as `pointbrush info` lists them"
SEQUENCE = argument("sequence", ANY_SEQUENCE, metavar="SEQ")
ONE_OR_ALL = argument("sequence", ANY_SEQUENCE, metavar="SEQ", nargs="?")
FRAMES = argument("--frames", "frames I to J - 1 (default: all)", metavar="I:J")
PROJECT = argument("--project", "id of the project", default="default", metavar="P")
SOME_LABELS = "names or ids of labels, separated by commas"
