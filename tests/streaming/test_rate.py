"""The link's estimate, the page's budget, the pace: against simulated links."""

from __future__ import annotations

import asyncio
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pointbrush.streaming.load import SENDS_A_TURN, Load
from pointbrush.streaming.rate import UNLIMITED, Link, Pace, PageBudget


class Pipe:
    """A link that carries ``rate`` bytes a second after ``delay`` seconds."""

    def __init__(self, rate: float, delay: float) -> None:
        self.rate, self.delay, self.free = rate, delay, 0.0

    def carry(self, nbytes: int, now: float) -> float:
        """When the credit for a message sent now comes back."""
        self.free = max(self.free, now) + nbytes / self.rate
        return self.free + self.delay


def saturate(link: Link, pipe: Pipe, seconds: float, size: int = 20_000, now: float = 0.0) -> float:
    """Always another message, as much as the window allows; returns the time."""
    acks: list[float] = []
    end = now + seconds
    while now < end:
        while link.has_room:
            link.sent(size, now)
            acks.append(pipe.carry(size, now))
        now = acks.pop(0)
        link.credited(1, now)
    while acks:
        link.credited(1, acks.pop(0))
    return now


@given(rate=st.floats(5e4, 5e7), delay=st.floats(0, 0.2))
def test_a_full_link_is_measured(rate: float, delay: float) -> None:
    link = Link(credits=64)
    saturate(link, Pipe(rate, delay), 5.0, size=max(1000, int(rate / 100)))
    assert 0.5 * rate < link.rate < 1.5 * rate


def test_a_slower_link_is_noticed_at_the_next_credit() -> None:
    link, pipe = Link(credits=8), Pipe(10e6, 0.01)
    now = saturate(link, pipe, 2.0, size=100_000)
    pipe.rate = 0.5e6
    now = saturate(link, pipe, 1.0, size=100_000, now=now)
    assert link.rate < 1e6
    pipe.rate = 10e6
    saturate(link, pipe, 3.0, size=100_000, now=now)
    assert link.rate > 5e6


def test_an_idle_link_with_a_long_way_is_not_taken_for_a_slow_one() -> None:
    link, pipe = Link(credits=8), Pipe(10e6, 0.1)
    now = saturate(link, pipe, 2.0)
    before = link.rate
    for _ in range(100):
        link.sent(50_000, now, idle=True)
        link.credited(1, pipe.carry(50_000, now))
        now += 0.5
    assert link.rate >= 0.9 * before


@given(st.lists(st.one_of(st.integers(1, 2_000_000), st.integers(-64, -1)), max_size=200))
def test_in_flight_is_bounded_whatever_the_credits_say(steps: list[int]) -> None:
    link, now = Link(credits=8), 0.0
    for step in steps:
        now += 0.001
        if step < 0:
            link.credited(-step, now)
        elif link.has_room:
            window = link.window
            link.sent(step, now)
            assert link._bytes <= window + step
    assert link._bytes == sum(sent.nbytes for sent in link._flight)


def test_a_page_that_falls_behind_gets_fewer_points_and_more_again() -> None:
    page = PageBudget()
    assert page.limit == UNLIMITED
    now = 0.0
    for _ in range(20):
        now += 0.3
        page.report(40.0, 11.1, None, min(200_000, page.limit), now)
    slow = page.limit
    assert slow < 20_000
    for _ in range(60):
        now += 0.3
        page.report(5.0, 11.1, None, min(200_000, page.limit), now)
    assert page.limit > 200_000
    page.report(0, 0, 5_000, 200_000, now)
    assert page.limit == 5_000


def test_pace_eases_off_after_skipped_frames_and_comes_back() -> None:
    pace, now = Pace(), 0.0
    for _ in range(5):
        now += 0.5
        pace.left(skipped=2, lead=0.0, now=now)
    assert pace.ease < 0.05
    for _ in range(60):
        now += 0.5
        pace.left(skipped=0, lead=0.9, now=now)
    assert pace.ease == 1.0


@pytest.mark.parametrize(("lag", "busy"), [(0.1, 0.2), (0.0, 0.95)])
def test_a_busy_loop_sends_less_and_more_again(lag: float, busy: float) -> None:
    load = Load()
    load.note(0.0, 0.1, 0.0, 100)
    at_first = load.each
    assert 0 < at_first < math.inf
    for _ in range(100):
        load.note(lag, busy, load.each * 100, 100)
    assert load.strained
    assert load.each < 0.1 * at_first
    for _ in range(200):
        load.note(0.001, 0.1, load.each * 100, 100)
    assert not load.strained
    assert load.each > at_first


def test_what_the_server_can_send_is_shared_by_those_who_follow() -> None:
    load = Load()
    load.note(0.0, 0.1, 0.0, 4)
    four = load.each
    load.note(0.0, 0.1, 0.0, 100)
    assert load.each == pytest.approx(four / 25, rel=0.1)
    load.note(0.0, 0.1, 0.0, 0)
    assert load.each == math.inf


def test_a_budget_that_nobody_uses_does_not_grow() -> None:
    load = Load()
    load.note(0.0, 0.1, 0.0, 1)
    before = load.each
    for _ in range(1000):
        load.note(0.0, 0.1, 1e6, 1)
    assert load.each < 2 * before


def test_points_are_sent_a_few_at_a_time_and_in_the_order_asked() -> None:
    async def scenario() -> None:
        load, sent = Load(), []

        async def send(viewer: int) -> None:
            await load.turn()
            sent.append(viewer)

        tasks = [asyncio.create_task(send(viewer)) for viewer in range(20)]
        counts = []
        while len(sent) < 20:
            before = len(sent)
            await asyncio.sleep(0)
            counts.append(len(sent) - before)
        assert max(counts) <= SENDS_A_TURN
        assert sent == list(range(20))
        await asyncio.gather(*tasks)

    asyncio.run(scenario())


def test_points_wait_for_an_edit_but_not_for_ever() -> None:
    async def scenario() -> None:
        load = Load()
        with load.edit():
            first = asyncio.create_task(load.turn())
            gone = asyncio.create_task(load.turn())
            await asyncio.sleep(0)
            assert not first.done()
            gone.cancel()
            await first
            held = asyncio.create_task(load.turn())
            await asyncio.sleep(0)
            assert not held.done()
        await held

    asyncio.run(scenario())
