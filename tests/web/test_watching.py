"""Edits, doubts and jobs as they happen, for scripts that react."""

from __future__ import annotations

import asyncio
import threading
from pathlib import Path

import pytest

from pointbrush.client import AsyncClient, Client, Doubt, Job, PastEdit
from pointbrush.web.watching import Watching
from tests.serving import TOKEN, Served, add_sequence, serving, settings_in


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    add_sequence(settings_in(tmp_path), "wall", frames=3, points=2_000)
    return tmp_path


def stroke(served: Served, at: int = 0) -> str:
    with Client(served.url, TOKEN) as client:
        wall = client["wall"]
        found = [label.id for label in wall.labels()] or [wall.create_label("brick").id]
        place = wall.frames[0].points()["xyz"][at]
        return wall.frames[0].stroke(label=found[0], radius=0.3, samples=[place]).edit


def test_edits_jobs_and_doubts_come_as_they_happen(folder: Path) -> None:
    with serving(settings_in(folder)) as served, Client(served.url, TOKEN) as client:
        wall = client["wall"]
        watch = wall.watch(0)
        edits = [stroke(served), stroke(served, 500)]
        seen = [next(watch) for _ in range(3)]
        assert [each.kind for each in seen if isinstance(each, PastEdit)] == [
            "label", "paint", "paint",
        ]  # fmt: skip
        assert [each.id for each in seen[1:] if isinstance(each, PastEdit)] == edits
        late = threading.Timer(0.2, stroke, (served, 900))
        late.start()
        assert isinstance(next(watch), PastEdit), "what comes later ends the wait"
        late.join()
        wall.track(None, 0, 2, method="icp", progress=False)
        states, doubts, run = [], [], None
        for each in watch:
            if isinstance(each, Job):
                states.append(each.state)
            elif isinstance(each, Doubt):
                doubts.append(each)
            elif each.kind == "tracking":
                run = each
            if run is not None and "done" in states:
                break
        unsure = {
            (track.label, track.frame)
            for track in wall.tracks()
            if track.state in ("lost", "occluded") or track.confidence < 0.5
        }
        assert {(each.label, each.frame) for each in doubts} == unsure


def test_nothing_is_missed_while_the_server_is_away(folder: Path) -> None:
    with serving(settings_in(folder)) as first:
        with Client(first.url, TOKEN) as client:
            watch = client["wall"].watch(0)
            seen = [stroke(first)]
            known = [next(watch), next(watch)]
            revision = watch.revision
        seen.append(stroke(first, 300))
    with serving(settings_in(folder)) as second:
        seen.append(stroke(second, 600))

        async def rest() -> list[str]:
            async with AsyncClient(second.url, TOKEN) as client:
                watch = (await client["wall"]).watch(revision)
                return [each.id async for each in _first(watch, 2)]

        assert isinstance(known[1], PastEdit)
        assert [known[1].id, *asyncio.run(rest())] == seen


async def _first(watch: object, count: int):  # type: ignore[no-untyped-def]
    for _ in range(count):
        yield await watch.__anext__()  # type: ignore[attr-defined]


def test_who_waits_is_answered_when_the_server_ends() -> None:
    async def work() -> str:
        watching = Watching()
        waiting = asyncio.create_task(watching.until("wall", lambda: ("nothing", False), 10_000))
        await asyncio.sleep(0)
        watching.end()
        return await waiting

    assert asyncio.run(work()) == "nothing"
