"""The classes of two datasets that two recordings learn at the same moment."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from threading import Barrier

import httpx
import numpy as np
from sqlalchemy import delete

from pointbrush.database.database import Database
from pointbrush.database.schema import categories, dataset_numbers
from pointbrush.formats.tables.datasets import NUSCENES, SEMANTIC_KITTI, Dataset
from tests.serving import add_sequence, settings_in
from tests.torture.authors import quiet
from tests.torture.framework import Arena, scenario
from tests.torture.operations import waited

RECORDINGS = ("one", "two")
POINTS = 40
"""At least one for each class of SemanticKITTI."""
Learn = Callable[[httpx.Client, str], object]


def _template(dataset: Dataset) -> Learn:
    def learn(api: httpx.Client, recording: str) -> None:
        body = {"template": dataset.name}
        api.post(f"/sequences/{recording}/palette", json=body).raise_for_status()

    return learn


def _import(api: httpx.Client, recording: str) -> None:
    numbers = np.resize(np.array(list(SEMANTIC_KITTI.classes), "<u4"), POINTS)
    files = [("files", ("000000.label", numbers.tobytes()))]
    data = {"format": "semantickitti"}
    waited(api, api.post(f"/sequences/{recording}/annotations", files=files, data=data))


TEMPLATES = (_template(SEMANTIC_KITTI), _template(NUSCENES))
IMPORTED = (_import, _template(NUSCENES))
PAIRS: tuple[tuple[Learn, Learn], ...] = (
    TEMPLATES, TEMPLATES[::-1], IMPORTED, IMPORTED[::-1],
)  # fmt: skip
"""Two that learn at once, in both orders."""


def _learned(arena: Arena, url: str, servers: int) -> None:
    settings = settings_in(arena.folder)
    for name in RECORDINGS:
        add_sequence(settings, name, frames=1, points=POINTS)
    served = arena.serve(settings.workspace, url, servers)
    apis = [arena.stack.enter_context(server.api()) for server in (served[0], served[-1])]
    url = url or f"sqlite:///{settings.workspace / 'labels.sqlite'}"
    database = arena.stack.enter_context(closing(Database(url)))
    pool = arena.stack.enter_context(ThreadPoolExecutor(len(RECORDINGS)))
    for number in arena.rounds():
        for pair in PAIRS if number == 0 else (PAIRS[number % len(PAIRS)],):
            ready = Barrier(len(pair))

            def learn(what: Learn, api: httpx.Client, name: str, go: Barrier = ready) -> None:
                go.wait()
                what(api, name)

            list(pool.map(learn, pair, apis, RECORDINGS))
            arena.tally.answered += len(pair)
            _compare(arena, apis[0])
            _forget(apis, database)
    for server in served:
        quiet(server, arena.tally)


def _compare(arena: Arena, api: httpx.Client) -> None:
    """Look for each class of both datasets, under its name and with its number there."""
    found = api.get("/taxonomy").raise_for_status().json()["categories"]
    known = {entry["name"]: entry for entry in found}
    for dataset in (SEMANTIC_KITTI, NUSCENES):
        for number, each in dataset.classes.items():
            there = known.get(each.name, {"datasets": {}})["datasets"].get(dataset.name)
            if there != number:
                told = f"{dataset.name}: expected {each.name} to be {number}, got {there}"
                arena.tally.count("lost" if there is None else "differs", told)
    if len({entry["number"] for entry in found}) < len(found):
        arena.tally.count("differs", f"categories of one number: {found}")


def _forget(apis: list[httpx.Client], database: Database) -> None:
    """Take the labels back, and the classes away: the next round learns them again."""
    for api, name in zip(apis, RECORDINGS, strict=True):
        while api.get(f"/sequences/{name}/labels").raise_for_status().json():
            api.post(f"/sequences/{name}/undo").raise_for_status()
    with database.write() as connection:
        connection.execute(delete(dataset_numbers))
        connection.execute(delete(categories))


@scenario("templates and imports of two datasets at the same moment, one SQLite server", 2)
def taxonomy(arena: Arena) -> None:
    """No class is lost or renamed, whichever came first."""
    _learned(arena, "", 1)


@scenario("the same with two servers on PostgreSQL", 2)
def taxonomy_two_servers(arena: Arena) -> None:
    """A recording at each server."""
    _learned(arena, arena.postgres().new_labels(), 2)
