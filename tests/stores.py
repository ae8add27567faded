"""Label databases for tests: on SQLite and on PostgreSQL."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from pointbrush.labels import Write, writer
from pointbrush.teamwork.store import WorkspaceStore
from tests.serving import new_labels

POINTS = [150_000, 70_000, 10, 0]
SEQUENCE = "juggling"


@pytest.fixture(params=["sqlite", "postgresql"])
def url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """The URL of a label database without recordings."""
    if request.param == "postgresql":
        return str(request.getfixturevalue("postgres_server").new_labels())
    path = tmp_path / "labels.sqlite"
    path.write_bytes(new_labels())
    return f"sqlite:///{path}"


@pytest.fixture(params=["sqlite", "postgresql"])
def empty_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """The URL of a database without tables."""
    if request.param == "postgresql":
        return str(request.getfixturevalue("postgres_url"))
    return f"sqlite:///{tmp_path / 'labels.sqlite'}"


@pytest.fixture
def store(url: str) -> Iterator[WorkspaceStore]:
    """A store with one sequence of POINTS."""
    opened = WorkspaceStore(url)
    opened.recordings.register(SEQUENCE, POINTS)
    yield opened
    opened.close()


@pytest.fixture
def filled(store: WorkspaceStore, monkeypatch: pytest.MonkeyPatch) -> WorkspaceStore:
    """Six edits with tracks, one undone, and snapshots of their blocks."""
    monkeypatch.setattr(writer, "SNAPSHOT_EVERY", 2)
    for name in ("one", "two"):
        store.create_label(SEQUENCE, "ann", name=name)
    for number in range(6):
        write = Write(np.arange(number, 70_000, 7), label=1 + number % 2, provenance=1)
        store.apply(
            SEQUENCE,
            edit_id=f"e{number}",
            author="ann",
            kind="paint",
            writes={0: write},
            summary="",
            tracks=[{"frame": 0, "label": 1, "n": number}],
        )
    store.undo(SEQUENCE, "ann")
    store._open_recordings.upkeep.close()  # its snapshots are written
    return store
