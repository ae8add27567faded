"""Undo in words: each test is a sentence of docs/labels.md."""

from __future__ import annotations

import numpy as np
import pytest

from pointbrush.errors import ConflictError
from pointbrush.labels import Commit, Write
from pointbrush.teamwork.store import WorkspaceStore

SEQ = "juggling"


def paint(store: WorkspaceStore, points: list[int], label: int, author: str) -> Commit:
    write = Write(np.array(points), label=label, provenance=1)
    return store.apply(
        SEQ, edit_id=None, author=author, kind="paint", writes={0: write}, summary=author
    )


def shown(store: WorkspaceStore, count: int = 4) -> list[int]:
    return store.values(SEQ, 0, 0, count).label.tolist()


@pytest.fixture
def pins(store: WorkspaceStore) -> WorkspaceStore:
    for name in ("one", "two", "three"):
        store.create_label(SEQ, "setup", name=name)
    return store


def test_undo_takes_back_only_ones_own_part(pins: WorkspaceStore) -> None:
    paint(pins, [0, 1, 2], 1, "ann")
    paint(pins, [1], 2, "bob")
    commit = pins.undo(SEQ, "ann")
    assert shown(pins) == [0, 2, 0, 0]
    assert commit.frames[0].indices.tolist() == [0, 2]
    pins.undo(SEQ, "bob")
    assert shown(pins) == [0, 0, 0, 0]


def test_redo_goes_back_under_what_others_did_since(pins: WorkspaceStore) -> None:
    paint(pins, [0, 1], 1, "ann")
    pins.undo(SEQ, "ann")
    paint(pins, [1], 2, "bob")
    pins.redo(SEQ, "ann")
    assert shown(pins) == [1, 2, 0, 0]
    pins.undo(SEQ, "bob")
    assert shown(pins) == [1, 1, 0, 0]


def test_undo_uncovers_an_edit_that_was_undone_when_it_was_covered(pins: WorkspaceStore) -> None:
    paint(pins, [0], 1, "ann")
    paint(pins, [0], 2, "bob")
    pins.undo(SEQ, "bob")
    paint(pins, [0], 3, "cat")
    pins.redo(SEQ, "bob")
    assert shown(pins) == [3, 0, 0, 0]
    pins.undo(SEQ, "cat")
    assert shown(pins) == [2, 0, 0, 0]


def test_undo_follows_a_chain_of_undone_edits(pins: WorkspaceStore) -> None:
    for author, label in (("ann", 1), ("bob", 2), ("cat", 3), ("dan", 1), ("eve", 2)):
        paint(pins, [0, 1], label, author)
    for author in ("bob", "dan", "cat"):
        pins.undo(SEQ, author)
        assert shown(pins) == [2, 2, 0, 0]
    pins.undo(SEQ, "eve")
    assert shown(pins) == [1, 1, 0, 0]
    pins.redo(SEQ, "dan")
    pins.redo(SEQ, "bob")
    pins.undo(SEQ, "ann")
    assert shown(pins) == [1, 1, 0, 0]
    pins.undo(SEQ, "dan")
    assert shown(pins) == [2, 2, 0, 0]


def test_the_stack_is_per_author_and_a_new_edit_ends_redo(pins: WorkspaceStore) -> None:
    paint(pins, [0], 1, "ann")
    paint(pins, [1], 1, "bob")
    paint(pins, [2], 1, "ann")
    pins.undo(SEQ, "ann")
    pins.undo(SEQ, "ann")
    with pytest.raises(ConflictError):
        pins.undo(SEQ, "ann")
    assert shown(pins) == [0, 1, 0, 0]
    pins.redo(SEQ, "ann")
    assert shown(pins) == [1, 1, 0, 0]
    paint(pins, [3], 2, "bob")
    pins.redo(SEQ, "ann")
    pins.undo(SEQ, "ann")
    paint(pins, [3], 3, "ann")
    with pytest.raises(ConflictError):
        pins.redo(SEQ, "ann")
    assert shown(pins) == [1, 1, 0, 3]


def test_a_stroke_that_changes_nothing_is_no_step_of_undo(pins: WorkspaceStore) -> None:
    paint(pins, [0, 1], 1, "ann")
    paint(pins, [0], 1, "ann")
    paint(pins, [], 1, "ann")
    pins.undo(SEQ, "ann")
    assert shown(pins) == [0, 0, 0, 0]
    pins.redo(SEQ, "ann")
    assert shown(pins) == [1, 1, 0, 0]


def test_painting_over_the_same_colour_of_somebody_else_holds_on_to_it(
    pins: WorkspaceStore,
) -> None:
    paint(pins, [0, 1], 1, "ann")
    assert paint(pins, [0], 1, "bob").changed == 0
    pins.undo(SEQ, "ann")
    assert shown(pins) == [1, 0, 0, 0]
    pins.undo(SEQ, "bob")
    assert shown(pins) == [0, 0, 0, 0]


def test_undoing_a_label_that_others_use_keeps_it(pins: WorkspaceStore) -> None:
    label = pins.create_label(SEQ, "ann", name="ann's", color="#123456")
    paint(pins, [0], label.id, "bob")
    commit = pins.undo(SEQ, "ann")
    assert not commit.palette_changed
    assert label in pins.palette(SEQ)
    assert shown(pins) == [label.id, 0, 0, 0]
    with pytest.raises(ConflictError):
        pins.undo(SEQ, "ann")
    pins.redo(SEQ, "ann")
    assert label in pins.palette(SEQ)


def test_redo_brings_back_the_label_of_its_points(pins: WorkspaceStore) -> None:
    label = pins.create_label(SEQ, "ann", name="ann's", color="#123456")
    paint(pins, [0], label.id, "bob")
    pins.undo(SEQ, "bob")
    pins.undo(SEQ, "ann")
    assert label not in pins.palette(SEQ)
    commit = pins.redo(SEQ, "bob")
    assert commit.palette_changed
    assert label in pins.palette(SEQ)
    assert shown(pins) == [label.id, 0, 0, 0]
    assert pins.counts(SEQ) == {(0, label.id): (1, 1)}
    pins.redo(SEQ, "ann")
    pins.undo(SEQ, "ann")
    assert shown(pins) == [label.id, 0, 0, 0]
    assert pins.check(SEQ) == []


def test_points_that_an_undo_uncovers_have_their_label(pins: WorkspaceStore) -> None:
    label = pins.create_label(SEQ, "ann", name="ann's")
    paint(pins, [0], label.id, "bob")
    paint(pins, [0], 1, "cat")
    pins.undo(SEQ, "ann")
    pins.undo(SEQ, "cat")
    assert label in pins.palette(SEQ)
    assert shown(pins) == [label.id, 0, 0, 0]


def test_redo_leaves_a_label_deleted_that_somebody_deleted(pins: WorkspaceStore) -> None:
    paint(pins, [0], 1, "bob")
    pins.undo(SEQ, "bob")
    pins.delete_label(SEQ, "cat", 1)
    pins.redo(SEQ, "bob")
    assert shown(pins) == [0, 0, 0, 0]
    pins.undo(SEQ, "cat")
    assert shown(pins) == [1, 0, 0, 0]


def test_undoing_an_unused_label_removes_it(pins: WorkspaceStore) -> None:
    label = pins.create_label(SEQ, "ann", name="ann's")
    assert pins.undo(SEQ, "ann").palette_changed
    assert label not in pins.palette(SEQ)
    pins.redo(SEQ, "ann")
    assert label in pins.palette(SEQ)


def test_a_deleted_label_comes_back_with_its_points_also_covered_ones(pins: WorkspaceStore) -> None:
    paint(pins, [0, 1, 2], 1, "ann")
    paint(pins, [1], 2, "bob")
    commit = pins.delete_label(SEQ, "cat", 1)
    assert (commit.changed, shown(pins)) == (2, [0, 2, 0, 0])
    pins.undo(SEQ, "bob")
    assert shown(pins) == [0, 0, 0, 0]
    commit = pins.undo(SEQ, "cat")
    assert shown(pins) == [1, 1, 1, 0]
    assert commit.changed == 3
    assert pins.counts(SEQ) == {(0, 1): (3, 3)}


def test_a_new_label_with_a_deleted_ones_id_starts_empty(pins: WorkspaceStore) -> None:
    paint(pins, [0, 1], 1, "ann")
    paint(pins, [1], 2, "bob")
    pins.delete_label(SEQ, "cat", 1)
    pins.undo(SEQ, "bob")
    label = pins.create_label(SEQ, "dan", name="again", id=1)
    assert label.id == 1
    assert pins.edits(SEQ, limit=1)[0].points == 0
    assert shown(pins) == [0, 0, 0, 0]
    assert pins.check(SEQ) == []


def test_two_peoples_changes_of_a_label_are_undone_apart(pins: WorkspaceStore) -> None:
    pins.update_label(SEQ, "ann", 1, name="ball", color="#ff0000")
    pins.update_label(SEQ, "bob", 1, color="#00FF00")
    pins.undo(SEQ, "ann")
    label = pins.palette(SEQ)[0]
    assert (label.name, label.color) == ("one", "#00ff00")
    pins.redo(SEQ, "ann")
    pins.undo(SEQ, "bob")
    label = pins.palette(SEQ)[0]
    assert (label.name, label.color) == ("ball", "#ff0000")


def test_the_same_undo_twice_undoes_once(pins: WorkspaceStore) -> None:
    paint(pins, [0], 1, "ann")
    paint(pins, [1], 1, "ann")
    first = pins.undo(SEQ, "ann", "u")
    again = pins.undo(SEQ, "ann", "u")
    assert again.repeated
    assert again.revision == first.revision
    assert shown(pins) == [1, 0, 0, 0]


def test_a_change_that_is_sent_again_is_answered_though_its_label_has_gone(
    pins: WorkspaceStore,
) -> None:
    first = pins.update_label(SEQ, "ann", 1, name="ball", edit_id="e")
    pins.delete_label(SEQ, "bob", 1)
    revision = pins.revision(SEQ)
    assert pins.update_label(SEQ, "ann", 1, name="ball", edit_id="e") == first
    assert pins.revision(SEQ) == revision


def test_a_named_edit_is_undone_alone_and_redone_in_its_place(pins: WorkspaceStore) -> None:
    answer = paint(pins, [0, 1, 2], 1, "ann").edit
    paint(pins, [1], 2, "ann")
    paint(pins, [3], 3, "ann")
    assert pins.undo(SEQ, "ann", edit=answer).changed == 2
    assert shown(pins) == [0, 2, 0, 3]
    for author in ("ann", "bob"):  # undone before, and another person's
        with pytest.raises(ConflictError, match="expected an edit of yours"):
            pins.undo(SEQ, author, edit=answer)
    pins.redo(SEQ, "ann", edit=answer)
    assert shown(pins) == [1, 2, 1, 3]
    pins.undo(SEQ, "ann")
    assert shown(pins) == [1, 2, 1, 0]
