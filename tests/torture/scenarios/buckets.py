"""Object storage refuses, fails, is slow, cuts its answers, or has an object changed in it."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

import boto3

from tests.faults.clients import FRAMES, SEQUENCE
from tests.faults.server import ServerProcess, running
from tests.torture.authors import Authors, quiet
from tests.torture.faulty_bucket import FAULTS, FaultyBucket
from tests.torture.framework import Arena, Tally, scenario
from tests.torture.librarian import Librarian

BUCKET, FOLDER = "lab", "recordings"


class Place:
    """A workspace whose recordings are in a faulty bucket."""

    def __init__(self, arena: Arena) -> None:
        self.arena, self.workspace = arena, arena.folder / "workspace"
        self.authors = Authors(self.workspace, arena.seed)
        self.faulty = arena.stack.enter_context(FaultyBucket())
        self.s3 = boto3.client("s3", **self.faulty.credentials)
        self.s3.create_bucket(Bucket=BUCKET)
        root = self.workspace / "sequences"
        for file in filter(Path.is_file, root.rglob("*")):
            name = f"{FOLDER}/{file.relative_to(root)}"
            self.s3.put_object(Bucket=BUCKET, Key=name, Body=file.read_bytes())
        self._servers = 0

    def serving(self) -> AbstractContextManager[ServerProcess]:
        """A server that has nothing of the bucket in its cache yet."""
        self._servers += 1
        return running(
            self.workspace,
            POINTBRUSH_SEQUENCES=f"s3://{BUCKET}/{FOLDER}",
            POINTBRUSH_SEQUENCE_CACHE=str(self.arena.folder / f"cache-{self._servers}"),
            **self.faulty.environment,
        )


@scenario("object storage answers 403, 500, slowly or in part, during edits and imports", 2)
def bucket_faulty(arena: Arena) -> None:
    """Each server begins with an empty cache."""
    place, librarian = Place(arena), Librarian(arena)
    for _ in arena.rounds():
        with place.serving() as server:
            with (
                place.authors.editing(lambda: [server.url]),
                librarian.importing(lambda: server.url),
            ):
                for fault in arena.rng.sample(FAULTS, len(FAULTS)):
                    place.faulty.fault = fault
                    time.sleep(arena.rng.uniform(0.2, 1.5))
                    place.faulty.fault = ""
                    time.sleep(arena.rng.uniform(0.0, 0.5))
            place.authors.settle(server, arena.tally)
            librarian.settle(server)
            quiet(server, arena.tally)


@scenario("an object in object storage is changed, cut or removed while it is served", 1)
def bucket_changed(arena: Arena) -> None:
    """The frame is told to be damaged, the others are served, and it too once it is back."""
    place = Place(arena)
    for _ in arena.rounds():
        frame = arena.rng.randrange(FRAMES)
        with place.serving() as server:
            with _changed(place, frame):
                _look(server, frame, arena.tally)
            _look(server, None, arena.tally)
            quiet(server, arena.tally)


@contextmanager
def _changed(place: Place, frame: int) -> Iterator[None]:
    """The points of a frame are other bytes, fewer bytes, or none, until the context ends."""
    key = f"{FOLDER}/{SEQUENCE}/frames/{frame:06d}.points"
    whole = place.s3.get_object(Bucket=BUCKET, Key=key)["Body"].read()
    middle = len(whole) // 2
    changed = whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :]
    content = place.arena.rng.choice([changed, whole[:middle], None])
    if content is None:
        place.s3.delete_object(Bucket=BUCKET, Key=key)
    else:
        place.s3.put_object(Bucket=BUCKET, Key=key, Body=content)
    try:
        yield
    finally:
        place.s3.put_object(Bucket=BUCKET, Key=key, Body=whole)


def _look(server: ServerProcess, damaged: int | None, tally: Tally) -> None:
    """Ask for all frames; all but the damaged one must be answered."""
    with server.api() as api:
        for frame in range(FRAMES):
            response = api.get(f"/sequences/{SEQUENCE}/frames/{frame}/points")
            if frame != damaged:
                if not tally.status(response.status_code, response.text):
                    tally.count("differs", f"frame {frame}: {response.text}")
            elif f"frame {frame} is damaged" not in response.text:
                tally.count(
                    "differs", f"frame {frame}: {response.status_code} {response.text[:300]}"
                )
