"""The ``pointbrush`` command: its grammar, and how it exits."""

from __future__ import annotations

import argparse
import gc
import math
import sys
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from functools import partial
from importlib import import_module
from keyword import iskeyword
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from pointbrush import __version__
from pointbrush.errors import BadInputError, PointbrushError
from pointbrush.formats.corrections import Corrections
from pointbrush.options import UNBOUNDED, Option, hide_password, options_of
from pointbrush.permissions import private_files
from pointbrush.printing import Answer
from pointbrush.roles import ROLES
from pointbrush.settings import GROUPS, REMOTE, Settings, options
from pointbrush.work.imports.options import SAMPLES, LabelOptions
from pointbrush.work.tracking.options import RunOptions

Command = Callable[[argparse.Namespace, Settings], Answer | None]
COLLECT_AFTER = (10_000, 20, 20)
"""Objects more than before until the youngest are looked through, and how often the older are:
modules and models are 160,000 that stay, and to import them is a third slower at Python's own."""
SEQUENCE = "a recording's id, as `pointbrush info` lists it"
SERVING = ("demo", "serve", "review")
"""Commands that go on until they are interrupted; the others answer, with ``--json`` as JSON."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code: 0, 2 for a usage error, 1 for any other."""
    grammar = parser()
    given = grammar.parse_args(arguments)
    try:
        if given.command == "completion":
            import shtab

            print(shtab.complete(grammar, given.shell))
            return 0
        if arguments is None:
            hide_password(given.database if "database" in given else None)
        settings = Settings.load({o.name: getattr(given, o.name, None) for o in options()})
        remote = settings.server and given.command in REMOTE
        # Here, since help and usage errors need none of it.
        gc.set_threshold(*COLLECT_AFTER)
        module = import_module("pointbrush.remote" if remote else "pointbrush.commands")
        command: Command = getattr(module, _function(given.command))
        # What is exported is its user's to share.
        with nullcontext() if given.command in ("export", "report") else private_files():
            answer = command(given, settings)
        if answer is not None:
            answer.show(as_json=given.json)
            if answer.error:
                raise PointbrushError(answer.error)
    except PointbrushError as error:
        print(f"pointbrush: {error.whole}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("pointbrush: interrupted", file=sys.stderr)
        return 1
    except BrokenPipeError:
        return 1
    return 0


def parser() -> argparse.ArgumentParser:
    """The command line's grammar."""
    top = argparse.ArgumentParser(prog="pointbrush", description="Label point cloud recordings.")
    top.add_argument("--version", action="version", version=f"pointbrush {__version__}")
    commands = top.add_subparsers(title="commands", required=True, metavar="COMMAND")

    demo_ = _command(commands, "demo", "make the sample recording and serve it")
    demo_.add_argument(
        "--sample-frames",
        type=_whole("an integer from 1", 1),
        default=90,
        help="frames of the sample",
    )
    demo_.add_argument(
        "--sample", choices=SAMPLES, default="juggling", help="what is made (default: juggling)"
    )

    import__ = _command(commands, "import", "import files as one recording")
    import__.add_argument(
        "paths", nargs="+", type=Path, metavar="PATH", help="files, folders, globs or archives"
    )
    import__.add_argument("--name", help="the recording's name")
    import__.add_argument(
        "--each", action="store_true", help="each file or folder in PATH is a recording"
    )
    import__.add_argument("--project", default="default", metavar="P", help="the project to join")
    import__.add_argument("--fps", type=_positive, help="frames per second")
    _choices(import__, Corrections)
    import__.add_argument(
        "--dry-run", action="store_true", help="say what would be imported, write nothing"
    )

    labels_ = _command(commands, "import-labels", "import labels made elsewhere, as one edit")
    labels_.add_argument("sequence", metavar="SEQ", help=SEQUENCE)
    labels_.add_argument(
        "path",
        type=Path,
        nargs="?",
        metavar="PATH",
        help="a file or folder of labels; none: those of the recording's own files, which did not "
        "come in with it",
    )
    labels_.add_argument(
        "--map",
        type=Path,
        metavar="FILE",
        help="names of classes: JSON, YAML, XML, or lines 'number name'",
    )
    _choices(labels_, LabelOptions)
    labels_.add_argument("--dry-run", action="store_true", help="say what is found, write nothing")

    _command(commands, "serve", "serve the page, REST and the socket")

    track_ = _command(commands, "track", "carry labels through the following frames")
    track_.add_argument("sequence", metavar="SEQ", help=SEQUENCE)
    frame = _whole("a frame number from 0", 0)
    track_.add_argument(
        "--from", dest="start", type=frame, required=True, metavar="I", help="a painted frame"
    )
    track_.add_argument(
        "--to", dest="stop", type=frame, required=True, metavar="J",
        help="the last frame; before I tracks backward",
    )  # fmt: skip
    track_.add_argument("--labels", help="names or ids, with commas; all in frame I unless given")
    _choices(track_, RunOptions)

    fit_ = _command(commands, "fit-boxes", "fit a box to the points of each label, over all frames")
    fit_.add_argument("sequence", metavar="SEQ", help=SEQUENCE)
    fit_.add_argument("--labels", help="names or ids, with commas; all unless given")
    fit_.add_argument("--category", help="labels of it alone")
    fit_.add_argument("--frames", metavar="I:J", help="frames I to J - 1; all unless given")
    fit_.add_argument("--redraw", action="store_true", help="fit what somebody drew anew, too")

    example_ = _command(
        commands, "example", "teach a classifier by what is painted, and have it label the rest"
    )
    example_.add_argument("sequence", nargs="?", metavar="SEQ", help=f"{SEQUENCE}; it teaches")
    example_.add_argument("--classifier", metavar="ID", help="one that there is, not a new one")
    example_.add_argument("--name", help="of a new one (default: the recording's id)")
    example_.add_argument("--classes", help="with commas (default: all of the palette)")
    example_.add_argument(
        "--model", default="", metavar="NAME", help="plug-in or service that answers for a new one"
    )
    example_.add_argument(
        "--imported",
        action="store_true",
        help="imported labels teach a new one beside painted ones",
    )
    example_.add_argument(
        "--apply", metavar="I:J", help="label frames I to J - 1, or all, where nobody did"
    )
    example_.add_argument(
        "--above", type=_share, default=0.0, help="least confidence of what is labelled, 0 to 1"
    )
    example_.add_argument("--save", type=Path, metavar="FILE", help="write the classifier there")
    example_.add_argument("--load", type=Path, metavar="FILE", help="take in what --save wrote")
    example_.add_argument("--delete", action="store_true", help="delete the classifier")

    export_ = _command(commands, "export", "write points with their labels")
    export_.add_argument("sequence", metavar="SEQ", help=SEQUENCE)
    export_.add_argument("--format", required=True, help="see docs/formats-written.md")
    export_.add_argument("--out", required=True, type=Path, help="folder or file to write")
    export_.add_argument("--frames", metavar="I:J", help="frames I to J - 1 (default: all)")
    export_.add_argument("--snapshot", metavar="NAME", help="labels as they were then")
    export_.add_argument(
        "--above", type=_share, default=0.0,
        help="leave out predicted labels of a confidence, 0 to 1, below it",
    )  # fmt: skip
    export_.add_argument(
        "--val",
        metavar="I:J|SEQ,…|none",
        help="frames, or recordings, for validation in formats for training (default: about one "
        "recording in five by its id, never all)",
    )

    info_ = _command(commands, "info", "what is in the workspace")
    info_.add_argument("sequence", nargs="?", metavar="SEQ", help=SEQUENCE)

    token_ = _command(commands, "token", "who gets in")
    token_.add_argument("action", choices=("add", "list", "revoke"), help="what to do")
    token_.add_argument("name", nargs="?", help="the person (add) or the token's id (revoke)")
    token_.add_argument("--role", default="annotator", help=f"one of {', '.join(ROLES)}")
    token_.add_argument("--days", type=_positive, help="days until it expires")

    review_ = _command(commands, "review", "step through labels and doubts in viser")
    review_.add_argument("sequence", metavar="SEQ", help=SEQUENCE)
    review_.add_argument(
        "--port",
        type=_whole("a port from 1 to 65535", 1, 65_535),
        default=8081,
        help="port to listen on",
    )
    review_.add_argument(
        "--explain",
        type=_whole("a label's number", 1, 65_535),
        metavar="LABEL",
        help="show step by step how this label is found in each frame",
    )
    review_.add_argument(
        "--method", choices=("auto", "icp", "color-icp"), default="auto", help="that finds it"
    )

    check_ = _command(commands, "check", "verify recordings, database, journal and annotations")
    check_.add_argument("sequence", nargs="?", metavar="SEQ", help=SEQUENCE)
    check_.add_argument(
        "--repair",
        action="store_true",
        help="make anew what can be (indexes, snapshots, counts, palette, tracks, missing "
        "checksums) and say what cannot; stop servers first",
    )

    suspicious = _command(commands, "check-labels", "list suspicious labels, frame by frame")
    suspicious.add_argument("sequence", metavar="SEQ", help=SEQUENCE)
    suspicious.add_argument("--frames", metavar="I:J", help="frames I to J - 1 (default: all)")
    suspicious.add_argument("--fail", action="store_true", help="exit with 1 where there are any")
    suspicious.add_argument("--all", action="store_true", help="what a reviewer has accepted too")

    compare_ = _command(commands, "compare", "compare the labels of two recordings of one scene")
    compare_.add_argument("sequence", metavar="SEQ", help=f"{SEQUENCE}; of boxes it is the truth")
    compare_.add_argument("other", metavar="SEQ2", help="a recording of the same points")
    compare_.add_argument("--frames", metavar="I:J", help="frames I to J - 1 (default: all)")
    compare_.add_argument(
        "--boxes", action="store_true", help="boxes by class: AP, precision, recall, HOTA"
    )

    report_ = _command(commands, "report", "write how far a recording is, and who spent what")
    report_.add_argument("sequence", metavar="SEQ", help=SEQUENCE)
    report_.add_argument("--out", required=True, type=Path, help="a file: .html, or .csv")
    report_.add_argument(
        "--table", choices=("frames", "labels", "people"), default="frames", help="of a .csv"
    )

    for name, text in (
        ("labels", "list the labels of a recording"),
        ("delete", "delete a recording; it can be brought back for 30 days"),
        ("undelete", "bring a deleted recording back"),
        ("rename", "give a recording another name; its id stays"),
    ):
        command_ = _command(commands, name, text)
        command_.add_argument("sequence", metavar="SEQ", help=SEQUENCE)
        if name == "rename":
            command_.add_argument("name", metavar="NAME", help="the new one")

    headset_ = _command(
        commands, "headset-report", "say what a file of the page /check-headset tells of a headset"
    )
    headset_.add_argument("file", type=Path, metavar="FILE", help="downloaded from that page")

    backup_ = _command(commands, "backup", "copy a workspace, also one that is in use")
    backup_.add_argument(
        "target",
        nargs="?",
        type=Path,
        help="a folder that does not exist yet; none: a dated one in --backup-to",
    )
    backup_.add_argument(
        "--if-older", metavar="TIME", help="only if the newest there is older, as 90m, 24h or 7d"
    )

    restore_ = _command(commands, "restore", "make a workspace from a backup")
    restore_.add_argument("source", type=Path, help="the folder of a backup")
    restore_.add_argument(
        "--only", metavar="SEQ", help="bring this recording alone back, into a workspace in use"
    )

    move_ = _command(commands, "move", "move the labels into another database")
    move_.add_argument(
        "target", metavar="URL", help="postgresql://host/name, or 'sqlite': in the workspace"
    )

    for name, command in commands.choices.items():
        _add_settings(name, command)
        if name not in SERVING:
            command.add_argument("--json", action="store_true", help="answer as one JSON document")

    completion_ = _command(commands, "completion", "print what completes commands in a shell")
    completion_.add_argument("shell", choices=("bash", "zsh", "tcsh"), help="the shell")

    bench_ = _command(commands, "bench", "run the benchmarks of a checkout")
    bench_.add_argument("name", nargs="?", help="one of them; all unless given")
    return top


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


def _function(command: str) -> str:
    """The name in ``pointbrush.commands`` of what a command does."""
    name = command.replace("-", "_")
    return f"{name}_" if iskeyword(name) else name


def _command(
    commands: argparse._SubParsersAction[argparse.ArgumentParser],
    name: str,
    text: str,
) -> argparse.ArgumentParser:
    command = commands.add_parser(name, help=text, description=text)
    command.set_defaults(command=name)
    return command


def _add_settings(name: str, command: argparse.ArgumentParser) -> None:
    """Add the flags that a command takes in their groups, see ``Settings``."""
    taken = [option for option in options() if option.taken_by(name)]
    for title in GROUPS:
        group = command.add_argument_group(title)
        for option in taken:
            if option.definition.group == title:
                _add_setting(group, option)


def _add_setting(group: argparse._ArgumentGroup, option: Option) -> None:
    text = option.definition.help
    if option.kind is bool:
        group.add_argument(option.flag, action="store_true", default=None, help=text)
        return
    text += f" (default: {option.shown_default})" if option.shown_default else ""
    group.add_argument(option.flag, type=partial(_setting, option), default=None, help=text)


def _setting(option: Option, text: str) -> Any:
    try:
        return option.parse(text)
    except BadInputError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < 1e6:
        raise argparse.ArgumentTypeError(f"expected a number above 0, got {text!r}")
    return value


def _share(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 <= value <= 1:
        raise argparse.ArgumentTypeError(f"expected a number from 0 to 1, got {text!r}")
    return value


def _whole(wanted: str, least: int, most: int = UNBOUNDED) -> Callable[[str], int]:
    """Return a parser of integers from ``least`` to ``most``, ``wanted`` in words."""

    def read(text: str) -> int:
        if not text.isdecimal() or not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(f"expected {wanted}, got {text!r}")
        return int(text)

    return read


if __name__ == "__main__":
    raise SystemExit(main())
