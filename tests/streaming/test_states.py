"""Palette and timeline reach every viewer, however many read them at once."""

from __future__ import annotations

import asyncio

import httpx

from tests.serving import Served
from tests.streaming.client import Viewer, viewer
from tests.waiting import PATIENCE

CHANGES = 40


def test_every_viewer_hears_the_last_change_of_the_palette(served: Served) -> None:
    async def listen(client: Viewer, color: str) -> None:
        while True:
            message = await client.until("labels")
            if message["labels"][0]["color"] == color:
                return

    async def scenario() -> None:
        async with (
            viewer(served.url, served.token) as one,
            viewer(served.url, served.token) as other,
            httpx.AsyncClient(base_url=f"{served.url}/api/v1", headers=served.headers) as api,
        ):
            for client in (one, other):
                await client.hello()
                await client.open("wall")
            for number in range(CHANGES):
                color = f"#{number:06x}"
                # Reading states for one reason must not swallow another that comes meanwhile.
                await one.send(type="presence", frame=0, brush=[number * 0.01, 0.0, 0.0])
                patched = await api.patch("/sequences/wall/labels/1", json={"color": color})
                assert patched.status_code == 200
                await asyncio.gather(listen(one, color), listen(other, color))

    asyncio.run(asyncio.wait_for(scenario(), PATIENCE))
