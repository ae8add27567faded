"""The ``pointbrush`` command: parse, call the workspace, print."""

from __future__ import annotations

import argparse
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import closing, suppress
from pathlib import Path
from typing import Any, get_type_hints

from pointbrush import __version__
from pointbrush.errors import BadInputError, PointbrushError
from pointbrush.progress import follow
from pointbrush.settings import Settings, options
from pointbrush.work.backup import restore_backup
from pointbrush.workspace import Workspace

Command = Callable[[argparse.Namespace, Settings], None]
AUTHOR = "command line"


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

    demo_ = _command(commands, "demo", demo, "make the sample recording and serve it")
    demo_.add_argument("--sample-frames", type=int, default=90, help="frames of the sample")
    _settings(demo_, *SERVE)

    import__ = _command(commands, "import", import_, "import files as one recording")
    import__.add_argument("paths", nargs="+", type=Path, metavar="PATH")
    import__.add_argument("--name", help="the recording's name")
    import__.add_argument("--fps", type=_positive, help="frames per second")
    import__.add_argument("--format", help="file format, where the name does not tell")
    import__.add_argument(
        "--drop-invalid", action="store_true", help="leave out points that are NaN or infinite"
    )
    _settings(import__, "workspace", "database", "max_frame_points")

    _settings(_command(commands, "serve", serve, "serve the page, REST and the socket"), *SERVE)

    track_ = _command(commands, "track", track, "carry labels through the following frames")
    track_.add_argument("sequence", metavar="SEQ")
    track_.add_argument("--from", dest="start", type=int, required=True, metavar="I")
    track_.add_argument("--to", dest="stop", type=int, required=True, metavar="J")
    track_.add_argument("--labels", help="names or ids, with commas; all in frame I unless given")
    track_.add_argument("--method", default="auto", help="icp, color-icp or auto")
    track_.add_argument("--overwrite", default="tracked", choices=("never", "tracked", "all"))
    _settings(track_, "workspace", "database", "workers")

    export_ = _command(commands, "export", export, "write points with their labels")
    export_.add_argument("sequence", metavar="SEQ")
    export_.add_argument("--format", required=True)
    export_.add_argument("--out", required=True, type=Path)
    export_.add_argument("--frames", metavar="I:J", help="J is not included")
    _settings(export_, "workspace", "database")

    info_ = _command(commands, "info", info, "what is in the workspace")
    info_.add_argument("sequence", nargs="?", metavar="SEQ")
    _settings(info_, "workspace", "database")

    token_ = _command(commands, "token", token, "who gets in")
    token_.add_argument("action", choices=("add", "list", "revoke"))
    token_.add_argument("name", nargs="?", help="the person (add) or the token's id (revoke)")
    token_.add_argument("--role", default="annotator")
    token_.add_argument("--days", type=_positive, help="days until it expires")
    _settings(token_, "workspace", "database")

    review_ = _command(commands, "review", review, "step through labels and doubts in viser")
    review_.add_argument("sequence", metavar="SEQ")
    review_.add_argument("--port", type=int, default=8081, help="port to listen on")
    _settings(review_, "workspace", "database")

    check_ = _command(commands, "check", check, "verify recordings, journal and annotations")
    check_.add_argument("sequence", nargs="?", metavar="SEQ")
    _settings(check_, "workspace", "database")

    backup_ = _command(commands, "backup", backup, "copy a workspace, also one that is in use")
    backup_.add_argument("target", type=Path)
    _settings(backup_, "workspace", "database")

    restore_ = _command(commands, "restore", restore, "make a workspace from a backup")
    restore_.add_argument("source", type=Path)
    _settings(restore_, "workspace")

    bench_ = _command(commands, "bench", bench, "run the benchmarks of a checkout")
    bench_.add_argument("name", nargs="?", help="one of them; all unless given")
    return top


SERVE = (
    "workspace", "host", "port", "token", "database", "workers", "tls", "certfile", "keyfile",
    "insecure", "import_roots", "allowed_hosts", "max_upload", "max_frame_points",
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


def demo(given: argparse.Namespace, settings: Settings) -> None:
    """Make the sample recording once, then serve it."""
    from pointbrush.web.server import run

    if given.sample_frames < 1:
        raise BadInputError(f"--sample-frames: expected 1 or more, got {given.sample_frames}")
    with closing(Workspace(settings)) as workspace:
        if not any(manifest.source.startswith("sample") for manifest in workspace.sequences()):
            job = workspace.import_sample(frames=given.sample_frames)
            follow(workspace, job)
        # Ctrl+C is how a server ends; it drains first, and that is no failure.
        with suppress(KeyboardInterrupt):
            run(workspace, settings)


def serve(given: argparse.Namespace, settings: Settings) -> None:  # noqa: ARG001
    """Serve the workspace until interrupted."""
    from pointbrush.web.server import run

    with closing(Workspace(settings)) as workspace, suppress(KeyboardInterrupt):
        run(workspace, settings)


def import_(given: argparse.Namespace, settings: Settings) -> None:
    """Import files as one recording and print its id."""
    with closing(Workspace(settings)) as workspace:
        job = workspace.import_paths(
            given.paths,
            name=given.name,
            fps=given.fps,
            file_format=given.format,
            drop_invalid=given.drop_invalid,
        )
        result = follow(workspace, job)
        dropped = f", {result['dropped']:,} invalid left out" if result["dropped"] else ""
        print(
            f"imported {result['sequence']}: {result['frames']} frames, "
            f"{result['points']:,} points{dropped}"
        )


def track(given: argparse.Namespace, settings: Settings) -> None:
    """Track labels and print how it ended."""
    with closing(Workspace(settings)) as workspace:
        labels = None
        if given.labels:
            labels = [_label(workspace, given.sequence, text) for text in given.labels.split(",")]
        job = workspace.track(
            given.sequence,
            start=given.start,
            stop=given.stop,
            labels=labels,
            method=given.method,
            overwrite=given.overwrite,
            author=AUTHOR,
        )
        result = follow(workspace, job)
        print(f"tracked {result['frames']} frames, {result['changed']:,} points labelled")


def _label(workspace: Workspace, sequence: str, text: str) -> int:
    for label in workspace.palette(sequence):
        if text in (label.name, str(label.id)):
            return label.id
    raise BadInputError(f"--labels: expected names or ids of the palette, got {text!r}")


def export(given: argparse.Namespace, settings: Settings) -> None:
    """Export a sequence to a folder or file."""
    with closing(Workspace(settings)) as workspace:
        workspace.export(given.sequence, given.format, given.out, given.frames)
        print(f"exported {given.sequence} to {given.out}")


def info(given: argparse.Namespace, settings: Settings) -> None:
    """List the recordings, or describe one."""
    with closing(Workspace(settings)) as workspace:
        if given.sequence is None:
            for manifest in workspace.sequences():
                print(
                    f"{manifest.id}\t{manifest.frames} frames\t{manifest.fps:g} fps\t"
                    f"{sum(manifest.points):,} points\t{manifest.name}"
                )
            return
        manifest = workspace.recording(given.sequence).manifest
        facts: dict[str, Any] = {
            "id": manifest.id,
            "name": manifest.name,
            "source": manifest.source,
            "frames": manifest.frames,
            "fps": manifest.fps,
            "points": f"{min(manifest.points):,} to {max(manifest.points):,} a frame",
            "fields": ", ".join(manifest.fields),
            "revision": workspace.store.revision(manifest.id),
        }
        for name, value in facts.items():
            print(f"{name:10} {value}")
        for label in workspace.palette(given.sequence):
            print(f"label {label.id:<4} {label.color} {label.name}")


def token(given: argparse.Namespace, settings: Settings) -> None:
    """Add, list or revoke tokens."""
    with closing(Workspace(settings)) as workspace:
        tokens = workspace.store.tokens
        if given.action == "list":
            for entry in tokens.list():
                status = "valid" if entry.valid else "revoked" if entry.revoked else "expired"
                print(f"{entry.id}\t{entry.role}\t{entry.name}\t{status}")
            return
        if not given.name:
            raise BadInputError(f"token {given.action}: expected a name, got none")
        if given.action == "revoke":
            tokens.revoke(given.name)
            print(f"revoked {given.name}")
        else:
            expires = None if given.days is None else time.time() + given.days * 86_400
            print(tokens.add(given.role, given.name, expires))


def review(given: argparse.Namespace, settings: Settings) -> None:
    """Serve the review panel on loopback until interrupted."""
    from pointbrush.review.panel import ReviewPanel

    with (
        closing(Workspace(settings)) as workspace,
        closing(ReviewPanel(workspace, given.sequence, port=given.port)) as panel,
    ):
        print(f"pointbrush review at http://127.0.0.1:{panel.port}/", flush=True)
        threading.Event().wait()


def check(given: argparse.Namespace, settings: Settings) -> None:
    """Print what is wrong in the workspace; an error when anything is."""
    with closing(Workspace(settings)) as workspace:
        wanted = [given.sequence] if given.sequence else [m.id for m in workspace.sequences()]
        problems = [f"{name}: {line}" for name in wanted for line in workspace.check(name)]
        for problem in problems:
            print(problem)
        if problems:
            raise PointbrushError(f"{len(problems)} problems found")
        print(f"{len(wanted)} recordings and their labels are sound")


def backup(given: argparse.Namespace, settings: Settings) -> None:
    """Copy recordings and labels into a new folder."""
    with closing(Workspace(settings)) as workspace:
        workspace.backup(given.target)
    print(f"backed up to {given.target}")


def restore(given: argparse.Namespace, settings: Settings) -> None:
    """Bring a backup back as a new workspace."""
    restore_backup(given.source, settings.workspace)
    print(f"restored to {settings.workspace}")


def bench(given: argparse.Namespace, settings: Settings) -> None:  # noqa: ARG001
    """Run benchmarks/bench_*.py one after the other."""
    folder = Path(__file__).parent.parent.parent / "benchmarks"
    scripts = {path.stem.removeprefix("bench_"): path for path in folder.glob("bench_*.py")}
    if not scripts:
        raise BadInputError("bench: expected to run from a checkout of pointbrush")
    if given.name is not None and given.name not in scripts:
        raise BadInputError(f"bench: expected one of {', '.join(sorted(scripts))}")
    for name in [given.name] if given.name else sorted(scripts):
        print(f"== {name}", flush=True)
        if subprocess.run([sys.executable, scripts[name]], check=False).returncode:
            raise PointbrushError(f"benchmark {name} failed")


if __name__ == "__main__":
    raise SystemExit(main())
