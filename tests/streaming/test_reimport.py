"""A recording is deleted and another imported under its name: nothing of the old one is served."""

from __future__ import annotations

import shutil
from collections.abc import Iterator

import httpx
import numpy as np
import pytest

from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.work.events import SequencesChanged
from tests.serving import Served, serving, settings_in, surface
from tests.streaming.acting import run
from tests.streaming.client import Viewer, viewer

FRAMES, POINTS = 3, 3_000


def put_in_place(served: Served, seed: int) -> None:
    """Import a recording named ``wall`` where there is none."""
    workspace = served.workspace
    import_frames(
        (surface(POINTS, seed + i) for i in range(FRAMES)),
        workspace.library.folder / "wall",
        RecordingInfo("wall", "wall", 30.0),
    )
    workspace.labels.recordings.register("wall", [POINTS] * FRAMES)
    workspace.labels.create_label("wall", "somebody", name=f"pin {seed}")


def replace(served: Served, seed: int) -> None:
    """Delete what is there; the same as over REST, where nothing runs beside it."""
    served.workspace.deletion.delete("wall")
    put_in_place(served, seed)


@pytest.fixture
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving(settings_in(tmp_path_factory.mktemp("reimport"))) as running:
        put_in_place(running, 100)
        yield running


async def look(client: Viewer, served: Served) -> None:
    """Every frame shows the points and the values that are stored now."""
    for frame in range(FRAMES):
        await client.send(type="seek", frame=frame)
        while frame not in client.frames or not client.frames[frame].final:
            await client.receive()
        stored = served.workspace.recording("wall")[frame]
        held = client.frames[frame]
        assert b"".join(held.data) == bytes(stored.wire(0, len(stored.chunks)))
        np.testing.assert_array_equal(
            held.values, served.workspace.labels.values("wall", frame).label
        )


def paint_all(served: Served, frame: int) -> None:
    values = np.ones(POINTS, np.uint16)
    served.workspace.annotations.put("wall", frame, values, author="somebody")


def test_who_opens_it_later_sees_the_new_one(served: Served) -> None:
    async def scenario() -> None:
        for seed in (200, 300):
            async with viewer(served.url, served.token, keep_data=True) as client:
                await client.open("wall")
                labels = await client.until("labels")
                assert labels["labels"][0]["name"] == f"pin {seed - 100}"
                await look(client, served)
            paint_all(served, 1)
            async with viewer(served.url, served.token, keep_data=True) as client:
                await client.open("wall")
                await look(client, served)
            replace(served, seed)

    run(scenario)


def test_who_had_the_old_one_is_sent_everything_anew(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token, keep_data=True) as client:
            old = await client.open("wall")
            await look(client, served)
            held = [[index, len(frame.chunks)] for index, frame in client.frames.items()]
        replace(served, 200)
        paint_all(served, 2)
        paint_all(served, 1)
        async with viewer(served.url, served.token, keep_data=True) as again:
            past = {"identity": old["identity"], "revision": old["revision"], "held": held}
            new = await again.open("wall", **past)
            assert new["identity"] != old["identity"]
            await look(again, served)

    run(scenario)


def test_who_has_it_open_is_told_and_sent_everything_anew(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token, keep_data=True) as client:
            old = await client.open("wall")
            await look(client, served)
            # As when the server gets round to telling of both changes at once.
            shutil.rmtree(served.workspace.library.folder / "wall")
            served.workspace.labels.recordings.forget("wall")
            put_in_place(served, 200)
            served.workspace._listeners.notify(SequencesChanged("wall"))
            new = await client.until("sequence")
            assert new["identity"] != old["identity"]
            client.frames.clear()
            await look(client, served)
            paint_all(served, 2)
            await client.until("annotation", frame=2)

    run(scenario)


def test_a_chunk_of_the_old_one_is_gone(served: Served) -> None:
    with httpx.Client(base_url=f"{served.url}/api/v1", headers=served.headers) as api:
        table = "/sequences/wall/frames/0/chunks"
        old = {"identity": api.get(table).json()["identity"]}
        first = api.get(f"{table}/0", params=old)
        replace(served, 200)
        assert api.get(f"{table}/0", params=old).status_code == 404
        tag = {"If-None-Match": first.headers["etag"]}
        new = api.get(f"{table}/0", headers=tag)
        assert new.status_code == 200
        assert new.content == bytes(served.workspace.recording("wall")[0].wire(0, 1))


def test_selection_is_in_the_new_points(served: Served) -> None:
    old = served.workspace.recording("wall")[0].kdtree
    replace(served, 200)
    stored = served.workspace.recording("wall")[0]
    assert not np.array_equal(old.data, stored.xyz)
    np.testing.assert_array_equal(stored.kdtree.data, stored.xyz)
