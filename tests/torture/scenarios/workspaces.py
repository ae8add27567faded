"""Files of a workspace are damaged, and looked at and repaired by the commands."""

from __future__ import annotations

import random
import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import numpy as np

from pointbrush.classify.classifier import Classifier
from pointbrush.classify.forest import Trees
from pointbrush.commands.following import follow
from pointbrush.settings import Settings
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.work.classifiers.files import ClassifierFiles
from pointbrush.workspace import Workspace
from tests.faults.clients import FRAMES, SEQUENCE
from tests.faults.server import running
from tests.forked import run
from tests.formats.test_pictures import described
from tests.torture.authors import Authors, quiet
from tests.torture.framework import Arena, Tally, scenario

Change = Callable[[bytes, random.Random], bytes | None]
PAGE = 4096
DATABASE = "labels.sqlite"
OTHER = "room"
STROKE = {"label": 1, "radius": 0.2, "samples": [{"origin": [0.0, 0.0, 1.0]}]}


def _flip(content: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(content))
    return content[:at] + bytes([content[at] ^ 1 << rng.randrange(8)]) + content[at + 1 :]


def _blank_page(content: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(0, len(content), PAGE)
    return content[:at] + bytes(len(content[at : at + PAGE])) + content[at + PAGE :]


CHANGES: dict[str, Change] = {
    "missing": lambda _, __: None,
    "empty": lambda _, __: b"",
    "cut": lambda content, _: content[: len(content) // 2],
    "zeros": lambda content, _: bytes(len(content)),
    "first byte": lambda content, _: bytes([content[0] ^ 0xFF]) + content[1:],
    "bit": _flip,
    "page": _blank_page,
}
SEEN = {"missing", "empty", "cut", "zeros", "first byte"}
"""Changes that are found in a database; others can hit bytes that nothing reads."""


@contextmanager
def damaged(path: Path, change: Change, rng: random.Random) -> Iterator[None]:
    """A file is changed until the context ends."""
    content = path.read_bytes()
    changed = change(content, rng)
    if changed is None:
        path.unlink()
    else:
        path.write_bytes(changed)
    try:
        yield
    finally:
        path.write_bytes(content)


def _prepare(workspace: Path) -> None:
    """Add a recording with pictures and a classifier."""
    inbox = workspace.parent / "inbox"
    inbox.mkdir()
    with closing(Workspace(Settings(workspace=workspace, workers=1))) as opened:
        follow(opened.jobs.get, opened.imports.begin([described(inbox / OTHER)], name=OTHER))
    trees = Trees(
        np.array([0, -1, -1], np.int16), np.zeros(3, np.float32), np.array([1, 0, 1], np.int32),
        np.zeros(1, np.int32), np.eye(2, dtype=np.float32),
    )  # fmt: skip
    kept = ClassifierFiles(workspace / "classifiers")
    kept.write("own", Classifier("own", ("a", "b"), 0.5, trees=trees))


def _look(workspace: Path, file: str, tally: Tally, *, found: bool, kind: str) -> None:
    """Run the commands; ``found``: ``check`` must name the file, before a repair and after it."""
    where = ("--workspace", str(workspace))
    for command in (("info",), ("info", SEQUENCE), ("check",), ("check", "--repair")):
        done = run(*command, *where)
        said = f"{file}, {kind}: {' '.join(command)}: {done.stdout}{done.stderr}"
        if "Traceback" in said or done.returncode not in (0, 1):
            tally.count("errors", f"{done.returncode}: {said}")
        elif command[0] == "check" and found:
            _require_named(done, file, tally, said)


def _require_named(
    done: subprocess.CompletedProcess[str], file: str, tally: Tally, said: str
) -> None:
    rebuilt = "rebuilt: " in done.stdout or "removed, " in done.stdout
    if (done.returncode == 0 and not rebuilt) or file not in done.stdout + done.stderr:
        tally.count("differs", said)
    elif done.returncode == 0:
        tally.answered += 1
    else:
        tally.damaged += 1


def _files_of(workspace: Path) -> dict[str, bytes]:
    """Content of the files of recordings and classifiers."""
    roots = (workspace / "sequences", workspace / "classifiers")
    found = (file for root in roots for file in root.rglob("*") if file.is_file())
    return {str(file.relative_to(workspace)): file.read_bytes() for file in found}


@scenario("files of a workspace are damaged, looked at and repaired, while six authors edit", 2)
def workspace_damaged(arena: Arena) -> None:
    """The commands name each damaged file; the authors' recording and all sound files stay."""
    workspace, tally = arena.folder / "workspace", arena.tally
    authors = Authors(workspace, arena.seed)
    _prepare(workspace)
    sound = _files_of(workspace)
    files = [name for name in sound if not name.startswith(f"sequences/{SEQUENCE}/")]
    cases = [(name, kind) for name in files for kind in CHANGES]
    arena.rng.shuffle(cases)
    server = arena.stack.enter_context(running(workspace))
    for number in arena.rounds():
        name, kind = cases[number % len(cases)]
        found = not name.startswith("classifiers") or kind in SEEN - {"missing"}
        with (
            authors.editing(lambda: [server.url]),
            damaged(workspace / name, CHANGES[kind], arena.rng),
        ):
            short = name.split("/", 2)[-1]
            _look(workspace, short, tally, found=found, kind=kind)
        changed = {each for each, content in _files_of(workspace).items() if sound[each] != content}
        if changed:
            tally.count("lost", f"{name}, {kind}: other bytes in {changed}")
        authors.settle(server, tally)
    quiet(server, tally)


@scenario("the database file of a workspace is damaged, looked at and repaired", 1)
def database_damaged(arena: Arena) -> None:
    """Labels are those that were painted, or the damage is told."""
    workspace, tally = arena.folder / "workspace", arena.tally
    authors = Authors(workspace, arena.seed)
    with closing(Workspace(Settings(workspace=workspace, workers=1))) as opened:
        for frame in range(FRAMES):
            opened.strokes.apply(SEQUENCE, frame, STROKE, authors.people[0].name)
    painted = _labels(workspace)
    copy = arena.folder / "copy"
    for number in arena.rounds():
        kinds = list(CHANGES)
        kind = kinds[number % len(kinds)]
        shutil.copytree(workspace, copy)
        with damaged(copy / DATABASE, CHANGES[kind], arena.rng):
            _look(copy, DATABASE, tally, found=kind in SEEN, kind=kind)
            if run("check", "--workspace", str(copy)).returncode == 0 and _labels(copy) != painted:
                tally.count("lost", f"labels after {kind} that is called sound")
        shutil.rmtree(copy)


def _labels(workspace: Path) -> list[bytes]:
    """Return the stored labels of each frame."""
    with closing(WorkspaceStore(f"sqlite:///{workspace / DATABASE}")) as store:
        return [store.values(SEQUENCE, frame).label.tobytes() for frame in range(FRAMES)]
