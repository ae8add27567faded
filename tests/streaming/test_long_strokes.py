"""Strokes of thousands of samples: in parts, with others served and pings answered in between."""

from __future__ import annotations

import asyncio
import uuid
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from pointbrush.selection import Stroke, select
from pointbrush.streaming import edits
from pointbrush.work.annotate.painted_frame import frame_points
from tests.serving import Served, add_sequence, serving, settings_in
from tests.streaming.acting import run
from tests.streaming.client import Viewer, viewer

SAMPLES = 600
TURNS = 5
"""Turns that a long stroke takes at least, on any machine."""


@pytest.fixture
def served(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> Iterator[Served]:
    # On a quick machine too there is somebody else's turn between two parts.
    monkeypatch.setattr(edits, "TURN_SECONDS", 0.001)
    settings = settings_in(tmp_path)
    add_sequence(settings, "wall", frames=2, points=30_000)
    with serving(settings) as running:
        running.workspace.labels.create_label("wall", "somebody", name="pin")
        running.workspace.labels.create_label("wall", "somebody", name="ball")
        yield running


def rays(count: int) -> list[dict[str, Any]]:
    """From the sensor over most of the wall, in a wavy line."""
    t = np.linspace(0, 1, count)
    x, y = 1.6 * t - 0.8, 0.7 * np.sin(20 * t)
    return [
        {"origin": [0.0, 0.0, 0.0], "direction": [a, b, 1.0]} for a, b in zip(x, y, strict=True)
    ]


async def long_stroke(client: Viewer, shape: str) -> str:
    """Send a whole stroke at once."""
    stroke = str(uuid.uuid4())
    brush = {"label": 1, "shape": shape, "radius": 0.05}
    await client.send(type="stroke_begin", id=stroke, frame=0, brush=brush)
    await client.send(type="stroke_samples", id=stroke, samples=rays(SAMPLES))
    await client.send(type="stroke_end", id=stroke)
    return stroke


async def short_stroke(client: Viewer, number: int) -> None:
    stroke = str(uuid.uuid4())
    brush = {"label": 2, "radius": 0.3}
    await client.send(type="stroke_begin", id=stroke, frame=1, brush=brush)
    origin = [-1.5 + 0.1 * number, 0.0, 3.0]
    await client.send(type="stroke_samples", id=stroke, samples=[{"origin": origin}])
    await client.send(type="stroke_end", id=stroke)
    await client.until("stroke_result", final=True, id=stroke)


@pytest.mark.parametrize("shape", ["ray", "grow", "plane"])
def test_others_are_answered_between_the_parts_of_a_long_stroke(served: Served, shape: str) -> None:
    async def scenario() -> None:
        async with (
            viewer(served.url, served.token) as painter,
            viewer(served.url, served.token) as other,
        ):
            await painter.open("wall", frame=0)
            await other.open("wall", frame=1)
            stroke = await long_stroke(painter, shape)
            final = asyncio.create_task(painter.until("stroke_result", final=True, id=stroke))
            answered = 0
            while not final.done():
                await short_stroke(other, answered)
                answered += 1
            assert answered > TURNS, "others had their turns meanwhile"
            result = await final
        frame = served.workspace.recording("wall")[0]
        whole = {"label": 1, "shape": shape, "radius": 0.05, "samples": rays(SAMPLES)}
        expected = select(frame_points(frame), Stroke.parse(whole))
        values = served.workspace.labels.values("wall", 0)
        np.testing.assert_array_equal(np.flatnonzero(values.label == 1), expected)
        assert result["changed"] == len(expected) > 500

    run(scenario)


def test_pings_are_answered_before_the_strokes_that_were_sent_ahead_of_them(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.open("wall", frame=0)
            strokes = [await long_stroke(client, "ray") for _ in range(3)]
            pong = await client.socket.ping()
            heard = []
            client.on_message = heard.append
            last = asyncio.create_task(client.until("stroke_result", final=True, id=strokes[-1]))
            await pong
            assert not any(m.get("id") == strokes[-1] and m.get("final") for m in heard)
            await last
            finals = [m["id"] for m in heard if m["type"] == "stroke_result" and m["final"]]
            assert finals == strokes, "each once, in the order they were sent"

    run(scenario)
