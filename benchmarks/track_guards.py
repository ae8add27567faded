"""Guards of the method `auto`: the table that has to hold before a rule is added or removed.

    python benchmarks/track_guards.py [--processes 2] [--commit REVISION] [--kinds 3-pins,boxes]
                                      [--seeds 71,72] [--draws 4] [--frames 30] [--results FILE]
    python benchmarks/track_guards.py compare A B [--kinds 3-pins,boxes]

Frame 0 is labelled with the truth and tracked to the end without corrections, in each recording
several times: draw 0 as it is, every other draw with a micrometre of noise, because noise alone
moves a result.  Prints per kind, and per kind for hard starts: the mean IoU; the mean over
recordings of their worst draw; bad object-frames (IoU under 0.5) that are flagged (confidence up to
0.9) and unflagged; silent errors (IoU under 0.8 at a higher confidence); processor milliseconds per
object-frame.

Results are appended to FILE, one line of JSON per draw, and a draw found there is not run again: an
interrupted run continues.  Without ``--commit`` the working tree is measured, under the name
of its commit and a digest of its changes.  A kind may also be a lidar scene of shared/realdata or
the path of a recording (.npz, as in shared/recordings), which have no seeds: once for each draw.
"""

# The thread limits have to be set before numpy is imported.
# ruff: noqa: E402

from __future__ import annotations

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"

import argparse
import hashlib
import io
import json
import subprocess
import sys
import tarfile
from collections import defaultdict
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from tracking_frames import Frame, drawn, stored
from tracking_score import GOOD, SURVIVING, Score

from pointbrush.tracking import METHODS

ROOT = Path(__file__).parent.parent
FOLDER = ROOT / ".guards"
"""Results, and the code of other commits with their compiled loops."""
RECORDINGS = FOLDER / "recordings"
"""Recordings that were made, some 60 MB each."""
KINDS = "3-pins,6-pins,table-top,walking,crowd-5hz,boxes,street,street-16-beams"
SEEDS = (71, 72, 73, 74, 75, 76)
"""Seeds 74 to 76 are for checks only: no rule and no number is chosen by them."""
HARD_STARTS = {"3-pins": (43, 503)}
"""Seeds whose pins are painted end on; they run with ``SEEDS`` and have a row of their own."""
ONCE = ("dgp_", "semantickitti_")
"""How the names of recorded lidar begin, which has no seeds."""
SURE = 0.9
"""Confidence over which a result counts as unflagged."""


@dataclass(frozen=True)
class Draw:
    """Result of one draw; ``iou`` and ``confidence`` per visible object-frame."""

    commit: str
    kind: str
    seed: int
    draw: int
    frames: int
    recording: str
    """Digest of the positions: another processor makes another recording of a seed."""
    iou: list[float]
    confidence: list[float]
    ms: float

    @property
    def key(self) -> tuple[str, str, int, int, int]:
        """What identifies a draw among the results."""
        return self.commit, self.kind, self.seed, self.draw, self.frames


def measure(
    commit: str, kind: str, seed: int, draws: Iterable[int], frames: int, results: Path
) -> str:
    """Track the missing draws of a recording, append their results and return a message."""
    recording = _recording(kind, seed, frames)
    digest = _digest(recording)
    for number in draws:
        score = Score()
        score.run(drawn(recording, number), METHODS["auto"]())
        iou, sure = np.round(score.iou, 4).tolist(), np.round(score.confidence, 4).tolist()
        ms = round(float(np.mean(score.ms)), 2)
        draw = Draw(commit, kind, seed, number, frames, digest, iou, sure, ms)
        with results.open("a") as lines:
            lines.write(json.dumps(asdict(draw)) + "\n")
    return f"{kind} {seed}"


def _recording(kind: str, seed: int, frames: int) -> list[Frame]:
    """Read a recording; the working tree makes it first, whatever commit is measured."""
    path = Path(kind) if kind.endswith(".npz") else RECORDINGS / f"{kind}-{seed}-{frames}.npz"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        script = Path(__file__).with_name("tracking_recordings.py")
        made = (sys.executable, script, kind, str(seed), str(frames), path)
        packages = os.environ | {"PYTHONPATH": str(ROOT / "server")}
        subprocess.run(made, check=True, env=packages)
    return stored(path, frames)


def _digest(recording: list[Frame]) -> str:
    return hashlib.sha256(b"".join(frame.xyz.tobytes() for frame in recording)).hexdigest()[:12]


def read(results: Path) -> list[Draw]:
    """Return all stored results."""
    if not results.exists():
        return []
    return [Draw(**json.loads(line)) for line in results.read_text().splitlines()]


def table(draws: list[Draw]) -> dict[str, list[str]]:
    """Return per kind, and for all kinds, the cells of ``HEAD``."""
    by_kind: dict[str, list[Draw]] = defaultdict(list)
    for draw in draws:
        hard = draw.seed in HARD_STARTS.get(draw.kind, ())
        by_kind[f"{draw.kind}, hard starts" if hard else draw.kind].append(draw)
    rows = {kind: _cells(of) for kind, of in by_kind.items()}
    return rows | ({"all": _cells(draws)} if len(rows) > 1 else {})


HEAD = ("mean", "worst draws", "bad flagged", "bad unflagged", "silent", "ms", "draws")


def _cells(draws: list[Draw]) -> list[str]:
    by_seed: dict[tuple[str, int], list[float]] = defaultdict(list)
    for draw in draws:
        by_seed[draw.kind, draw.seed].append(float(np.mean(draw.iou)))
    iou = np.concatenate([draw.iou for draw in draws])
    sure = np.concatenate([draw.confidence for draw in draws]) > SURE
    silent = np.mean((iou < GOOD) & sure)
    return [
        f"{np.mean([np.mean(m) for m in by_seed.values()]):.4f}",
        f"{np.mean([min(m) for m in by_seed.values()]):.4f}",
        str(np.count_nonzero((iou < SURVIVING) & ~sure)),
        str(np.count_nonzero((iou < SURVIVING) & sure)),
        f"{100 * silent:.2f} %",
        f"{np.mean([draw.ms for draw in draws]):.1f}",
        str(len(draws)),
    ]


def compare(before: list[Draw], after: list[Draw]) -> None:
    """Print the draws that both commits have, side by side: before → after."""
    recordings = {draw.key[1:]: draw.recording for draw in before}
    both = {d.key[1:] for d in after if recordings.get(d.key[1:]) == d.recording}
    one = table([draw for draw in before if draw.key[1:] in both])
    two = table([draw for draw in after if draw.key[1:] in both])
    _print(
        {
            kind: [a if a == b else f"{a} → {b}" for a, b in zip(one[kind], two[kind], strict=True)]
            for kind in one
        }
    )


def _print(rows: dict[str, list[str]]) -> None:
    print("| kind | " + " | ".join(HEAD) + " |\n" + "|---" * (1 + len(HEAD)) + "|")
    for kind, cells in rows.items():
        print(f"| {kind} | " + " | ".join(cells) + " |")


def tree_name() -> str:
    """Return the short commit of the working tree, with a digest of its changes if it has any."""
    changes = _git("diff", "HEAD", "--", "server")
    name = _git("rev-parse", "--short=8", "HEAD").decode().strip()
    return f"{name}-{hashlib.sha256(changes).hexdigest()[:6]}" if changes else name


def code_of(revision: str) -> tuple[str, Path]:
    """Return the short name of a commit and a folder with its packages."""
    name = _git("rev-parse", "--short=8", f"{revision}^{{commit}}").decode().strip()
    folder = FOLDER / name
    if not folder.exists():
        with tarfile.open(fileobj=io.BytesIO(_git("archive", name, "server"))) as files:
            files.extractall(folder, filter="data")
    return name, folder / "server"


def _git(*words: str) -> bytes:
    return subprocess.run(("git", *words), cwd=ROOT, check=True, capture_output=True).stdout


def run(given: argparse.Namespace) -> None:
    """Measure what is missing, then print the table."""
    done = {draw.key for draw in read(given.results)}
    with ProcessPoolExecutor(given.processes, get_context("spawn")) as pool:
        jobs = [pool.submit(measure, *job) for job in _missing(given, done)]
        for job in as_completed(jobs):
            print(job.result(), file=sys.stderr, flush=True)
    _print(table(_chosen(given, given.name)))


def _missing(
    given: argparse.Namespace, done: set[tuple[str, str, int, int, int]]
) -> Iterator[tuple[str, str, int, list[int], int, Path]]:
    for kind in given.kinds:
        once = kind.endswith(".npz") or kind.startswith(ONCE)
        seeds = seeds_of(given, kind)
        for seed in seeds[:1] if once else seeds:
            keys = {n: (given.name, kind, seed, n, given.frames) for n in range(given.draws)}
            draws = [number for number, key in keys.items() if key not in done]
            if draws:
                yield given.name, kind, seed, draws, given.frames, given.results


def _chosen(given: argparse.Namespace, commit: str) -> list[Draw]:
    """Return the stored draws of a commit that the arguments name."""
    of = [draw for draw in read(given.results) if draw.commit.startswith(commit)]
    return [
        draw
        for draw in of
        if draw.kind in given.kinds
        and draw.seed in seeds_of(given, draw.kind)
        and draw.draw < given.draws
        and draw.frames == given.frames
    ]


def seeds_of(given: argparse.Namespace, kind: str) -> list[int]:
    """Return the seeds of a kind: the given ones; without any, ``SEEDS`` and its hard starts."""
    return given.seeds or [*SEEDS, *HARD_STARTS.get(kind, ())]


def numbers(words: str) -> list[int]:
    """Return the integers of a comma-separated list."""
    return [int(word) for word in words.split(",")]


def main() -> None:
    """Run or compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("command", nargs="*", metavar="compare A B")
    parser.add_argument("--commit")
    parser.add_argument("--name", help=argparse.SUPPRESS)
    parser.add_argument("--kinds", type=lambda words: words.split(","), default=KINDS)
    parser.add_argument("--seeds", type=numbers)
    parser.add_argument("--draws", type=int, default=4)
    parser.add_argument("--frames", type=int, default=30)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--results", type=Path, default=FOLDER / "results.jsonl")
    given = parser.parse_args()
    given.results.parent.mkdir(parents=True, exist_ok=True)
    if given.command:
        if given.command[0] != "compare" or len(given.command) != 3:
            parser.error("expected: compare A B")
        compare(*(_chosen(given, commit) for commit in given.command[1:]))
        return
    if given.commit:
        name, packages = code_of(given.commit)
        os.environ["PYTHONPATH"] = str(packages)
        os.execv(sys.executable, _without_commit(name))
    given.name = given.name or tree_name()
    run(given)


def _without_commit(name: str) -> list[str]:
    """Return this command line for the commit whose packages are now imported."""
    at = sys.argv.index("--commit")
    return [sys.executable, *sys.argv[:at], "--name", name, *sys.argv[at + 2 :]]


if __name__ == "__main__":
    main()
