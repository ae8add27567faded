"""Categories have one number in a workspace, for ever."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from threading import Barrier

import pytest

from pointbrush.errors import BadInputError, ConflictError
from pointbrush.formats.tables.datasets import NUSCENES, SEMANTIC_KITTI, Dataset
from pointbrush.labels import Category
from pointbrush.teamwork.store import WorkspaceStore


def test_a_category_keeps_the_number_that_it_got_first(store: WorkspaceStore) -> None:
    assert store.taxonomy.numbers(["car", "person"]) == {"car": 1, "person": 2}
    assert store.taxonomy.numbers(["person", "tree", "car"]) == {"person": 2, "tree": 3, "car": 1}
    assert [entry.name for entry in store.taxonomy.entries()] == ["car", "person", "tree"]


def test_names_and_colours_change_and_numbers_do_not(store: WorkspaceStore) -> None:
    store.taxonomy.numbers(["car", "person"])
    store.taxonomy.put([Category(1, "vehicle", "#ff0000"), Category(10, "road")])
    assert store.taxonomy.entries() == [
        Category(1, "vehicle", "#ff0000"),
        Category(2, "person"),
        Category(10, "road"),
    ]
    assert store.taxonomy.numbers(["sky"]) == {"sky": 11}
    store.taxonomy.put([Category(1, "person"), Category(2, "vehicle")])
    assert store.taxonomy.numbers(["person", "vehicle"]) == {"person": 1, "vehicle": 2}
    with pytest.raises(ConflictError, match="'road' to keep its number 10, got 4"):
        store.taxonomy.put([Category(4, "road")])
    for wanted in (
        [Category(0, "a")],
        [Category(70_000, "a")],
        [Category(5, " ")],
        [Category(5, "a"), Category(5, "b")],
        [Category(5, "a"), Category(6, "a")],
    ):
        with pytest.raises(BadInputError):
            store.taxonomy.put(wanted)
    assert len(store.taxonomy.entries()) == 4


@pytest.mark.parametrize("servers", [1, 2])
@pytest.mark.parametrize("first", [SEMANTIC_KITTI, NUSCENES], ids=lambda dataset: dataset.name)
def test_two_datasets_that_are_learned_at_once_keep_all_their_classes(
    url: str, servers: int, first: Dataset
) -> None:
    """Templates and imports of two recordings, at one server or at two, in both orders."""
    second = NUSCENES if first is SEMANTIC_KITTI else SEMANTIC_KITTI
    with ExitStack() as stack:
        stores = [stack.enter_context(closing(WorkspaceStore(url))) for _ in range(servers)]
        ready = Barrier(2)

        def learn(store: WorkspaceStore, dataset: Dataset) -> None:
            numbers = {each.name: number for number, each in dataset.classes.items()}
            ready.wait()
            store.taxonomy.numbers([f"{dataset.name} {k}" for k in range(20)])
            store.taxonomy.learn(dataset.name, numbers, strict=False)

        with ThreadPoolExecutor(2) as pool:
            running = [
                pool.submit(learn, store, dataset)
                for store, dataset in ((stores[0], first), (stores[-1], second))
            ]
        for each in running:
            each.result()
        entries = {entry.name: entry for entry in stores[0].taxonomy.entries()}
    for dataset in (first, second):
        for number, known in dataset.classes.items():
            assert entries[known.name].datasets[dataset.name] == number
        assert {f"{dataset.name} {k}" for k in range(20)} <= entries.keys()
