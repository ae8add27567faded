"""How much work a recording is: strokes and corrected frames, for each method and for none.

python benchmarks/bench_effort.py [--frames 60] [--methods none,icp,color-icp,auto] [--objects]

A simulated annotator (annotator.py) paints over REST, on a server of its own, until the mean IoU
over the objects of every frame is at least 0.9.  Goal: under 1 corrected frame in 30 on the
juggling recordings, and 20 times fewer strokes than painting frame by frame.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
from annotator import Annotator

from pointbrush.frame import PointFrame
from pointbrush.samples import Recording, generate
from pointbrush.sequences import RecordingInfo, import_frames

KINDS: dict[str, tuple[str, dict[str, Any]]] = {
    "3 pins": ("juggling", {"pins": 3, "label_people": False}),
    "6 pins, passing": ("juggling", {"pins": 6, "label_people": False}),
    "table-top": ("tabletop", {}),
    "walking people": ("walking", {}),
}
TOKEN = "benchmark-token-of-effort"
FORGETFUL = ("icp", "color-icp")
"""The paper's methods remember nothing but the last frame."""


@contextmanager
def serving(workspace: Path) -> Iterator[httpx.Client]:
    """A ``pointbrush serve`` of its own, and a client of it."""
    command = [sys.executable, "-m", "pointbrush.cli", "serve", "--port", "0"]
    command += ["--workspace", str(workspace)]
    environment = os.environ | {"POINTBRUSH_TOKEN": TOKEN}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as server:
        try:
            assert server.stdout is not None
            found = next(filter(None, (re.search(r"http://[^/\s]+", s) for s in server.stdout)))
            headers = {"Authorization": f"Bearer {TOKEN}"}
            with httpx.Client(base_url=f"{found[0]}/api/v1", headers=headers, timeout=120) as api:
                yield api
        finally:
            server.terminate()


def add(frames: list[PointFrame], fps: float, workspace: Path, name: str) -> None:
    """Import a recording under a name."""
    target = workspace / "sequences" / name
    import_frames(frames, target, RecordingInfo(name, name, fps))


def create_labels(api: httpx.Client, name: str, recording: Recording) -> None:
    """Give the sequence the truth's palette."""
    for label in recording.labels:
        body = label._asdict()
        api.post(f"/sequences/{name}/labels", json=body).raise_for_status()


def main() -> None:
    """Print a line for each recording and method."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--methods", default="none,icp,color-icp,auto")
    parser.add_argument("--kinds", default="3 pins,6 pins, passing", help="; ".join(KINDS))
    parser.add_argument(
        "--objects", action="store_true", help="the annotator has the object tool besides the ball"
    )
    given = parser.parse_args()
    methods = given.methods.split(",")
    kinds = [k.strip() for k in re.split(r",(?! passing)", given.kinds)]
    with tempfile.TemporaryDirectory() as folder:
        workspace = Path(folder)
        recordings, truths, sequences = {}, {}, {}
        for kind in kinds:
            name, options = KINDS[kind]
            recordings[kind] = recording = generate(name, given.seed, given.frames, **options)
            made = [(recording.frame(i), recording.truth[i]) for i in range(given.frames)]
            truths[kind] = [truth for _, truth in made]
            for number, method in enumerate(methods):
                sequences[kind, method] = f"{re.sub(r'[^a-z0-9]+', '-', kind)}-{number}"
                frames = [frame for frame, _ in made]
                add(frames, recording.fps, workspace, sequences[kind, method])
        print(f"{given.frames} frames, seed {given.seed}; goal: mean IoU of every frame >= 0.9")
        head = "  recording        method     strokes  corrected  1 frame in  fewer strokes   time"
        print(head, flush=True)
        with serving(workspace) as api:
            for kind in kinds:
                by_hand: int | None = None
                for method in methods:
                    sequence, truth = sequences[kind, method], truths[kind]
                    create_labels(api, sequence, recordings[kind])
                    begun = time.perf_counter()
                    person = Annotator(api, sequence, truth, objects=given.objects)
                    if method == "none":
                        person.label_all_by_hand()
                        by_hand = person.strokes
                    else:
                        person.label_all(method, forgetful=method in FORGETFUL)
                    report(kind, method, person, by_hand, time.perf_counter() - begun)


def report(kind: str, method: str, person: Annotator, by_hand: int | None, seconds: float) -> None:
    """Print one line."""
    fixed = len(person.corrected)
    rate = f"{person.frames / fixed:.1f}" if fixed else f"> {person.frames}"
    fewer = f"{by_hand / max(person.strokes, 1):.1f} x" if by_hand is not None else ""
    print(
        f"  {kind:16} {method:10} {person.strokes:7} {fixed:10} {rate:>11} {fewer:>14}"
        f" {seconds:5.0f} s",
        flush=True,
    )


if __name__ == "__main__":
    main()
