"""The grammar of the ``pointbrush`` command: all verbs in their order, with their options."""

from __future__ import annotations

import argparse
from functools import partial
from typing import Any

from pointbrush import __version__
from pointbrush.commands import (
    exporting,
    importing,
    labelling,
    recordings,
    reviewing,
    serving,
    storage,
    team,
    tools,
)
from pointbrush.commands.arguments import Verb, argument, verb
from pointbrush.errors import BadInputError
from pointbrush.settings.command_sets import CLIENTS, EVERYWHERE, GROUPS, STORES
from pointbrush.settings.definitions import Option
from pointbrush.settings.settings import options

HIDDEN = "Options of the database and of object storage: docs/options.md"


@verb(argument("shell", "the shell", choices=("bash", "zsh", "tcsh")))
def completion(given: argparse.Namespace, _place: object) -> None:
    """Print a script that completes commands."""
    import shtab

    print(shtab.complete(parser(), given.shell))


PRINTERS = (serving.demo, serving.serve, reviewing.review, completion, tools.bench)
"""Verbs that print while they run; the others answer, as JSON with ``--json``."""
VERBS = (
    serving.demo, importing.import_, importing.import_labels, serving.serve, labelling.track,
    labelling.fit_boxes, labelling.find_people, recordings.align_sensors, labelling.example,
    exporting.export, recordings.info, team.project, team.task, team.webhook,
    recordings.undo, team.token, reviewing.review, storage.check, reviewing.check_labels,
    reviewing.compare, reviewing.report, recordings.labels, recordings.delete,
    recordings.undelete, recordings.rename,
    tools.headset_report, storage.backup, storage.restore, storage.move, completion, tools.bench,
)  # fmt: skip
"""All verbs, in the order of the help."""


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    top = argparse.ArgumentParser(prog="pointbrush", description="Label point cloud recordings.")
    top.add_argument("--version", action="version", version=f"pointbrush {__version__}")
    commands = top.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for each in VERBS:
        hides = each.name in EVERYWHERE and each.name not in STORES
        command = commands.add_parser(
            each.name, help=each.text, description=each.text, epilog=HIDDEN if hides else None
        )
        _fill(command, each)
    return top


def _fill(command: argparse.ArgumentParser, each: Verb) -> None:
    """Add the arguments of a verb, and the options that it takes."""
    command.set_defaults(command=each.name, run=each.run)
    for own in each.arguments:
        command.add_argument(own.name, **own.options)
    _add_settings(each.name, command)
    if each not in PRINTERS:
        command.add_argument(
            "--json", action="store_true", help="print the answer as one JSON document"
        )


def _add_settings(name: str, command: argparse.ArgumentParser) -> None:
    """Add the options that a command takes under their headings, see ``Settings``."""
    for title in GROUPS:
        members = [
            each for each in options() if each.definition.group == title and each.taken_by(name)
        ]
        if members:
            group = command.add_argument_group(title)
            for option in members:
                _add_setting(group, option, option.help_in(name, CLIENTS))


def _add_setting(group: argparse._ArgumentGroup, option: Option, text: str | None) -> None:
    if text is None:
        text = argparse.SUPPRESS
    elif option.shown_default and option.kind is not bool:
        text += f" (default: {option.shown_default})"
    if option.kind is bool:
        group.add_argument(option.flag, action="store_true", default=None, help=text)
    else:
        group.add_argument(option.flag, type=partial(_setting, option), default=None, help=text)


def _setting(option: Option, text: str) -> Any:
    try:
        return option.parse(text)
    except BadInputError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
