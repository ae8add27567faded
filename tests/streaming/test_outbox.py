from __future__ import annotations

import asyncio

from pointbrush.streaming.outbox import Wake
from tests.waiting import PATIENCE


def test_a_ring_before_the_wait_is_not_lost_and_wakes_once() -> None:
    async def scenario() -> None:
        wake = Wake()
        wake.set()
        await asyncio.wait_for(wake.wait(None), PATIENCE)
        wake.clear()
        waiting = asyncio.create_task(wake.wait(None))
        await asyncio.sleep(0)
        assert not waiting.done()
        wake.set()
        wake.set()
        await asyncio.wait_for(waiting, PATIENCE)

    asyncio.run(scenario())


def test_a_wait_ends_by_itself_and_leaves_nothing_behind() -> None:
    async def scenario() -> None:
        wake = Wake()
        await asyncio.wait_for(wake.wait(0.001), PATIENCE)
        wake.clear()
        waiting = asyncio.create_task(wake.wait(0.001))
        await asyncio.sleep(0)
        waiting.cancel()
        await asyncio.gather(waiting, return_exceptions=True)
        await asyncio.sleep(0.01)
        # The timer of the wait that was given up does not ring.
        waiting = asyncio.create_task(wake.wait(None))
        await asyncio.sleep(0)
        assert not waiting.done()
        wake.set()
        await asyncio.wait_for(waiting, PATIENCE)

    asyncio.run(scenario())


def test_a_ring_tells_whether_it_was_for_points() -> None:
    wake = Wake()
    wake.set(points=False)
    assert not wake.clear()
    wake.set()
    wake.set(points=False)
    assert wake.clear()
    assert not wake.clear()
