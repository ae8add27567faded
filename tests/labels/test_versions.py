"""Versions give back what was there, to the point, whatever was done since."""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import pytest

from pointbrush.errors import ConflictError, NotFoundError, PointbrushError
from pointbrush.teamwork.store import WorkspaceStore
from tests.labels.random_edits import AUTHORS, POINTS, apply_to_store, boxes_of, random_edit

SEQUENCE = "journal"
PROJECT = "default"


def seen(labels: Any, sequence: str) -> Any:
    """All that is to be known of the labels of a recording."""
    frames = []
    for frame in range(len(POINTS)):
        runs = list(labels.runs(sequence, frame, 65_000))
        frames.append(
            {
                layer: np.concatenate([getattr(run, layer) for run in runs]).tobytes()
                for layer in ("label", "provenance", "deleted", "confidence")
            }
        )
    return frames, labels.palette(sequence), labels.tracks(sequence), boxes_of(labels, sequence)


@pytest.mark.parametrize("seed", range(3))
def test_a_version_is_what_was_there_after_all_that_follows(
    store: WorkspaceStore, seed: int
) -> None:
    rng = random.Random(seed)
    store.recordings.register(SEQUENCE, POINTS)
    for number in range(1, 5):
        store.create_label(SEQUENCE, "ann", name=f"name {number}")
    kept = {}
    for number in range(60):
        try:
            edit = random_edit(rng)
            apply_to_store(store, SEQUENCE, rng.choice(AUTHORS), f"e{number}", edit)
        except PointbrushError:
            continue  # nothing to undo, or a label that is gone
        if number % 6 == 0:
            version = store.versions.create(PROJECT, f"v{number}", "then", "ann").id
            kept[version] = seen(store, SEQUENCE)
    assert len(kept) > 3
    for version, wanted in kept.items():
        past = store.at(store.versions.moment(version, SEQUENCE))
        assert seen(past, SEQUENCE) == wanted, version


def test_a_version_is_its_projects_and_goes_with_the_recording(store: WorkspaceStore) -> None:
    versions = store.versions
    made = versions.create(PROJECT, "one", "One", "ann")
    assert made.recordings == {"juggling": 0}
    with pytest.raises(ConflictError):
        versions.create(PROJECT, "one", "Another", "ann")
    with pytest.raises(NotFoundError):
        versions.get("other", "one")
    store.recordings.forget("juggling")
    assert versions.get(PROJECT, "one").recordings == {}
    with pytest.raises(NotFoundError):
        versions.moment("one", "juggling")
    versions.remove(PROJECT, "one")
    assert versions.all(PROJECT) == []
