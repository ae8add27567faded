"""Viewers of a server that compiles its loops: told how far it is, answered when it is there."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pointbrush.jobs import worker
from pointbrush.values.runs import TrackingRequest
from pointbrush.work.loops.compiling import DONE, STEPS, Progress, Report, StepName, hold
from tests.serving import Served, add_sequence, serving, settings_in
from tests.streaming.acting import run
from tests.streaming.client import Viewer, viewer
from tests.waiting import eventually

RAY = {"origin": [0.0, 0.0, 0.0], "direction": [0.0, 0.0, 1.0]}


@pytest.fixture
def served(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Served]:
    """A server whose only frame is prepared; from then on its loops are not compiled."""
    settings = settings_in(tmp_path)
    add_sequence(settings, "wall", frames=2, points=3000)
    with serving(settings) as running:
        running.workspace.labels.create_label("wall", "somebody", name="pin")
        asked = {"positives": [RAY], "label": 1}
        eventually(lambda: running.workspace.strokes.preview("wall", 0, asked).ready, every=0.1)
        # A process that is forked has the environment of its fork server.
        monkeypatch.setattr(worker, "START_METHOD", "spawn")
        monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "loops"))
        yield running


def note_others(step: StepName) -> None:
    """Note all steps but one as done."""
    for other in STEPS:
        if other != step:
            with hold(other) as note:
                assert note is not None
                note(DONE)


async def ask(client: Viewer, shape: str) -> str:
    question, brush = str(uuid.uuid4()), {"label": 1, "shape": shape, "radius": 0.1}
    await client.send(type="ask", id=question, frame=0, brush=brush, samples=[RAY])
    return question


def answers(client: Viewer) -> list[str]:
    return [message["id"] for message in client.log if message["type"] == "candidates"]


def test_an_object_is_answered_once_its_loops_are_compiled_and_progress_is_told(
    served: Served,
) -> None:
    async def scenario(note: Report) -> None:
        async with viewer(served.url, served.token) as client:
            await client.hello()
            told = await client.until("compiling", step="objects")
            assert (told["share"], told["seconds"]) == (0.25, 9.0)
            await client.open("wall")
            early = await ask(client, "object")
            note(Progress(0.5, 5.0))
            await client.until("compiling", step="objects", share=0.5)
            # A region of another kind needs no such loops; the newest question counts.
            region = await ask(client, "grow")
            await client.until("candidates", id=region)
            late = await ask(client, "object")
            note(DONE)
            await client.until("candidates", id=late)
            assert answers(client) == [region, late]
            assert early not in answers(client)
            steps = [m for m in client.log if m["type"] == "compiling"]
            assert steps[-1]["share"] == 1.0
        async with viewer(served.url, served.token) as client:
            await client.hello()
            await client.open("wall")
            assert not [m for m in client.log if m["type"] == "compiling"]

    note_others("objects")
    with hold("objects") as note:
        assert note is not None
        note(Progress(0.25, 9.0))
        served.workspace.loops.begin()
        eventually(lambda: served.workspace.loops.missing()["objects"].share == 0.25)
        run(lambda: scenario(note))


def test_a_run_says_how_long_it_waits_for_loops_and_can_be_cancelled(served: Served) -> None:
    workspace = served.workspace
    stroke: dict[str, Any] = {"label": 1, "radius": 0.5, "samples": [{"origin": [0, 0, 3]}]}
    workspace.strokes.apply("wall", 0, stroke, "somebody")
    note_others("things")
    with hold("things") as note:
        assert note is not None
        note(Progress(0.5, 12.4))
        job = workspace.tracking.start("wall", TrackingRequest(start=0, stop=1), "ada").id
        eventually(lambda: "once on this machine: 12 s remain" in workspace.jobs.get(job).message)
        assert workspace.jobs.get(job).progress == 0
        workspace.runner.cancel(job)
        assert workspace.runner.wait(job).state == "cancelled"
