"""Every way in which a database can disagree with its journal is found."""

from __future__ import annotations

import numpy as np
import pytest
from sqlalchemy import text

from pointbrush.labels import LabelStore, Write, writer
from pointbrush.labels.packing import encode_states

SEQ = "juggling"


@pytest.fixture
def filled(store: LabelStore, monkeypatch: pytest.MonkeyPatch) -> LabelStore:
    monkeypatch.setattr(writer, "SNAPSHOT_EVERY", 2)
    for name in ("one", "two"):
        store.create_label(SEQ, "ann", name=name)
    for number in range(6):
        write = Write(np.arange(number, 70_000, 7), label=1 + number % 2, provenance=1)
        tracks = [{"frame": 0, "label": 1, "n": number}]
        store.apply(
            SEQ,
            edit_id=f"e{number}",
            author="ann",
            kind="paint",
            writes={0: write},
            summary="",
            tracks=tracks,
        )
    store.undo(SEQ, "ann")
    store._sessions.upkeep.close()  # its snapshots are written
    assert store.check(SEQ) == []
    return store


@pytest.mark.parametrize(
    ("damage", "finding"),
    [
        ("UPDATE counts SET points = points + 1 WHERE label = 2", "counts: frame 0, label 2"),
        ("DELETE FROM counts", "counts"),
        ("UPDATE snapshots SET data = :other", "its snapshot differs"),
        ("UPDATE snapshots SET data = :junk", "its snapshot cannot be read"),
        ("UPDATE edit_blocks SET data = :junk WHERE revision = 4", "edit 4 cannot be read"),
        ("DELETE FROM edit_blocks WHERE revision = 4", "snapshot differs"),
        ("DELETE FROM edit_blocks WHERE revision = 8", "edit 9 does not follow"),
        ("UPDATE edits SET state = 1 WHERE revision = 5", "not in force"),
        ("UPDATE labels SET name = 'x' WHERE id = 2", "palette: label 2"),
        ("DELETE FROM labels WHERE id = 1", "palette: label 1"),
        ("DELETE FROM tracks", "tracks: frame 0, label 1"),
        ("UPDATE edits SET revision = 99 WHERE revision = 3", "journal: expected revisions 1 to 9"),
    ],
)
def test_damage_is_found(url: str, filled: LabelStore, damage: str, finding: str) -> None:
    values = {
        "other": encode_states(np.ones(65_536, np.uint64)),
        "junk": b"junk",
    }
    used = {name: value for name, value in values.items() if f":{name}" in damage}
    with filled._database.write() as connection:
        connection.execute(text(damage), used)
    fresh = LabelStore(url)
    assert any(finding in problem for problem in fresh.check(SEQ)), fresh.check(SEQ)
    fresh.close()
