"""The label store: a durable stroke in an empty sequence and after 100,000 edits, side by side.

python benchmarks/bench_labels.py [--edits 100000] [--strokes 500] [--database URL]
"""

from __future__ import annotations

import argparse
import itertools
import sqlite3
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pointbrush.labels import Write
from pointbrush.labels.draft import Draft
from pointbrush.labels.journal import Entry
from pointbrush.teamwork.store import WorkspaceStore

POINTS = 217_088
FRAMES = 90
AUTHORS = [f"person {number}" for number in range(4)]
BATCH = 1_000
NUMBERS = itertools.count()


def stroke(rng: np.random.Generator, runs: int, length: int) -> NDArray[np.int64]:
    """Points as a ball has them in progressive order: short runs in every level of a frame."""
    starts = np.sort(rng.integers(0, POINTS - length, runs))
    return np.unique((starts[:, None] + np.arange(length)).ravel())


def fill(store: WorkspaceStore, sequence: str, edits: int) -> None:
    """Give a sequence a long history, many edits in a transaction; half of it in frame 0."""
    sessions = store._open_recordings
    rng = np.random.default_rng(1)
    with sessions.knowing(sequence) as state:
        pass
    for start in range(0, edits, BATCH):
        with state.lock, store.database.write() as connection:
            for number in range(start, min(start + BATCH, edits)):
                draft = Draft(connection, state)
                frame = 0 if number % 2 else int(rng.integers(1, FRAMES))
                write = Write(stroke(rng, 3, 20), label=1 + number % 3, provenance=1)
                draft.write(frame, write)
                entry = Entry(f"fill {number}", AUTHORS[number % 4], "paint", "paint 60 points")
                sessions.writer._append(draft, entry, last=False)


def timed(work: Callable[[], object]) -> tuple[float, float]:
    """Milliseconds that ``work`` takes, and those of them that this thread computes."""
    start, busy = time.perf_counter(), time.thread_time()
    work()
    return (time.perf_counter() - start) * 1e3, (time.thread_time() - busy) * 1e3


def paint(store: WorkspaceStore, sequence: str, points: NDArray[np.int64], label: int) -> None:
    """One stroke, durable."""
    store.apply(
        sequence,
        edit_id=f"stroke {next(NUMBERS)}",
        author=AUTHORS[0],
        kind="paint",
        writes={0: Write(points, label=label, provenance=1)},
        summary=f"paint {len(points):,} points",
    )


def row(name: str, times: list[tuple[float, float]]) -> None:
    """A line of the table."""
    wall, busy = np.array(times).T
    middle, high, highest = np.percentile(wall, [50, 95, 100])
    computing = np.percentile(busy, 50)
    print(
        f"| {name} | {len(times)} | {middle:.2f} | {high:.2f} | {highest:.1f} | {computing:.2f} |",
        flush=True,
    )


def bare_commit(path: Path) -> Callable[[], object]:
    """A durable commit of 4 kB to a SQLite file of its own: what the machine takes at least."""
    connection = sqlite3.connect(path, isolation_level=None)
    connection.execute("PRAGMA journal_mode=WAL")
    connection.execute("PRAGMA synchronous=FULL")
    connection.execute("CREATE TABLE rows (data BLOB)")

    def commit() -> None:
        connection.execute("BEGIN IMMEDIATE")
        connection.execute("INSERT INTO rows VALUES (?)", (bytes(4096),))
        connection.execute("COMMIT")

    return commit


def strokes(store: WorkspaceStore, count: int, commit: Callable[[], object] | None) -> None:
    """Strokes and undos, alternately in both sequences, so that the machine's load is shared."""
    rng = np.random.default_rng(2)
    drawn: dict[str, list[tuple[float, float]]] = {"empty": [], "long": []}
    undone: dict[str, list[tuple[float, float]]] = {"empty": [], "long": []}
    bare: list[tuple[float, float]] = []
    for number in range(count):
        points = stroke(rng, 60, 25)
        if commit is not None:
            bare.append(timed(commit))
        for sequence in drawn:
            work = timed(lambda s=sequence, p=points, n=number: paint(store, s, p, 1 + n % 3))
            drawn[sequence].append(work)
            if number % 5 == 4:
                undone[sequence].append(timed(lambda s=sequence: store.undo(s, AUTHORS[0])))
    if bare:
        row("for comparison: a bare durable commit of 4 kB", bare)
    row("stroke, about 1,500 points, empty sequence", drawn["empty"])
    row("stroke, the same, long history", drawn["long"])
    row("undo of it, empty sequence", undone["empty"])
    row("undo of it, long history", undone["long"])


def others(store: WorkspaceStore, url: str) -> None:
    """Opening, reading, a tracking run over all frames."""
    rng = np.random.default_rng(3)

    def reopen() -> None:
        again = WorkspaceStore(url)
        again.palette("long")
        again.counts("long")
        again.values("long", 0)
        again.stacks("long", AUTHORS[0])
        again.edits("long")
        again.close()

    row("open the long history: palette, counts, a frame, undo, 100 lines", [timed(reopen)] * 1)
    row("values of a frame", [timed(lambda: store.values("long", 0)) for _ in range(50)])
    writes = {frame: Write(stroke(rng, 200, 25), label=2, provenance=2) for frame in range(FRAMES)}

    def run() -> None:
        store.apply(
            "long", edit_id=None, author="tracker", kind="tracking", writes=writes, summary=""
        )

    row(f"tracking run, 5,000 points in each of {FRAMES} frames", [timed(run)])
    row("undo of it", [timed(lambda: store.undo("long", "tracker"))])
    row("redo of it", [timed(lambda: store.redo("long", "tracker"))])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--edits", type=int, default=100_000)
    parser.add_argument("--strokes", type=int, default=500)
    parser.add_argument("--database", default="")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        url = given.database or f"sqlite:///{Path(folder) / 'labels.sqlite'}"
        store = WorkspaceStore(url)
        for sequence in ("empty", "long"):
            store.forget(sequence)
            store.recordings.register(sequence, [POINTS] * FRAMES)
            for name in ("one", "two", "three"):
                store.create_label(sequence, "setup", name=name)
        filling = timed(lambda: fill(store, "long", given.edits))[0] / 1e3
        print(f"{given.edits:,} edits made in {filling:.0f} s; milliseconds:\n")
        print("| | n | p50 | p95 | max | p50 computing |\n|---|---|---|---|---|---|")
        commit = None if given.database else bare_commit(Path(folder) / "bare.sqlite")
        strokes(store, given.strokes, commit)
        others(store, url)
        if store.database.path is not None:
            size = store.database.path.stat().st_size / 2**20
            print(f"\ndatabase: {size:.0f} MiB")
        for sequence in ("empty", "long"):
            store.forget(sequence)
        store.close()


if __name__ == "__main__":
    main()
