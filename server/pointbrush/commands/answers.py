"""Answers of commands, the same for a workspace of this machine and of a server."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, is_dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Answer:
    """Answer of a command.

    `--json` prints ``value``.  Otherwise ``lines`` are printed, on a terminal below ``head`` with
    the names of their columns, and ``warnings`` on standard error.  With an ``error`` the command
    prints the answer and fails.
    """

    value: Any
    lines: Sequence[str]
    warnings: Sequence[str] = ()
    head: str = ""
    error: str = ""

    def show(self, *, as_json: bool) -> None:
        """Print the answer as one JSON document or as lines."""
        if as_json:
            print(json.dumps(self.value, default=_plain, ensure_ascii=False, indent=1))
            return
        for warning in self.warnings:
            print(warning, file=sys.stderr)
        for line in (self.head, *self.lines) if sys.stdout.isatty() else self.lines:
            if line:
                print(line)


def _plain(value: object) -> object:
    """Return a value that JSON cannot hold as one that it can."""
    return asdict(value) if is_dataclass(value) and not isinstance(value, type) else str(value)


def confirmed(line: str, **value: Any) -> Answer:
    """Return an answer of one line, with ``value`` as JSON."""
    return Answer(value, [line])


def table(value: Sequence[object], head: Sequence[str], rows: Iterable[Sequence[object]]) -> Answer:
    """List ``value`` in rows of columns that tabs separate; the head is for a terminal."""
    lines = ["\t".join("" if cell is None else str(cell) for cell in row) for row in rows]
    return Answer(value, lines, head="\t".join(head) if lines else "")


def merge_answers(answers: Iterable[Answer]) -> Answer:
    """Join several answers; return a single answer unchanged."""
    found = list(answers)
    if len(found) == 1:
        return found[0]
    lines = [line for each in found for line in each.lines]
    warnings = [warning for each in found for warning in each.warnings]
    return Answer([each.value for each in found], lines, warnings)
