"""Frames are fetched in the direction of looking, the newest wishes first, a bounded number."""

from __future__ import annotations

import threading

from pointbrush.errors import UnavailableError
from pointbrush.sequences.storage.read_ahead import AHEAD_BYTES, AHEAD_FRAMES, THREADS, ReadAhead
from tests.waiting import eventually


class Frames:
    """Frames that come once ``open`` is set."""

    def __init__(self, count: int, nbytes: int = 0) -> None:
        self.fetched: list[int] = []
        self.open = threading.Event()
        self.ahead = ReadAhead(count, nbytes, self.fetch)

    def fetch(self, index: int) -> None:
        self.fetched.append(index)
        assert self.open.wait(20)
        if index == 1:
            raise UnavailableError("expected an answer, got none")


def test_forward_and_back_within_the_recording() -> None:
    frames = Frames(40)
    frames.open.set()
    frames.ahead.looked_at(0)
    eventually(lambda: sorted(frames.fetched) == list(range(1, AHEAD_FRAMES + 1)))
    frames.fetched.clear()
    frames.ahead.looked_at(39)
    frames.ahead.looked_at(38)
    eventually(lambda: sorted(frames.fetched) == list(range(38 - AHEAD_FRAMES, 38)))


def test_after_a_jump_the_frames_there_come_first() -> None:
    frames = Frames(100)
    frames.ahead.looked_at(0)
    eventually(lambda: len(frames.fetched) == THREADS)
    frames.ahead.looked_at(50)
    frames.open.set()
    wanted = [*range(51, 51 + AHEAD_FRAMES), *range(THREADS + 1, AHEAD_FRAMES + 1)]
    eventually(lambda: len(frames.fetched) == THREADS + len(wanted))
    assert set(frames.fetched[THREADS : THREADS + AHEAD_FRAMES]) == set(wanted[:AHEAD_FRAMES])


def test_of_large_frames_fewer_come() -> None:
    frames = Frames(100, nbytes=100 * AHEAD_BYTES // 2)
    frames.open.set()
    frames.ahead.looked_at(10)
    eventually(lambda: sorted(frames.fetched) == [11, 12])
    frames.ahead.looked_at(90)
    eventually(lambda: sorted(frames.fetched) == [11, 12, 91, 92])
