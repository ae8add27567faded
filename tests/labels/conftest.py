"""Every test of the store runs on SQLite and on PostgreSQL."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from postgres import postgres_server, postgres_url  # noqa: F401  # fixtures

from pointbrush.labels import LabelStore

POINTS = [150_000, 70_000, 10, 0]
SEQUENCE = "juggling"


@pytest.fixture(params=["sqlite", "postgresql"])
def url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """The URL of an empty database."""
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'labels.sqlite'}"
    return str(request.getfixturevalue("postgres_url"))


@pytest.fixture
def store(url: str) -> Iterator[LabelStore]:
    """A store with one sequence of POINTS."""
    opened = LabelStore(url)
    opened.register(SEQUENCE, POINTS)
    yield opened
    opened.close()
