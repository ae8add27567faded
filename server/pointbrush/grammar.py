"""The grammar of the ``pointbrush`` command: commands, arguments, flags and their help."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args, get_origin

from pointbrush import __version__
from pointbrush.accounts.roles import ROLES
from pointbrush.errors import BadInputError
from pointbrush.formats.tables.corrections import Corrections
from pointbrush.options import UNBOUNDED, Option, options_of
from pointbrush.settings import CLIENTS, EVERYWHERE, GROUPS, STORES, options
from pointbrush.work.imports.options import SAMPLES, LabelOptions
from pointbrush.work.tracking.options import RunOptions

Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"
SEQUENCE = "id or name of a recording, as `pointbrush info` lists them"
SOME_FRAMES = "frames I to J - 1 (default: all)"
SOME_LABELS = "names or ids of labels, separated by commas"
HIDDEN = "Options of the database and of object storage: docs/options.md"
SERVING = ("demo", "serve", "review")
"""Commands that run until they are interrupted; the others answer, as JSON with ``--json``."""


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    top = argparse.ArgumentParser(prog="pointbrush", description="Label point cloud recordings.")
    top.add_argument("--version", action="version", version=f"pointbrush {__version__}")
    commands = top.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for add in (
        _add_demo, _add_import, _add_import_labels, _add_serve, _add_track, _add_fit_boxes,
        _add_example, _add_export, _add_info, _add_team, _add_token, _add_review, _add_checks,
        _add_report, _add_recordings, _add_headset_report, _add_backups,
    ):  # fmt: skip
        add(commands)
    for name, command in commands.choices.items():
        _add_settings(name, command)
        if name not in SERVING:
            command.add_argument(
                "--json", action="store_true", help="print the answer as one JSON document"
            )
    _add_completion(commands)
    _add_bench(commands)
    return top


# ── commands ─────────────────────────────────────────────────────────────────────────────────


def _add_demo(commands: Commands) -> None:
    demo = _command(commands, "demo", "make the sample recording and serve it")
    demo.add_argument(
        "--sample-frames",
        type=_whole("an integer from 1", 1),
        default=90,
        help="number of frames of the sample (default: 90)",
    )
    demo.add_argument(
        "--sample", choices=SAMPLES, default="juggling", help="the sample (default: juggling)"
    )


def _add_import(commands: Commands) -> None:
    import_ = _command(commands, "import", "import files as one recording")
    import_.add_argument(
        "paths", nargs="+", type=Path, metavar="PATH", help="files, folders, globs or archives"
    )
    import_.add_argument("--name", help="name of the recording (default: from the path)")
    import_.add_argument(
        "--each",
        action="store_true",
        help="import each file and folder in PATH as a recording of its own",
    )
    import_.add_argument(
        "--project", default="default", metavar="P", help="id of the recording's project"
    )
    import_.add_argument("--fps", type=_positive, help="frames per second")
    _choices(import_, Corrections)
    import_.add_argument(
        "--dry-run", action="store_true", help="print the import's result without importing"
    )


def _add_import_labels(commands: Commands) -> None:
    labels = _command(commands, "import-labels", "import labels made elsewhere, as one edit")
    labels.add_argument("sequence", metavar="SEQ", help=SEQUENCE)
    labels.add_argument(
        "path",
        type=Path,
        nargs="?",
        metavar="PATH",
        help="file or folder of labels (default: the labels in the recording's own files, if they "
        "were not imported with it)",
    )
    labels.add_argument(
        "--map",
        type=Path,
        metavar="FILE",
        help="file with the names of classes: JSON, YAML, XML, or lines 'number name'",
    )
    _choices(labels, LabelOptions)
    labels.add_argument(
        "--dry-run", action="store_true", help="print the labels found without importing"
    )


def _add_serve(commands: Commands) -> None:
    _command(commands, "serve", "serve the page, REST and the WebSocket")


def _add_track(commands: Commands) -> None:
    track = _command(commands, "track", "track labels through the following frames")
    track.add_argument("sequence", metavar="SEQ", help=SEQUENCE)
    frame = _whole("a frame number from 0", 0)
    track.add_argument(
        "--from", dest="start", type=frame, required=True, metavar="I", help="a labelled frame"
    )
    track.add_argument(
        "--to", dest="stop", type=frame, required=True, metavar="J",
        help="the last frame; a frame before I tracks backward",
    )  # fmt: skip
    track.add_argument("--labels", help=f"{SOME_LABELS} (default: all labels in frame I)")
    _choices(track, RunOptions)


def _add_fit_boxes(commands: Commands) -> None:
    fit = _command(commands, "fit-boxes", "fit a box to the points of each label, over all frames")
    fit.add_argument("sequence", metavar="SEQ", help=SEQUENCE)
    fit.add_argument("--labels", help=f"{SOME_LABELS} (default: all)")
    fit.add_argument("--category", help="only labels of this category")
    fit.add_argument("--frames", metavar="I:J", help=SOME_FRAMES)
    fit.add_argument("--redraw", action="store_true", help="replace boxes drawn by hand, too")


def _add_example(commands: Commands) -> None:
    example = _command(
        commands, "example", "train a classifier on painted points and label other points with it"
    )
    example.add_argument(
        "sequence", nargs="?", metavar="SEQ", help=f"{SEQUENCE}; the examples are painted in it"
    )
    example.add_argument("--classifier", metavar="ID", help="an existing classifier")
    example.add_argument("--name", help="name of a new classifier (default: the recording's)")
    example.add_argument(
        "--classes", help="names of classes, separated by commas (default: the whole palette)"
    )
    example.add_argument(
        "--model", default="", metavar="NAME", help="plug-in or service of a new classifier"
    )
    example.add_argument(
        "--imported",
        action="store_true",
        help="train a new classifier on imported labels, too",
    )
    example.add_argument(
        "--start-from",
        default="",
        metavar="SEQ,…",
        help="labelled recordings that a new classifier starts from, separated by commas",
    )
    example.add_argument(
        "--apply",
        metavar="I:J",
        help="label unlabeled and predicted points of frames I to J - 1, or 'all'",
    )
    example.add_argument(
        "--above",
        type=_share,
        help="minimum confidence of applied labels, 0 to 1 (default: measured)",
    )
    example.add_argument("--save", type=Path, metavar="FILE", help="write the classifier to a file")
    example.add_argument("--load", type=Path, metavar="FILE", help="read a file that --save wrote")
    example.add_argument("--delete", action="store_true", help="delete the classifier")


def _add_export(commands: Commands) -> None:
    export = _command(commands, "export", "write points with their labels")
    export.add_argument("sequence", metavar="SEQ", help=SEQUENCE)
    export.add_argument("--format", required=True, help="a format of docs/formats-written.md")
    export.add_argument("--out", required=True, type=Path, help="folder or file to write")
    export.add_argument("--frames", metavar="I:J", help=SOME_FRAMES)
    export.add_argument(
        "--snapshot", metavar="NAME", help="labels of a snapshot instead of the current ones"
    )
    export.add_argument(
        "--above", type=_share, default=0.0, help="minimum confidence of predicted labels, 0 to 1"
    )
    export.add_argument(
        "--val",
        metavar="I:J|SEQ,…|none",
        help="frames or recordings for validation in training formats (default: about one "
        "recording in five by its id, never all)",
    )


def _add_info(commands: Commands) -> None:
    info = _command(commands, "info", "list the recordings, or describe one")
    info.add_argument("sequence", nargs="?", metavar="SEQ", help=SEQUENCE)


def _add_team(commands: Commands) -> None:
    actions = ("list", "add", "delete")
    project = _command(commands, "project", "list, add or delete projects of a server")
    project.add_argument("action", choices=actions, help="the action")
    project.add_argument("name", nargs="?", help="name of a new project (add), or its id (delete)")

    task = _command(commands, "task", "list, add or delete labelling tasks of a server")
    task.add_argument("action", choices=actions, help="the action")
    task.add_argument(
        "items",
        nargs="*",
        metavar="ITEM",
        help="recordings (add; default: all of the project), or numbers of tasks (delete)",
    )
    task.add_argument("--state", help="only tasks in this state (list)")
    task.add_argument("--assignee", help="account of the assignee (list, add)")
    task.add_argument("--frames", metavar="I:J", help="frames of the tasks (add; default: all)")
    task.add_argument(
        "--every", type=_whole("an integer from 1", 1), metavar="N", help="frames of a task (add)"
    )

    webhook = _command(commands, "webhook", "list, add or delete webhooks of a server")
    webhook.add_argument("action", choices=actions, help="the action")
    webhook.add_argument("item", nargs="?", help="URL to call (add), or the webhook's id (delete)")
    webhook.add_argument(
        "--topics", help="task, labels or job, separated by commas (add; default: all)"
    )
    for each in (task, webhook):
        each.add_argument("--project", default="default", metavar="P", help="id of the project")

    undo = _command(commands, "undo", "undo your last edit of a recording on a server")
    undo.add_argument("sequence", metavar="SEQ", help=SEQUENCE)


def _add_token(commands: Commands) -> None:
    token = _command(commands, "token", "add, list or revoke access tokens")
    token.add_argument("action", choices=("add", "list", "revoke"), help="the action")
    token.add_argument("name", nargs="?", help="name of the person (add), or the token's id")
    token.add_argument("--role", default="annotator", help=f"one of {', '.join(ROLES)}")
    token.add_argument("--days", type=_positive, help="days until the token expires")


def _add_review(commands: Commands) -> None:
    review = _command(commands, "review", "step through labels and doubtful tracks in viser")
    review.add_argument("sequence", metavar="SEQ", help=SEQUENCE)
    review.add_argument(
        "--port",
        type=_whole("a port from 1 to 65535", 1, 65_535),
        default=8081,
        help="port to listen on (default: 8081)",
    )
    review.add_argument(
        "--explain",
        type=_whole("a label's number", 1, 65_535),
        metavar="LABEL",
        help="show the tracker's steps for this label in each frame",
    )
    review.add_argument(
        "--method",
        choices=("auto", "icp", "color-icp"),
        default="auto",
        help="tracking method that is explained (default: auto)",
    )


def _add_checks(commands: Commands) -> None:
    check = _command(commands, "check", "verify recordings, database, journal and annotations")
    check.add_argument("sequence", nargs="?", metavar="SEQ", help=SEQUENCE)
    check.add_argument(
        "--repair",
        action="store_true",
        help="rebuild indexes, snapshots, counts, palette, tracks and missing checksums, and list "
        "the remaining faults; stop servers first",
    )

    suspicious = _command(commands, "check-labels", "list suspicious labels, frame by frame")
    suspicious.add_argument("sequence", metavar="SEQ", help=SEQUENCE)
    suspicious.add_argument("--frames", metavar="I:J", help=SOME_FRAMES)
    suspicious.add_argument(
        "--fail", action="store_true", help="exit with 1 if there are suspicious labels"
    )
    suspicious.add_argument(
        "--all", action="store_true", help="list findings that a reviewer has accepted, too"
    )

    compare = _command(commands, "compare", "compare the labels of two recordings of one scene")
    compare.add_argument("sequence", metavar="SEQ", help=f"{SEQUENCE}; the truth of --boxes")
    compare.add_argument("other", metavar="SEQ2", help="a recording of the same points")
    compare.add_argument("--frames", metavar="I:J", help=SOME_FRAMES)
    compare.add_argument(
        "--boxes", action="store_true", help="compare boxes by class: AP, precision, recall, HOTA"
    )


def _add_report(commands: Commands) -> None:
    report = _command(commands, "report", "write a report of progress and of time spent by person")
    report.add_argument("sequence", metavar="SEQ", help=SEQUENCE)
    report.add_argument("--out", required=True, type=Path, help="file to write: .html or .csv")
    report.add_argument(
        "--table",
        choices=("frames", "labels", "people"),
        default="frames",
        help="table of a .csv (default: frames)",
    )


def _add_recordings(commands: Commands) -> None:
    for name, text, sequence in (
        ("labels", "list the labels of a recording with their numbers of points", SEQUENCE),
        ("delete", "delete a recording; `undelete` restores it within 30 days", SEQUENCE),
        ("undelete", "restore a deleted recording", "id of the deleted recording"),
        ("rename", "rename a recording; its id stays the same", SEQUENCE),
    ):
        command = _command(commands, name, text)
        command.add_argument("sequence", metavar="SEQ", help=sequence)
        if name == "rename":
            command.add_argument("name", metavar="NAME", help="the new name")


def _add_headset_report(commands: Commands) -> None:
    headset = _command(
        commands, "headset-report", "print a headset's report of the page /check-headset"
    )
    headset.add_argument("file", type=Path, metavar="FILE", help="file downloaded from that page")


def _add_backups(commands: Commands) -> None:
    backup = _command(commands, "backup", "copy a workspace, also while it is in use")
    backup.add_argument(
        "target",
        nargs="?",
        type=Path,
        help="new folder (default: a dated folder in --backup-to)",
    )
    backup.add_argument(
        "--if-older",
        metavar="TIME",
        help="do nothing if the newest backup in --backup-to is younger: 90m, 24h or 7d",
    )

    restore = _command(commands, "restore", "make a workspace from a backup")
    restore.add_argument("source", type=Path, help="folder of a backup")
    restore.add_argument(
        "--only",
        metavar="SEQ",
        help="restore one recording into an existing workspace, also while it is in use",
    )

    move = _command(commands, "move", "move the labels into another database")
    move.add_argument(
        "target", metavar="URL", help="postgresql://host/name, or 'sqlite': in the workspace"
    )


def _add_completion(commands: Commands) -> None:
    completion = _command(commands, "completion", "print a script that completes commands")
    completion.add_argument("shell", choices=("bash", "zsh", "tcsh"), help="the shell")


def _add_bench(commands: Commands) -> None:
    bench = _command(commands, "bench", "run the benchmarks of a checkout")
    bench.add_argument("name", nargs="?", help="one benchmark (default: all)")


# ── parts of commands ────────────────────────────────────────────────────────────────────────


def _command(commands: Commands, name: str, text: str) -> argparse.ArgumentParser:
    """Add a command with its one-line description."""
    hides = name in EVERYWHERE and name not in STORES
    command = commands.add_parser(
        name, help=text, description=text, epilog=HIDDEN if hides else None
    )
    command.set_defaults(command=name)
    return command


def _choices(command: argparse.ArgumentParser, kind: type) -> None:
    """Add a flag for each choice of a dataclass, see ``options.choice``."""
    for each in options_of(kind):
        how: dict[str, Any] = {"default": each.default, "help": each.definition.help}
        if each.kind is bool:
            how["action"] = "store_true"
        elif each.kind == bool | None:
            how["action"] = argparse.BooleanOptionalAction
        elif each.kind is float:
            how["type"] = _positive
        elif get_origin(each.kind) is Literal:
            how["choices"] = get_args(each.kind)
        command.add_argument(each.flag, **how)


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


# ── types of arguments ───────────────────────────────────────────────────────────────────────


def _setting(option: Option, text: str) -> Any:
    try:
        return option.parse(text)
    except BadInputError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _positive(text: str) -> float:
    value = _number(text)
    if not 0 < value < 1e6:
        raise argparse.ArgumentTypeError(f"expected a number above 0, got {text!r}")
    return value


def _share(text: str) -> float:
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


def _whole(wanted: str, least: int, most: int = UNBOUNDED) -> Callable[[str], int]:
    """Return a parser of integers from ``least`` to ``most``; ``wanted`` describes them."""

    def read(text: str) -> int:
        if not text.isdecimal() or not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(f"expected {wanted}, got {text!r}")
        return int(text)

    return read
