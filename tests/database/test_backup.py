from __future__ import annotations

import threading
from pathlib import Path

import numpy as np
import pytest

from pointbrush.database.backup import back_up, restore
from pointbrush.errors import BadInputError, ConflictError, NotFoundError, UnavailableError
from pointbrush.labels import Write
from pointbrush.teamwork.store import WorkspaceStore
from tests.labels.random_edits import box_at, boxes_of

SEQ = "juggling"


def paint(store: WorkspaceStore, number: int) -> None:
    write = Write(np.arange(number, number + 100), label=1, provenance=1)
    store.apply(
        SEQ, edit_id=f"e{number}", author="ann", kind="paint", writes={0: write}, summary=""
    )


def test_a_copy_of_a_store_in_use_is_whole(store: WorkspaceStore, tmp_path: Path) -> None:
    store.create_label(SEQ, "ann", name="pin")
    store.tokens.add("viewer", "Ada")
    stop = threading.Event()

    def work() -> None:
        number = 0
        while not stop.is_set():
            paint(store, number)
            number += 1

    worker = threading.Thread(target=work)
    worker.start()
    copies = []
    for number in range(3):
        copies.append(tmp_path / f"copy{number}.sqlite")
        back_up(store.database, copies[-1])
    stop.set()
    worker.join()
    assert not list(tmp_path.glob(".*"))
    for path in copies:
        copy = WorkspaceStore(f"sqlite:///{path}")
        revision = copy.revision(SEQ)
        assert copy.check(SEQ) == []
        assert int(copy.values(SEQ, 0).label.sum()) == (revision + 98 if revision > 1 else 0)
        copy.close()
    assert copies[0].exists()
    with pytest.raises(ConflictError):
        back_up(store.database, copies[0])
    with pytest.raises(UnavailableError):
        back_up(store.database, tmp_path / "nowhere" / "copy.sqlite")


def test_a_backup_comes_back_anywhere(
    store: WorkspaceStore, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    store.create_label(SEQ, "ann", name="pin")
    for number in range(0, 300, 50):
        paint(store, number)
    store.undo(SEQ, "ann")
    store.boxes.add(SEQ, "bob", box_at(1, 0, 2.0))
    secret = store.tokens.add("viewer", "Ada")
    saved = tmp_path / "backup.sqlite"
    back_up(store.database, saved)
    targets = [f"sqlite:///{tmp_path / 'new.sqlite'}"]
    if not store.database.sqlite:
        targets.append(request.getfixturevalue("postgres_server").new_database())
    for url in targets:
        restore(saved, url)
        again = WorkspaceStore(url)
        assert (again.values(SEQ, 0).label == store.values(SEQ, 0).label).all()
        assert again.edits(SEQ) == store.edits(SEQ)
        assert boxes_of(again, SEQ) == {1: (1, {0: 2.0})}
        assert again.check(SEQ) == []
        assert again.tokens.check(secret) is not None
        again.redo(SEQ, "ann")
        again.recordings.register("another", [5])
        again.close()
        with pytest.raises(ConflictError):
            restore(saved, url)
    with pytest.raises(BadInputError):
        restore(tmp_path / "missing", targets[0])
    (tmp_path / "other").write_text("something else")
    with pytest.raises(BadInputError):
        restore(tmp_path / "other", targets[0])
    with pytest.raises(NotFoundError):
        store.revision("another")
