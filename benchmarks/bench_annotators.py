"""A crowd that paints one recording: answers, deltas, and the server's memory.

python benchmarks/bench_annotators.py [--people 20,50,100,200] [--seconds 60] [--pause 2,5]
    [--undoing 6] [--importing]

Each annotator sends a short stroke every two to five seconds somewhere in a Kinect recording, over
a socket of their own, and looks at the frame that they paint.  The server's own histogram says how
long strokes waited from their end to their durable answer; the clients' figure is beside it, with
the share of a processor that the load generator took itself.  Goals for 200 people: p95 under
150 ms by the server's histogram, every stroke answered, every delta of a frame that a viewer holds
delivered.  Memory is what the server made (anonymous), and files that it maps, which the system
takes back when it needs room; goal: what it made grows by less than 50 MiB after a minute, and by
less than 1 MB a minute after the third.  Of the people some may undo every third stroke, beside
somebody who imports one recording after another, and deletes it.
"""

from __future__ import annotations

import argparse
import asyncio
import io
import random
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import httpx
import numpy as np
from bench_large import resident, server
from bench_streaming import FRAMES, TOKEN, add_label, pointbrush, recording
from bench_strokes import processor_seconds
from light_viewer import connect_light
from prometheus_client.parser import text_string_to_metric_families
from stroke_viewer import StrokeViewer

HISTOGRAM = "pointbrush_stroke_seconds"
LEAVE_SECONDS = 10.0
"""Time for what is on its way when the last stroke has been sent."""
SETTLED_SECONDS = 2.0
"""Time for the deltas of the last strokes."""
IMPORTED_POINTS = 100_000
RAMP_SECONDS = 5.0
"""Time in which the annotators come."""


@dataclass
class Crowd:
    """All annotators' figures."""

    waits: list[float] = field(default_factory=list)
    sent: int = 0
    refused: list[str] = field(default_factory=list)
    viewers: list[StrokeViewer] = field(default_factory=list)


@dataclass(frozen=True)
class Habits:
    """What people do: seconds between two strokes, how many undo, whether somebody imports."""

    pause: tuple[float, float]
    undoing: int
    importing: bool


async def annotator(
    url: str, label: int, crowd: Crowd, end: float, seed: int, habits: Habits
) -> None:
    """Paint until ``end``; the first ones also undo."""
    dice = random.Random(seed)
    await asyncio.sleep(dice.uniform(0, RAMP_SECONDS))
    client = await connect_light(StrokeViewer, url, TOKEN)
    crowd.viewers.append(client)
    client.send(type="hello", name=f"annotator {seed}")
    client.send(type="open", sequence="kinect")
    answers = []
    while time.monotonic() < end:
        await asyncio.sleep(dice.uniform(*habits.pause))
        frame = dice.randrange(FRAMES)
        way = [dice.uniform(-0.3, 0.3), dice.uniform(-0.3, 0.3), 1.0]
        brush = {"label": label, "shape": "ray", "radius": 0.05}
        client.send(type="seek", frame=frame)
        sample = {"origin": [0.0, 0.0, 0.0], "direction": way}
        answers.append(client.stroke(frame, brush, [sample]))
        if seed < habits.undoing and len(answers) % 4 == 3:
            answers.append(client.undo())
    await asyncio.wait(answers, timeout=LEAVE_SECONDS)
    crowd.sent += len(answers)
    crowd.waits += [one.result() for one in answers if one.done() and not one.cancelled()]
    crowd.refused += client.refused


async def importer(url: str, end: float) -> None:
    """Import a recording and delete it, again and again until ``end``."""
    content, dice = io.BytesIO(), np.random.default_rng(0)
    np.savez(content, xyz=dice.normal(size=(IMPORTED_POINTS, 3)).astype(np.float32))
    headers = {"Authorization": f"Bearer {TOKEN}"}
    async with httpx.AsyncClient(base_url=f"{url}/api/v1", headers=headers, timeout=60) as api:
        while time.monotonic() < end:
            files = {"files": ("0.npz", content.getvalue())}
            job = (await api.post("/sequences", files=files)).raise_for_status().json()
            while job["state"] in ("queued", "running"):
                await asyncio.sleep(0.5)
                job = (await api.get(f"/jobs/{job['id']}")).raise_for_status().json()
            await api.delete(f"/sequences/{job['sequence']}")


def growth(samples: list[tuple[float, float]]) -> str:
    """Tell by how much memory grew a minute after the third, of pairs of seconds and MiB."""
    late = [sample for sample in samples if sample[0] > 180]
    if len(late) < 2:
        return "not measured beyond the third minute"
    seconds, made = np.transpose(late)
    slope = np.polyfit(seconds / 60, made * 2**20 / 1e6, 1)[0]
    return f"{slope:+.2f} MB a minute after the third"


def histogram(url: str) -> dict[float, float]:
    """Strokes of the server by the bucket's upper bound, seconds, as running totals."""
    text = httpx.get(f"{url}/metrics", headers={"Authorization": f"Bearer {TOKEN}"}).text
    return {
        float(sample.labels["le"]): sample.value
        for family in text_string_to_metric_families(text)
        if family.name == HISTOGRAM
        for sample in family.samples
        if sample.name.endswith("_bucket")
    }


def percentile(buckets: dict[float, float], share: float) -> float:
    """Upper bound, seconds, of the bucket in which a share of the strokes is reached."""
    total = max(buckets.values())
    return min((bound for bound, count in buckets.items() if count >= share * total), default=0.0)


async def measure(url: str, people: int, seconds: float, habits: Habits) -> None:
    """Print a line of the table, and the server's memory each minute."""
    label, begun, crowd = add_label(url), time.monotonic(), Crowd()
    before, process = histogram(url), server()
    mine, theirs = time.process_time(), processor_seconds(process)
    work = [
        asyncio.create_task(annotator(url, label, crowd, begun + seconds, seed, habits))
        for seed in range(people)
    ]
    if habits.importing:
        work.append(asyncio.create_task(importer(url, begun + seconds)))
    minutes, samples = 0, []
    while not all(task.done() for task in work):
        await asyncio.wait(work, timeout=1.0)
        samples.append((time.monotonic() - begun, resident("RssAnon")))
        if time.monotonic() - begun > 60 * minutes:
            made, mapped = resident("RssAnon"), resident("RssFile")
            print(f"  minute {minutes}: {made:.0f} MiB made, {mapped:.0f} MiB of files", flush=True)
            minutes += 1
    await asyncio.gather(*work)
    print(f"  {growth(samples)}")
    passed = time.monotonic() - begun
    shares = [
        100 * (time.process_time() - mine) / passed,
        100 * (processor_seconds(process) - theirs) / passed,
    ]
    await asyncio.sleep(SETTLED_SECONDS)
    behind, held = missed(crowd)
    for viewer in crowd.viewers:
        viewer.close()
    buckets = {bound: count - before[bound] for bound, count in histogram(url).items()}
    p50, p95 = 1e3 * np.percentile(crowd.waits, [50, 95])
    print(
        f"| {people} | {crowd.sent} | {crowd.sent - len(crowd.waits)} | {len(crowd.refused)} "
        f"| {1e3 * percentile(buckets, 0.5):.0f} / {1e3 * percentile(buckets, 0.95):.0f} "
        f"| {p50:.0f} / {p95:.0f} | {behind} of {held} "
        f"| {shares[1]:.0f} % | {shares[0]:.0f} % | {resident('RssAnon'):.0f} |",
        flush=True,
    )


def missed(crowd: Crowd) -> tuple[int, int]:
    """Frames of viewers whose last edit, by whomever, did not come or left a gap; and all."""
    last: dict[int, int] = {}
    for viewer in crowd.viewers:
        for frame, revision in viewer.changed.items():
            last[frame] = max(revision, last.get(frame, 0))
    behind = sum(
        revision < last.get(frame, 0)
        for viewer in crowd.viewers
        for frame, revision in viewer.held.items()
    )
    gaps = sum(viewer.gaps for viewer in crowd.viewers)
    return behind + gaps, sum(len(viewer.held) for viewer in crowd.viewers)


def main() -> None:
    """Print the table, with a new server for each number of people."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--people", default="20,50,100,200")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--pause", default="2,5", help="seconds between two strokes of a person")
    parser.add_argument("--undoing", type=int, default=0, help="people who also undo")
    parser.add_argument("--importing", action="store_true", help="somebody imports meanwhile")
    given = parser.parse_args()
    low, high = map(float, given.pause.split(","))
    habits = Habits((low, high), given.undoing, given.importing)
    print(
        "| people | strokes | unanswered | refused | server p50 / p95, ms up to | clients, ms "
        "| frames behind | server | clients | MiB |\n|---|---|---|---|---|---|---|---|---|---|"
    )
    for people in map(int, given.people.split(",")):
        with tempfile.TemporaryDirectory() as folder:
            workspace = Path(folder) / "workspace"
            recording(workspace)
            with pointbrush(workspace) as url:
                asyncio.run(measure(url, people, given.seconds, habits))


if __name__ == "__main__":
    main()
