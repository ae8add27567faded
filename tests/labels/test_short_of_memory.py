"""Memory that runs out after a commit: the edit is answered as made, and what is known is right."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pointbrush.labels import Write
from pointbrush.labels.state import SequenceState
from pointbrush.teamwork.store import WorkspaceStore

SEQ = "juggling"


@pytest.mark.parametrize("part", ["adopt", "set_palette"])
def test_an_edit_that_was_made_is_answered(
    store: WorkspaceStore, monkeypatch: pytest.MonkeyPatch, part: str
) -> None:
    store.create_label(SEQ, "ann", name="pin")
    real, times = getattr(SequenceState, part), iter([MemoryError()])

    def short_once(*given: Any) -> None:
        for error in times:
            raise error
        real(*given)

    monkeypatch.setattr(SequenceState, part, short_once)
    if part == "adopt":
        write = Write(np.arange(9), label=1, provenance=1)
        made = store.apply(
            SEQ, edit_id=None, author="ann", kind="paint", writes={0: write}, summary=""
        )
        assert made.changed == 9
    else:
        assert store.create_label(SEQ, "ann", name="ball").name == "ball"
    assert store.revision(SEQ) == 2
    assert store.counts(SEQ) == ({(0, 1): (9, 9)} if part == "adopt" else {})
    assert len(store.palette(SEQ)) == (1 if part == "adopt" else 2)
    assert store.check(SEQ) == []
