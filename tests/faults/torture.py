"""Kill the server again and again while people edit, and look what is left."""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.teamwork.store import WorkspaceStore
from tests.faults.clients import FRAMES, SEQUENCE, Person
from tests.faults.replay import Replay
from tests.faults.server import ServerProcess
from tests.forked import run

NAMES = ["ann", "bob", "cat", "dan"]


@dataclass
class Summary:
    """What a torture came to."""

    kills: int
    edits: int
    runs: int
    resent: int
    applied: int
    """Edits without an answer that had been committed."""
    seconds: float

    def __str__(self) -> str:
        return (
            f"{self.kills} kills, {self.edits} edits of {len(NAMES)} people, {self.runs} tracking "
            f"runs; {self.resent} edits without an answer, {self.applied} of them committed; "
            f"every answered edit there, nothing half-applied, sound; {self.seconds:.0f} s"
        )


def make_workspace(workspace: Path) -> None:
    """A ball before a wall, moving 2 cm a frame; 400 points a frame."""
    rng = np.random.default_rng(0)
    wall = np.column_stack([rng.uniform(-0.5, 0.5, (280, 2)), np.full(280, 1.3)])
    ball = rng.normal(size=(120, 3))
    ball *= 0.1 / np.linalg.norm(ball, axis=1, keepdims=True)

    def frame(i: int) -> PointFrame:
        xyz = np.concatenate([wall, ball + [0.02 * i, 0, 1]])
        return PointFrame(xyz=xyz[rng.permutation(len(xyz))].astype(np.float32))

    import_frames(
        (frame(i) for i in range(FRAMES)),
        workspace / "sequences" / SEQUENCE,
        RecordingInfo(SEQUENCE, SEQUENCE, 10),
    )


def invite(
    workspace: Path, seed: int, *, names: Sequence[str] = NAMES, database: str = ""
) -> list[Person]:
    """People with tokens of their own, every other one at the socket; and three labels."""
    store = WorkspaceStore(database or f"sqlite:///{workspace / 'labels.sqlite'}")
    store.recordings.register(SEQUENCE, [400] * FRAMES)
    for name in ("one", "two", "three"):
        store.create_label(SEQUENCE, "setup", name=name)
    people = [
        Person(name, store.tokens.add("annotator", name, None), i % 2 == 1, random.Random(seed + i))
        for i, name in enumerate(names)
    ]
    store.close()
    return people


def edit_and_kill(server: ServerProcess, people: list[Person], seconds: float) -> None:
    """Everybody edits at once; the server is killed meanwhile."""
    never = threading.Event()
    threads = [threading.Thread(target=one.work, args=(server.url, never)) for one in people]
    for thread in threads:
        thread.start()
    time.sleep(seconds)
    server.kill()
    for thread in threads:
        thread.join(60)
        assert not thread.is_alive(), "a client that does not notice the server's end"
    for one in people:
        if one.fault is not None:
            raise one.fault
        assert not one.away, "503 from a server whose parts are all there"


def check(workspace: Path) -> None:
    """`pointbrush check` says sound."""
    said = run("check", "--workspace", str(workspace))
    assert said.returncode == 0, said.stdout + said.stderr
    assert "sound" in said.stdout


def torture(
    workspace: Path, kills: int, seed: int, *, check_every: int = 25, most_seconds: float = 3600
) -> Summary:
    """Raises AssertionError where a promise is broken."""
    started = time.monotonic()
    make_workspace(workspace)
    people = invite(workspace, seed)
    replay = Replay(workspace)
    rng = random.Random(seed)
    resent = applied = done = 0
    while True:
        server = ServerProcess(workspace)
        try:
            with server.api() as api:
                replay.check(api, people)
            waiting = [one.waiting for one in people if one.waiting is not None]
            resent += len(waiting)
            applied += sum(asked.revision is not None for asked in waiting)
            if done == kills or time.monotonic() - started > most_seconds:
                break
            # Mostly soon; now and then long enough for a tracking run to end.
            edit_and_kill(
                server, people, rng.choice([0.1, 0.3, 0.6, 1.0, 3.0]) * rng.random() + 0.05
            )
            done += 1
        finally:
            server.kill()
        if done % check_every == 0:
            check(workspace)
    check(workspace)
    return Summary(done, replay.edits, replay.runs, resent, applied, time.monotonic() - started)
