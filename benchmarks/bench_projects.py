"""Time to list and search many recordings, from asking to the answer, and of processors.

python benchmarks/bench_projects.py [--recordings 2000] [--database URL]

Each recording has two frames, a few labels with points, edits of two people and a task; they are
in twenty projects.  Times are medians of calls of a server in this process: "wall" from asking to
the answer, which grows with what else the machine does, "processor" of server and client together.
"first" is the call after the start, which opens every manifest.
"""

from __future__ import annotations

import argparse
import shutil
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

import numpy as np

from pointbrush.client import Client
from pointbrush.labels import Write
from pointbrush.sequences.storage.manifest import rename_sequence
from pointbrush.settings import Settings
from pointbrush.teamwork.projects import Change
from pointbrush.teamwork.tasks import Stretch
from pointbrush.workspace import Workspace
from tests.serving import TOKEN, add_sequence, serving, settings_in

PROJECTS = 20
REPEATS = 9
CLASSES = ("car", "person", "tree", "house")


def fill(settings: Settings, count: int) -> None:
    """Make ``count`` recordings with labels and tasks."""
    add_sequence(settings, "r00000", frames=2, points=500)
    folder = settings.workspace / "sequences"
    for number in range(1, count):
        shutil.copytree(folder / "r00000", folder / f".r{number:05}")
        rename_sequence(folder / f".r{number:05}", f"r{number:05}")
        (folder / f".r{number:05}").rename(folder / f"r{number:05}")
    with closing(Workspace(settings)) as workspace:
        team = workspace.labels.team
        for number in range(PROJECTS):
            team.projects.create(f"p{number}", Change(name=f"Project {number}"))
        names = sorted(workspace.library.ids())
        for number in range(PROJECTS):
            mine = names[number::PROJECTS]
            team.projects.change(f"p{number}", Change(recordings=mine))
            team.tasks.add(f"p{number}", "lead", [Stretch(name, 0, 1) for name in mine])
        for number, name in enumerate(names):
            author = f"person {number % 7}"
            category = CLASSES[number % len(CLASSES)]
            label = workspace.labels.create_label(name, author, name="one", category=category)
            write = Write(np.arange(100), label=label.id, provenance=1)
            workspace.labels.apply(
                name, edit_id=None, author=author, kind="paint", writes={0: write}, summary=""
            )


def timed(call: Callable[[], object], repeats: int = REPEATS) -> str:
    """Call ``repeats`` times; tell the medians of wall and processor time."""
    taken = []
    for _ in range(repeats):
        begun = time.perf_counter(), time.process_time()
        call()
        taken.append((time.perf_counter() - begun[0], time.process_time() - begun[1]))
    wall, processor = (1000 * statistics.median(times) for times in zip(*taken, strict=True))
    return f"{wall:8.0f} ms{processor:8.0f} ms"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--recordings", type=int, default=2000)
    parser.add_argument("--database", default="")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        settings = settings_in(Path(folder), database=given.database)
        begun = time.perf_counter()
        fill(settings, given.recordings)
        print(f"{given.recordings} recordings made in {time.perf_counter() - begun:.0f} s")
        with serving(settings) as served, Client(served.url, TOKEN) as client:

            def get(path: str) -> Callable[[], object]:
                return lambda: client.call("GET", path)

            print(f"{'call':28}{'wall':>11}{'processor':>11}")
            print(f"{'home, first':28}{timed(get('/sequences'), 1)}")
            calls = {
                "home": "/sequences",
                "projects": "/projects",
                "search by name": "/sequences?q=r0001",
                "search by class": "/sequences?class=car&project=p3",
                "search by person": "/sequences?person=person%203&project=p3",
                "search by state": "/sequences?state=open&project=p3",
                "statistics of a project": "/projects/p3/statistics",
                "next task": "",
            }
            for name, path in calls.items():
                call = get(path) if path else (lambda: client.projects["p3"].next_task())
                print(f"{name:28}{timed(call)}")


if __name__ == "__main__":
    main()
