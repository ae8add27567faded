"""Categories have one number in a workspace, for ever."""

from __future__ import annotations

import pytest

from pointbrush.errors import BadInputError, ConflictError
from pointbrush.labels import Category, LabelStore


def test_a_category_keeps_the_number_that_it_got_first(store: LabelStore) -> None:
    assert store.taxonomy.numbers(["car", "person"]) == {"car": 1, "person": 2}
    assert store.taxonomy.numbers(["person", "tree", "car"]) == {"person": 2, "tree": 3, "car": 1}
    assert [entry.name for entry in store.taxonomy.entries()] == ["car", "person", "tree"]


def test_names_and_colours_change_and_numbers_do_not(store: LabelStore) -> None:
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
