"""The ``pointbrush`` command: runs one command, and exits with its code."""

from __future__ import annotations

import argparse
import gc
import sys
from collections.abc import Sequence
from contextlib import closing, nullcontext

from pointbrush.commands.grammar import parser
from pointbrush.commands.places import place_of
from pointbrush.errors import PointbrushError
from pointbrush.settings.definitions import hide_password
from pointbrush.settings.settings import Settings, options
from pointbrush.system.permissions import private_files

__all__ = ["main", "parser"]

COLLECT_AFTER = (10_000, 20, 20)
"""Thresholds of the garbage collector, above Python's own: modules and models are 160,000 lasting
objects, and with Python's thresholds their import takes a third longer."""


def main(line: Sequence[str] | None = None) -> int:
    """Run one command; return the exit code: 0, 2 for a usage error, 1 for any other error."""
    given = parser().parse_args(line)
    try:
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
    # After help and usage errors, which need no other modules.
    gc.set_threshold(*COLLECT_AFTER)
    # Exported files have the permissions that the user's umask gives.
    with (
        nullcontext() if given.command in ("export", "report") else private_files(),
        closing(place_of(given, settings)) as place,
    ):
        answer = given.run(given, place)
    if answer is not None:
        answer.show(as_json=given.json)
        if answer.error:
            raise PointbrushError(answer.error)


if __name__ == "__main__":
    raise SystemExit(main())
