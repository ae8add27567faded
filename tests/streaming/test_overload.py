"""Too many edits at a time: who is refused is told, and what waits is applied."""

from __future__ import annotations

import sqlite3
import uuid
from contextlib import closing
from pathlib import Path

from tests.serving import Served, add_sequence, serving, settings_in
from tests.streaming.acting import run
from tests.streaming.client import Viewer, viewer

POINTS = 2_000


async def begin(client: Viewer) -> str:
    """Send a stroke over all of frame 0, up to its end."""
    stroke = str(uuid.uuid4())
    brush = {"label": 1, "radius": 9.0, "shape": "sphere"}
    await client.send(type="stroke_begin", id=stroke, frame=0, brush=brush)
    await client.send(type="stroke_samples", id=stroke, samples=[{"origin": [0, 0, 3.0]}])
    return stroke


async def begun(client: Viewer) -> str:
    """Begin a stroke as often as it takes: what was refused may still wait to be thrown away."""
    while True:
        stroke = await begin(client)
        while (answer := await client.receive())["type"] not in ("stroke_result", "error"):
            pass
        if answer["type"] == "stroke_result":
            return stroke


def held_up(served: Served) -> sqlite3.Connection:
    """A transaction of another process, behind which edits wait."""
    path = served.workspace.settings.workspace / "labels.sqlite"
    other = sqlite3.connect(path, isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    return other


def test_a_stroke_too_many_is_refused_in_words_and_what_waits_is_applied(tmp_path: Path) -> None:
    settings = settings_in(tmp_path, waiting_edits=1)
    add_sequence(settings, "wall", frames=1, points=POINTS)

    async def scenario() -> None:
        async with (
            viewer(served.url, served.token) as first,
            viewer(served.url, served.token) as second,
        ):
            for client in (first, second):
                await client.open("wall")
            waits = await begun(first)
            refused = []
            with closing(held_up(served)):
                await first.send(type="stroke_end", id=waits)
                for client in (first, second):
                    stroke = await begin(client)
                    await client.send(type="stroke_end", id=stroke)
                    error = await client.until("error", about=stroke)
                    # The page shows both, and takes back what it had lit up.
                    assert (error["status"], error["title"]) == (429, "Too many requests")
                    assert error["detail"] == (
                        "expected at most 1 waiting edits, got more: the server is overloaded, "
                        "paint this again in a moment"
                    )
                    refused.append(stroke)
            answer = await first.until("stroke_result", id=waits, final=True)
            assert answer["changed"] == POINTS
            # Only once: what came of a refused stroke behind its begin is not an error by itself.
            errors = [
                message["about"]
                for c in (first, second)
                for message in c.log
                if message["type"] == "error"
            ]
            assert errors == refused
            again = await begun(second)
            await second.send(type="stroke_end", id=again)
            await second.until("stroke_result", id=again, final=True)
        made = {edit.id for edit in served.workspace.labels.edits("wall")}
        assert made.isdisjoint(refused)
        assert made >= {waits, again}

    with serving(settings) as served:
        served.workspace.labels.create_label("wall", "somebody", name="pin")
        run(scenario)
