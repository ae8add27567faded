"""The ``pointbrush`` command: runs one command, and exits with its code."""

from __future__ import annotations

import argparse
import gc
import sys
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from importlib import import_module
from keyword import iskeyword

from pointbrush import arguments
from pointbrush.errors import PointbrushError
from pointbrush.grammar import parser
from pointbrush.options import hide_password
from pointbrush.permissions import private_files
from pointbrush.printing import Answer
from pointbrush.settings import REMOTE, Settings, options

__all__ = ["main", "parser"]

Command = Callable[[argparse.Namespace, Settings], Answer | None]
COLLECT_AFTER = (10_000, 20, 20)
"""Thresholds of the garbage collector, above Python's own: modules and models are 160,000 lasting
objects, and with Python's thresholds their import takes a third longer."""


def main(line: Sequence[str] | None = None) -> int:
    """Run one command; return the exit code: 0, 2 for a usage error, 1 for any other error."""
    grammar = parser()
    given = grammar.parse_args(line)
    try:
        if given.command == "completion":
            import shtab

            print(shtab.complete(grammar, given.shell))
            return 0
        if line is None:
            hide_password(given.database if "database" in given else None)
        _run(given)
    except PointbrushError as error:
        print(f"pointbrush: {error.whole}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("pointbrush: interrupted", file=sys.stderr)
        return 1
    except BrokenPipeError:
        return 1
    return 0


def _run(given: argparse.Namespace) -> None:
    """Run a command and print its answer; raises PointbrushError."""
    settings = Settings.load({o.name: getattr(given, o.name, None) for o in options()})
    module = _module(given, settings)
    # After help and usage errors, which need no other modules.
    gc.set_threshold(*COLLECT_AFTER)
    command: Command = getattr(import_module(module), _function(given.command))
    # Exported files have the permissions that the user's umask gives.
    with nullcontext() if given.command in ("export", "report") else private_files():
        answer = command(given, settings)
    if answer is not None:
        answer.show(as_json=given.json)
        if answer.error:
            raise PointbrushError(answer.error)


def _module(given: argparse.Namespace, settings: Settings) -> str:
    """Return the module of a command's function; raises BadInputError, see ``on_server``."""
    if not arguments.on_server(given, settings):
        return "pointbrush.commands"
    return "pointbrush.remote" if given.command in REMOTE else "pointbrush.team_commands"


def _function(command: str) -> str:
    """Return the name of a command's function."""
    name = command.replace("-", "_")
    return f"{name}_" if iskeyword(name) else name


if __name__ == "__main__":
    raise SystemExit(main())
