"""The palette keeps the order that a person gave it."""

from __future__ import annotations

import pytest

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.teamwork.store import WorkspaceStore

SEQ = "juggling"


def names(store: WorkspaceStore) -> list[str]:
    return [label.name for label in store.palette(SEQ)]


def test_labels_are_arranged_as_one_edit(store: WorkspaceStore) -> None:
    for name in "abcd":
        store.create_label(SEQ, "me", name=name)
    store.arrange_labels(SEQ, "me", [3, 1])
    assert names(store) == ["c", "a", "b", "d"]
    store.create_label(SEQ, "me", name="e")
    assert names(store) == ["c", "a", "b", "d", "e"]
    store.update_label(SEQ, "me", 3, name="first")
    assert names(store)[0] == "first"
    assert store.check(SEQ) == []
    for _ in range(3):
        store.undo(SEQ, "me")
    assert names(store) == ["a", "b", "c", "d"]
    assert store.check(SEQ) == []


@pytest.mark.parametrize("order", [[1, 1], [0], [70_000]])
def test_an_order_that_makes_no_sense_is_refused(store: WorkspaceStore, order: list[int]) -> None:
    store.create_label(SEQ, "me", name="a")
    with pytest.raises(BadInputError):
        store.arrange_labels(SEQ, "me", order)
    with pytest.raises(NotFoundError):
        store.arrange_labels(SEQ, "me", [1, 2])
