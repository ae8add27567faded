"""Objects of a recording are replaced in a bucket while it is open and read."""

from __future__ import annotations

import io
import itertools
import threading
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress

import httpx
import msgpack
import numpy as np
from websockets.exceptions import WebSocketException

from tests.faults.clients import FRAMES, SEQUENCE, SocketTalk
from tests.faults.server import TOKEN, ServerProcess
from tests.torture.authors import quiet
from tests.torture.framework import Arena, Tally, alongside, scenario
from tests.torture.scenarios.buckets import BUCKET, FOLDER, Place
from tests.waiting import eventually

READERS = 3
TITLE = "Damaged recording"


class Readers:
    """Threads that read all frames, and compare every whole answer with the truth."""

    def __init__(self, server: ServerProcess, truth: list[bytes], tally: Tally) -> None:
        self._server, self._truth, self._tally = server, truth, tally
        self._stop, self._lock = threading.Event(), threading.Lock()
        self.seen: set[int] = set()
        """Frames that were answered."""

    def reading(self) -> AbstractContextManager[None]:
        """Read until the context ends."""
        return alongside(self._stop, [self._read] * READERS + [self._watch])

    def _read(self) -> None:
        frames = itertools.cycle(range(FRAMES))
        with self._server.api() as api:
            while not self._stop.is_set():
                frame = next(frames)
                answer = api.get(f"/sequences/{SEQUENCE}/frames/{frame}/points")
                with self._lock:
                    self._count(frame, answer)

    def _count(self, frame: int, answer: httpx.Response) -> None:
        if answer.status_code == 500 and answer.json()["title"] == TITLE:
            self._tally.damaged += 1
        elif (
            self._tally.status(answer.status_code, answer.text[:500])
            and answer.content != self._truth[frame]
        ):
            self._tally.count("differs", f"frame {frame} has other points, and no error")
        self.seen.add(frame)

    def _watch(self) -> None:
        gone = (WebSocketException, TimeoutError)
        with suppress(*gone), SocketTalk(self._server.url, TOKEN, "ann") as talk:
            talk.send(type="play", frame=0)
            while not self._stop.is_set():
                message = msgpack.unpackb(talk.socket.recv(timeout=2))
                if message["type"] == "frame":
                    talk.send(type="credit", frames=1)


def _points(server: ServerProcess) -> list[bytes]:
    with server.api() as api:
        paths = [f"/sequences/{SEQUENCE}/frames/{frame}/points" for frame in range(FRAMES)]
        return [api.get(path).raise_for_status().content for path in paths]


@contextmanager
def _replaced(place: Place, key: str, other: bytes) -> Iterator[None]:
    """An object has other bytes until the context ends."""
    whole = place.s3.get_object(Bucket=BUCKET, Key=key)["Body"].read()
    place.s3.put_object(Bucket=BUCKET, Key=key, Body=other)
    try:
        yield
    finally:
        place.s3.put_object(Bucket=BUCKET, Key=key, Body=whole)


@scenario("objects of an open recording are replaced in a bucket while it is read", 1)
def bucket_replaced(arena: Arena) -> None:
    """Each frame is as it was imported or told to be damaged, and whole once it is back.

    Each server begins with an empty cache: what it has fetched it keeps.
    """
    place, tally = Place(arena), arena.tally
    with place.serving() as server:
        truth = _points(server)
    assert len({np.load(io.BytesIO(each)).tobytes() for each in truth}) == FRAMES
    listed = place.s3.list_objects_v2(Bucket=BUCKET, Prefix=f"{FOLDER}/{SEQUENCE}/")["Contents"]
    keys = sorted(each["Key"] for each in listed if "/frames/" in each["Key"])
    for _ in arena.rounds():
        with place.serving() as server, server.api() as api:
            api.get(f"/sequences/{SEQUENCE}").raise_for_status()  # it is open
            with ExitStack() as stack:
                for key in arena.rng.sample(keys, 3):
                    stack.enter_context(_replaced(place, key, _other(place, key, keys)))
                readers = Readers(server, truth, tally)
                with readers.reading():
                    eventually(lambda readers=readers: readers.seen == set(range(FRAMES)), 60, 0.1)
                    stack.close()  # and back, while it is read
                    time.sleep(arena.rng.uniform(0.0, 0.5))
            eventually(lambda server=server: _is_whole(server, truth), 60, 0.5)
            quiet(server, tally)
    assert tally.damaged, "no replaced object was noticed"


def _other(place: Place, key: str, keys: list[str]) -> bytes:
    """Return an object's bytes with one bit flipped, or those of another frame."""
    kind = key.rpartition(".")[2]
    same = [each for each in keys if each != key and each.endswith(f".{kind}")]
    whole, other = (
        place.s3.get_object(Bucket=BUCKET, Key=each)["Body"].read()
        for each in (key, place.arena.rng.choice(same))
    )
    at = place.arena.rng.randrange(len(whole))
    flipped = whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :]
    return bytes(place.arena.rng.choice([flipped, other]))


def _is_whole(server: ServerProcess, truth: list[bytes]) -> bool:
    try:
        return _points(server) == truth
    except httpx.HTTPStatusError:
        return False
