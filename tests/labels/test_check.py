"""Every way in which a database can disagree with its journal is found."""

from __future__ import annotations

import numpy as np
import pytest
from sqlalchemy import text

from pointbrush.labels.packing import encode_states
from pointbrush.teamwork.store import WorkspaceStore

SEQ = "juggling"


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
def test_damage_is_found(url: str, filled: WorkspaceStore, damage: str, finding: str) -> None:
    values = {
        "other": encode_states(np.ones(65_536, np.uint64)),
        "junk": b"junk",
    }
    used = {name: value for name, value in values.items() if f":{name}" in damage}
    with filled.database.write() as connection:
        connection.execute(text(damage), used)
    fresh = WorkspaceStore(url)
    assert any(finding in problem for problem in fresh.check(SEQ)), fresh.check(SEQ)
    fresh.close()
