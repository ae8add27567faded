"""The tables of docs/options.md, written from the options."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from pointbrush.settings.command_sets import CLIENTS, COMMAND_SETS, EVERYWHERE, GROUPS, SERVERS
from pointbrush.settings.definitions import Option
from pointbrush.settings.settings import options

DOCS = Path(__file__).parents[3] / "docs" / "options.md"
BEGIN, END = "<!-- Written by `python -m pointbrush.settings`. -->\n", "<!-- End. -->\n"
HEAD = ("| flag | variable | default | commands | meaning |", "|---|---|---|---|---|")


def with_new_tables(text: str) -> str:
    """Return ``text`` of docs/options.md with new tables between its two marks."""
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    sets = (("servers", SERVERS), ("clients", CLIENTS), ("workspace", EVERYWHERE))
    names = [f"- {name}: `{'`, `'.join(commands)}`\n" for name, commands in sets]
    tables = _markdown(options(), GROUPS, COMMAND_SETS)
    return "".join((before, begin, *names, "\n", tables, end, after))


def _markdown(
    options: Sequence[Option], groups: Sequence[str], command_sets: Mapping[tuple[str, ...], str]
) -> str:
    """Return a heading and a table for each of ``groups``, ending in a newline.

    ``command_sets``: names of the sets of commands that take an option.
    """
    parts = []
    for group in groups:
        members = [each for each in options if each.definition.group == group]
        rows = [_row(each, command_sets[each.definition.where]) for each in members]
        title = f"{group[0].upper()}{group[1:]}"
        parts.append("\n".join([f"## {title}", "", *HEAD, *rows]) + "\n")
    return "\n".join(parts)


def _row(each: Option, commands: str) -> str:
    definition = each.definition
    text = definition.help
    if definition.client_help:
        text += f"; in client commands: {definition.client_help}"
    default = f"`{each.shown_default}`" if each.shown_default else "–"
    cells = (f"`{each.flag}`", f"`{each.variable}`", default, commands, text.replace("|", "\\|"))
    return f"| {' | '.join(cells)} |"
