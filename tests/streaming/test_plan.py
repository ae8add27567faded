"""What is sent next: clock, levels, look-ahead, refinement, memory of what was sent."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pointbrush.streaming.outbox import MOST_DELTA_BYTES, Outbox, QueuedDelta
from pointbrush.streaming.plan import Piece, Plan, PlayClock, Unopened
from pointbrush.streaming.rate import Link
from pointbrush.streaming.table import FrameTable

LEVELS = 6
POINTS = tuple(2_000 * 2**level for level in range(LEVELS))
TABLE = FrameTable(
    stops=tuple(range(1, LEVELS + 1)),
    nbytes=tuple(6 * points for points in POINTS),
    points=POINTS,
    ends=tuple(6 * points for points in POINTS),
    firsts=(0, *POINTS),
)


def plan_with(rate: float) -> Plan:
    link = Link(credits=8)
    link.rate = rate
    return Plan(frames=100, link=link)


def take(plan: Plan, now: float) -> Piece | None:
    piece = plan.next(now, dict.fromkeys(range(100), TABLE).get)
    assert not isinstance(piece, Unopened)
    if piece is not None:
        plan.sent(piece, now)
    return piece


def test_a_paused_frame_comes_coarse_first_then_all_of_it_then_its_neighbours() -> None:
    plan = plan_with(1e6)
    plan.seek(10)
    pieces = []
    while (piece := take(plan, 0.0)) is not None:
        pieces.append(piece)
    own = [piece for piece in pieces if piece.frame == 10]
    assert pieces[: len(own)] == own
    assert (own[0].first, own[0].stop) == (0, 1)
    assert [piece.first for piece in own[1:]] == [piece.stop for piece in own[:-1]]
    assert own[-1].final
    assert {piece.frame for piece in pieces} == {9, 10, 11, 12, 13, 14}


def test_frames_laid_over_one_come_behind_it_and_before_its_neighbours() -> None:
    plan = plan_with(1e9)
    plan.seek(10, around=[30, 20])
    order = []
    while (piece := take(plan, 0.0)) is not None:
        order.append(piece.frame)
    assert list(dict.fromkeys(order))[:3] == [10, 30, 20]
    plan.seek(12)
    assert [frame for _, frame in plan.candidates(0.0)] == [12, 13, 14, 15, 16, 11]


def test_prefetch_goes_where_the_finger_goes() -> None:
    plan = plan_with(1e9)
    plan.seek(50)
    plan.seek(40)
    frames = {piece.frame for _ in range(50) if (piece := take(plan, 0.0))}
    assert frames == {41, 40, 39, 38, 37, 36}


def test_a_busy_server_does_not_prefetch() -> None:
    plan = plan_with(1e9)
    plan.load.note(lag=0.1, busy=0.2, sent=0.0, followers=0)
    plan.seek(10)
    assert {piece.frame for _ in range(50) if (piece := take(plan, 0.0))} == {10}


def test_nothing_is_sent_twice_until_it_is_forgotten() -> None:
    plan = plan_with(1e9)
    plan.seek(10)
    while take(plan, 0.0):
        pass
    plan.forget([10])
    piece = take(plan, 0.0)
    assert piece is not None
    assert (piece.frame, piece.first) == (10, 0)


@pytest.mark.parametrize(("rate", "level"), [(1e9, 5), (3e6, 2), (1e6, 1), (1e5, 0)])
def test_playing_takes_the_level_the_link_allows(rate: float, level: int) -> None:
    plan = plan_with(rate)
    plan.play(PlayClock(0, 0.0, 30.0, 100))
    sent: list[Piece] = []
    for tick in range(300):
        piece = take(plan, tick / 100)
        if piece:
            sent.append(piece)
    assert sent[-1].stop - 1 == level
    frames = [piece.frame for piece in sent]
    assert frames == sorted(frames)
    assert len(set(frames)) == len(frames), "one message a frame"


def test_a_viewer_that_could_not_be_served_goes_on_with_the_newest_frame() -> None:
    plan = plan_with(1e6)
    plan.play(PlayClock(0, 0.0, 30.0, 100))
    take(plan, 0.0)
    piece = take(plan, 1.0)
    assert piece is not None
    assert piece.frame == 30
    assert plan.pace.ease < 1


def test_held_frames_are_not_taken_for_skipped_ones() -> None:
    plan = plan_with(1e9)
    plan.play(PlayClock(0, 0.0, 30.0, 100))
    plan.held = dict.fromkeys(range(20), LEVELS)
    for tick in range(200):
        take(plan, tick / 100)
    assert plan.pace.ease == 1.0
    assert set(range(20, 60)) <= plan.held.keys()


def test_what_comes_behind_a_sent_frame_is_known() -> None:
    plan = plan_with(1e9)
    plan.play(PlayClock(97, 0.0, 30.0, 100))
    coming = []
    for tick in range(20):
        piece = take(plan, tick / 30)
        assert piece is not None
        coming += plan.coming(piece)
    wanted = [(98 + more) % 100 for more in range(len(coming))]
    assert coming == wanted
    plan.pause(5, 1.0)
    assert plan.coming(Piece(5, 0, 1, final=False)) == []


@given(
    start=st.integers(0, 99),
    speed=st.floats(-16, 16),
    loop=st.booleans(),
    now=st.floats(0, 1000),
)
def test_the_clock_stays_in_the_recording(start: int, speed: float, loop: bool, now: float) -> None:
    clock = PlayClock(start, 0.0, 30 * speed, 100, loop)
    assert 0 <= clock.due(now) < 100
    assert all(0 <= frame < 100 for _, frame in clock.ahead(now, 0.3))
    assert clock.next_change(now) >= 0


def test_the_clock_runs_at_its_rate() -> None:
    clock = PlayClock(5, 100.0, 30.0, 10)
    assert [clock.due(100 + i / 30 + 0.001) for i in range(7)] == [5, 6, 7, 8, 9, 0, 1]
    assert [clock.frame(step) for step in range(3)] == [5, 6, 7]
    backward = PlayClock(1, 0.0, -30.0, 10)
    assert [backward.due(i / 30 + 0.001) for i in range(3)] == [1, 0, 9]
    once = PlayClock(8, 0.0, 30.0, 10, loop=False)
    assert once.due(10.0) == 9
    assert math.isinf(once.next_change(10.0))
    fast = PlayClock(0, 0.0, 480.0, 1000)
    assert fast.stride == 8


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(1, 2 * 2**20)), max_size=60))
def test_deltas_are_bounded_and_none_is_lost(given_deltas: list[tuple[int, int]]) -> None:
    outbox, waiting = Outbox(), set()
    for revision, (frame, size) in enumerate(given_deltas):
        # As the session does: a frame whose values will come whole needs no deltas.
        if frame not in outbox.stale:
            outbox.delta(QueuedDelta(frame, revision, bytes(size)))
        waiting.add(frame)
        assert outbox.delta_bytes <= MOST_DELTA_BYTES
        told = {delta.frame for delta in outbox.deltas} | outbox.stale.keys()
        assert told == waiting


def test_deltas_leave_in_order_up_to_a_revision() -> None:
    outbox = Outbox()
    for revision in (3, 4, 6):
        outbox.delta(QueuedDelta(0, revision, b"x"))
    taken = []
    while (delta := outbox.next_delta(up_to=5)) is not None:
        taken.append(delta.revision)
    assert taken == [3, 4]
    assert outbox.delta_bytes == 1
