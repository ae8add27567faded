"""Many people paint the same points at once, some of them over a link that breaks."""

from __future__ import annotations

import asyncio
import io
import random
import uuid
from collections.abc import AsyncIterator, Iterator
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pointbrush.sequences import open_sequence
from tests.faults.server import TOKEN, ServerProcess, running
from tests.serving import add_sequence, settings_in
from tests.streaming.client import HeldFrame, Viewer, viewer

PEOPLE, STROKES = 5, 8
DELETED = 65535
Brush = dict[str, Any]


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ServerProcess]:
    settings = settings_in(tmp_path)
    add_sequence(settings, "wall", frames=1, points=8_000)
    with running(settings.workspace) as started:
        with started.api() as api:
            for name in range(PEOPLE):
                api.post("/sequences/wall/labels", json={"name": f"{name}"}).raise_for_status()
        yield started


def sample(rng: random.Random) -> dict[str, Any]:
    """Near one place, so that strokes overlap."""
    return {"origin": [rng.uniform(-0.4, 0.4), rng.uniform(-0.4, 0.4), 3.0]}


async def send(one: Viewer, edit: str, brush: Brush, samples: list[dict[str, Any]]) -> None:
    await one.send(type="stroke_begin", id=edit, frame=0, brush=brush)
    await one.send(type="stroke_samples", id=edit, samples=samples)
    await one.send(type="stroke_end", id=edit)


class Person:
    """Paints and erases; the link breaks once before the answer of a stroke."""

    def __init__(self, url: str, number: int) -> None:
        self.url, self.name, self.label = url, f"person {number}", number + 1
        self.rng = random.Random(number)
        self.revision: int | None = None
        """What this viewer is sure of: all edits up to here."""
        self.frames: dict[int, HeldFrame] = {}
        self.answered: list[int] = []
        self.gaps = 0

    @asynccontextmanager
    async def online(self) -> AsyncIterator[Viewer]:
        """Connected, the recording open, where it was left the last time."""
        async with viewer(self.url, TOKEN, on_message=self.heard) as one:
            one.frames = self.frames
            await one.hello(self.name)
            about = await one.open("wall", revision=self.revision)
            if self.revision is None:
                self.revision = about["revision"]
                await one.until("frame", final=True)
            yield one
            self.gaps += one.gaps

    def heard(self, message: dict[str, Any]) -> None:
        if message["type"] == "annotation" and message["base"] is not None:
            assert self.revision is not None
            self.revision = max(self.revision, message["revision"])

    def brush(self) -> tuple[str, Brush, list[dict[str, Any]]]:
        tool = self.rng.choice(["paint", "paint", "erase"])
        brush = {"tool": tool, "label": self.label, "radius": 0.3}
        return str(uuid.uuid4()), brush, [sample(self.rng), sample(self.rng)]

    async def paint(self) -> None:
        lost = self.brush()
        async with self.online() as one:
            for _ in range(STROKES // 2):
                await self.stroke(one, *self.brush())
            await send(one, *lost)
        async with self.online() as one:
            await self.stroke(one, *lost)
            for _ in range(STROKES - STROKES // 2 - 1):
                await self.stroke(one, *self.brush())

    async def stroke(
        self, one: Viewer, edit: str, brush: Brush, samples: list[dict[str, Any]]
    ) -> None:
        await send(one, edit, brush, samples)
        answer = await one.until("stroke_result", id=edit, final=True)
        self.answered.append(answer["revision"])


async def everybody(server: ServerProcess) -> list[Person]:
    """All paint at once; then each looks again from where it was until it has everything."""
    people = [Person(server.url, number) for number in range(PEOPLE)]
    await asyncio.gather(*(person.paint() for person in people))
    async with AsyncExitStack() as stack:
        viewers = [await stack.enter_async_context(person.online()) for person in people]
        for one in viewers:
            await one.hello("again")  # answered once 'open' has been dealt with
        last = {"id": str(uuid.uuid4()), "label": 1, "radius": 0.1, "tool": "delete"}
        await asyncio.to_thread(post, server, {**last, "samples": [sample(random.Random(0))]})
        for one in viewers:
            if not any(message.get("edit") == last["id"] for message in one.log):
                await one.until("annotation", edit=last["id"])
    return people


def post(server: ServerProcess, stroke: dict[str, Any]) -> None:
    with server.api() as api:
        answer = api.post("/sequences/wall/frames/0/strokes", json=stroke).raise_for_status()
        assert answer.json()["changed"] > 0


def test_all_end_with_the_same_labels(server: ServerProcess) -> None:
    people = asyncio.run(everybody(server))
    with server.api() as api:
        edits = api.get("/sequences/wall/edits").json()
        path = "/sequences/wall/frames/0/annotation"
        labels, deleted = (
            np.load(io.BytesIO(api.get(f"{path}?layer={layer}").raise_for_status().content))
            for layer in ("label", "deleted")
        )
    # Every stroke once, also those whose answer was lost, and each where its author was told.
    made = {edit["revision"]: edit["author"] for edit in edits}
    told = {revision: person.name for person in people for revision in person.answered}
    assert len(told) == PEOPLE * STROKES
    assert {revision: made[revision] for revision in told} == told
    assert len(edits) == PEOPLE + PEOPLE * STROKES + 1
    # The same for everyone: what each heard on the way and what the server has.
    recording = open_sequence(server.workspace / "sequences" / "wall")
    wanted = np.where(deleted, DELETED, labels)[recording[0].source_index]
    assert len(np.unique(wanted)) > 3
    for person in people:
        values = person.frames[0].values
        assert values is not None
        np.testing.assert_array_equal(values, wanted)
        assert person.gaps == 0
