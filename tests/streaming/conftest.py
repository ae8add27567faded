from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.serving import Served, add_sequence, serving, settings_in

FRAMES, POINTS = 12, 30_000


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A server with one recording, ``wall``, and a label 1."""
    settings = settings_in(tmp_path_factory.mktemp("served"))
    add_sequence(settings, "wall", frames=FRAMES, points=POINTS)
    add_sequence(settings, "other", frames=1, points=500)
    with serving(settings) as running:
        for name in ("wall", "other"):
            running.workspace.labels.create_label(name, "somebody", name="pin")
        yield running
