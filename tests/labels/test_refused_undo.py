"""An undo that could not be committed has never been."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pointbrush.errors import UnavailableError
from pointbrush.labels import Write
from pointbrush.labels.writer import Writer
from pointbrush.teamwork.store import WorkspaceStore


def test_a_refused_undo_leaves_the_edit_in_force(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = WorkspaceStore(f"sqlite:///{tmp_path / 'labels.sqlite'}")
    store.recordings.register("s", [100])
    for name in ("one", "two"):
        store.create_label("s", "ann", name=name)

    def paint(label: int) -> None:
        writes = {0: Write(np.arange(100), label=label, provenance=1)}
        store.apply("s", edit_id=None, author="ann", kind="paint", writes=writes, summary="")

    def full(*_: Any, **__: Any) -> None:
        raise UnavailableError("the disk is full")

    paint(1)
    with monkeypatch.context() as patch:
        patch.setattr(Writer, "_append", full)
        with pytest.raises(UnavailableError):
            store.undo("s", "ann")
    paint(2)
    store.undo("s", "ann")
    assert set(store.values("s", 0).label.tolist()) == {1}
    assert store.check("s") == []
    store.close()
