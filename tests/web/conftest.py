from __future__ import annotations

from collections.abc import Iterator

import httpx
import pytest

from tests.serving import Served, add_sequence, serving, settings_in


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A server with one recording, ``wall``: 4 frames of 3,000 points and a few more each."""
    folder = tmp_path_factory.mktemp("served")
    settings = settings_in(folder, import_roots=str(folder / "inbox"), max_body=200_000)
    (folder / "inbox").mkdir()
    add_sequence(settings, "wall", frames=4, points=3_000)
    with serving(settings) as running:
        yield running


@pytest.fixture
def anyone(served: Served) -> Iterator[httpx.Client]:
    """A client without a token."""
    with httpx.Client(base_url=served.url) as client:
        yield client
