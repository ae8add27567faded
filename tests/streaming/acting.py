"""What tests of the socket do at it."""

from __future__ import annotations

import asyncio
import uuid
from collections.abc import Awaitable, Callable
from typing import Any

import numpy as np

from tests.serving import Served
from tests.streaming.client import HeldFrame, Viewer, viewer
from tests.waiting import PATIENCE

Scenario = Callable[[], Awaitable[None]]


RANDOM = np.random.default_rng(1)


def run(scenario: Scenario) -> None:
    asyncio.run(asyncio.wait_for(scenario(), 2 * PATIENCE))  # type: ignore[arg-type]


def stored_values(served: Served, frame: int) -> np.ndarray[Any, Any]:
    values = served.workspace.labels.values("wall", frame)
    return np.where(values.deleted, np.uint16(65535), values.label)


async def paint(client: Viewer, frame: int, radius: float = 0.3, **brush: Any) -> dict[str, Any]:
    """A whole stroke somewhere where it changes something; the final answer."""
    chosen = {"label": 1, "radius": radius, **brush}
    while True:
        stroke = str(uuid.uuid4())
        await client.send(type="stroke_begin", id=stroke, frame=frame, brush=chosen)
        x, y = RANDOM.uniform(-2, 2, 2).tolist()
        await client.send(type="stroke_samples", id=stroke, samples=[{"origin": [x, y, 3.0]}])
        await client.send(type="stroke_end", id=stroke)
        answer = await client.until("stroke_result", final=True, id=stroke)
        if answer["changed"]:
            return answer


async def settled(client: Viewer, frame: int, revision: int) -> None:
    """Wait until the viewer has a frame's values of a revision."""
    while client.frames[frame].revision < revision:
        await client.receive()


async def shown(served: Served, frame: int) -> tuple[int, dict[int, HeldFrame]]:
    """The revision and the frames of a viewer who has seen all of a frame, and left."""
    async with viewer(served.url, served.token) as client:
        info = await client.open("wall", frame=frame)
        await client.until("frame", frame=frame, final=True)
    return info["revision"], client.frames
