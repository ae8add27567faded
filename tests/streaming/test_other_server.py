"""Two servers on one PostgreSQL: a viewer of one hears of all that is committed at the other."""

from __future__ import annotations

import asyncio
import uuid
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import psycopg
import pytest

from pointbrush.labels import Write
from pointbrush.workspace import Workspace
from tests.serving import Served, add_sequence, serving, settings_in
from tests.streaming.acting import run
from tests.streaming.client import Viewer, viewer

POINTS = 2_000


@pytest.fixture
def there(tmp_path: Path, labels_url: str) -> Iterator[Served]:
    """A server whose statements end after a second."""
    settings = settings_in(tmp_path, database=labels_url, statement_seconds=1)
    add_sequence(settings, "wall", frames=2, points=POINTS)
    with serving(settings) as running:
        running.workspace.labels.create_label("wall", "somebody", name="pin")
        yield running


def paint(here: Workspace, author: str, points: int) -> int:
    """Label the first points of frame 0; the revision."""
    write = Write(np.arange(points), label=1, provenance=1)
    return here.labels.apply(
        "wall",
        edit_id=str(uuid.uuid4()),
        author=author,
        kind="paint",
        writes={0: write},
        summary="",
    ).revision


async def told(client: Viewer, revision: int, points: int) -> None:
    """Wait until the viewer has the values of a revision."""
    while client.frames[0].revision < revision:
        await client.receive()
    values = client.frames[0].values
    assert values is not None
    assert np.count_nonzero(values) == points


def test_a_viewer_is_told_though_the_authors_name_could_not_be_read(
    there: Served,
    labels_url: str,
) -> None:
    async def scenario(here: Workspace) -> None:
        async with viewer(there.url, there.token) as client:
            await client.open("wall")
            await client.until("frame", frame=0, final=True)
            await told(client, await asyncio.to_thread(paint, here, "ann", 10), 10)
            with psycopg.connect(labels_url) as other:
                other.execute("LOCK TABLE accounts IN ACCESS EXCLUSIVE MODE")
                # By somebody whose name the other server has to look up.
                revision = await asyncio.to_thread(paint, here, "session:1", 20)
                await told(client, revision, 20)
            assert client.gaps == 0

    with closing(Workspace(there.workspace.settings)) as here:
        run(lambda: scenario(here))


def test_a_viewer_hears_of_every_edit_of_many_at_the_other_server(there: Served) -> None:
    async def scenario(here: Workspace) -> None:
        async with viewer(there.url, there.token) as client:
            await client.open("wall")
            await client.until("frame", frame=0, final=True)
            for count in range(1, 31):
                await told(client, await asyncio.to_thread(paint, here, "ann", count), count)
            assert client.gaps == 0

    with closing(Workspace(there.workspace.settings)) as here:
        run(lambda: scenario(here))
