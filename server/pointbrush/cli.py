"""The ``pointbrush`` command: its grammar, and how it exits."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import get_type_hints

from pointbrush import __version__
from pointbrush import commands as do
from pointbrush.errors import PointbrushError
from pointbrush.settings import Settings, options

Command = Callable[[argparse.Namespace, Settings], None]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code: 0, 2 for a usage error, 1 for any other."""
    given = parser().parse_args(arguments)
    try:
        chosen = {o.name: getattr(given, o.name, None) for o in options()}
        command: Command = given.command
        command(given, Settings.load(chosen))
    except PointbrushError as error:
        print(f"pointbrush: {error}", file=sys.stderr)
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

    demo_ = _command(commands, "demo", do.demo, "make the sample recording and serve it")
    demo_.add_argument("--sample-frames", type=int, default=90, help="frames of the sample")
    _settings(demo_, *SERVE)

    import__ = _command(commands, "import", do.import_, "import files as one recording")
    import__.add_argument("paths", nargs="+", type=Path, metavar="PATH")
    import__.add_argument("--name", help="the recording's name")
    import__.add_argument("--fps", type=_positive, help="frames per second")
    import__.add_argument("--format", help="file format, where the name does not tell")
    import__.add_argument(
        "--drop-invalid", action="store_true", help="leave out points that are NaN or infinite"
    )
    _settings(import__, "workspace", "database", "max_frame_points")

    _settings(_command(commands, "serve", do.serve, "serve the page, REST and the socket"), *SERVE)

    track_ = _command(commands, "track", do.track, "carry labels through the following frames")
    track_.add_argument("sequence", metavar="SEQ")
    track_.add_argument("--from", dest="start", type=int, required=True, metavar="I")
    track_.add_argument("--to", dest="stop", type=int, required=True, metavar="J")
    track_.add_argument("--labels", help="names or ids, with commas; all in frame I unless given")
    track_.add_argument("--method", default="auto", help="icp, color-icp or auto")
    track_.add_argument("--overwrite", default="tracked", choices=("never", "tracked", "all"))
    track_.add_argument(
        "--continue-lost", action="store_true", help="look on for a label after it was lost"
    )
    track_.add_argument(
        "--until-painted", action="store_true", help="end a label where it is painted again"
    )
    track_.add_argument(
        "--stop-unsure", action="store_true", help="end the run where a label is doubtful"
    )
    _settings(track_, "workspace", "database", "workers", "scheduler")

    export_ = _command(commands, "export", do.export, "write points with their labels")
    export_.add_argument("sequence", metavar="SEQ")
    export_.add_argument("--format", required=True)
    export_.add_argument("--out", required=True, type=Path)
    export_.add_argument("--frames", metavar="I:J", help="J is not included")
    _settings(export_, "workspace", "database")

    info_ = _command(commands, "info", do.info, "what is in the workspace")
    info_.add_argument("sequence", nargs="?", metavar="SEQ")
    _settings(info_, "workspace", "database")

    token_ = _command(commands, "token", do.token, "who gets in")
    token_.add_argument("action", choices=("add", "list", "revoke"))
    token_.add_argument("name", nargs="?", help="the person (add) or the token's id (revoke)")
    token_.add_argument("--role", default="annotator")
    token_.add_argument("--days", type=_positive, help="days until it expires")
    _settings(token_, "workspace", "database")

    review_ = _command(commands, "review", do.review, "step through labels and doubts in viser")
    review_.add_argument("sequence", metavar="SEQ")
    review_.add_argument("--port", type=int, default=8081, help="port to listen on")
    _settings(review_, "workspace", "database")

    check_ = _command(commands, "check", do.check, "verify recordings, journal and annotations")
    check_.add_argument("sequence", nargs="?", metavar="SEQ")
    _settings(check_, "workspace", "database")

    backup_ = _command(commands, "backup", do.backup, "copy a workspace, also one that is in use")
    backup_.add_argument("target", type=Path)
    _settings(backup_, "workspace", "database")

    restore_ = _command(commands, "restore", do.restore, "make a workspace from a backup")
    restore_.add_argument("source", type=Path)
    _settings(restore_, "workspace")

    bench_ = _command(commands, "bench", do.bench, "run the benchmarks of a checkout")
    bench_.add_argument("name", nargs="?", help="one of them; all unless given")
    return top


SERVE = (
    "workspace", "host", "port", "token", "database", "workers", "scheduler", "tls", "certfile",
    "keyfile", "insecure", "import_roots", "allowed_hosts", "max_upload", "max_frame_points",
)  # fmt: skip


def _command(
    commands: argparse._SubParsersAction[argparse.ArgumentParser],
    name: str,
    function: Command,
    text: str,
) -> argparse.ArgumentParser:
    command = commands.add_parser(name, help=text, description=text)
    command.set_defaults(command=function)
    return command


def _settings(command: argparse.ArgumentParser, *names: str) -> None:
    types = get_type_hints(Settings)
    for option in options():
        if option.name not in names:
            continue
        flag = f"--{option.name.replace('_', '-')}"
        text = f"{option.metadata['help']} (default: {option.default or 'see help'})"
        if types[option.name] is bool:
            command.add_argument(flag, action="store_true", default=None, help=text)
        else:
            command.add_argument(flag, type=types[option.name], default=None, help=text)


def _positive(text: str) -> float:
    value = float(text)
    if not 0 < value < 1e6:
        raise argparse.ArgumentTypeError(f"expected a number above 0, got {text}")
    return value


if __name__ == "__main__":
    raise SystemExit(main())
