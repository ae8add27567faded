"""Palettes that are added to one recording at the same moment keep all their labels."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from pathlib import Path
from threading import Barrier

import pytest

from pointbrush.labels import LabelStore
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.values.labels import PaletteLabel
from pointbrush.work.palettes import add_labels

ROUNDS, LABELS = 8, 30


@pytest.mark.parametrize("servers", [1, 2])
def test_no_label_takes_the_place_of_another(tmp_path: Path, servers: int) -> None:
    url = f"sqlite:///{tmp_path / 'labels.sqlite'}"
    with ExitStack() as stack:
        stores = [stack.enter_context(closing(WorkspaceStore(url))) for _ in range(servers)]
        ready = Barrier(2)

        def add(store: LabelStore, sequence: str, person: str) -> list[str]:
            wanted = [PaletteLabel(f"{person} {k}", person) for k in range(LABELS)]
            store.revision(sequence)
            ready.wait()
            return add_labels(store, sequence, wanted, person)

        for turn in range(ROUNDS):
            sequence = f"recording-{turn}"
            stores[0].recordings.register(sequence, [10])
            with ThreadPoolExecutor(2) as pool:
                ann = pool.submit(add, stores[0], sequence, "ann")
                bob = pool.submit(add, stores[-1], sequence, "bob")
            names = [label.name for label in stores[0].palette(sequence)]
            assert sorted(names) == sorted(ann.result() + bob.result())
            assert len(names) == 2 * LABELS
