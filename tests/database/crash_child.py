"""The process that test_durability kills: people edit at once, every answer is printed."""

from __future__ import annotations

import json
import random
import threading
import uuid
from typing import Any

from pointbrush.errors import PointbrushError
from pointbrush.labels import writer
from pointbrush.teamwork.store import WorkspaceStore
from tests.labels.random_edits import AUTHORS, apply_to_store, random_edit

SPEAKING = threading.Lock()


def say(**fields: Any) -> None:
    with SPEAKING:
        print(json.dumps(fields), flush=True)


def work(store: WorkspaceStore, sequence: str, author: str, rng: random.Random) -> None:
    while True:
        edit, edit_id = random_edit(rng), str(uuid.UUID(int=rng.getrandbits(128)))
        say(asked=edit_id, author=author, edit=edit)
        try:
            commit = apply_to_store(store, sequence, author, edit_id, edit)
        except PointbrushError as error:
            say(refused=edit_id, why=str(error))
        else:
            say(answered=edit_id, revision=commit.revision, changed=commit.changed)


def edit_together(url: str, sequence: str, seed: int) -> None:
    writer.SNAPSHOT_EVERY = 4
    store = WorkspaceStore(url)
    say(ready=True)

    def begin(author: str) -> threading.Thread:
        rng = random.Random(f"{seed}{author}")
        return threading.Thread(target=work, args=(store, sequence, author, rng))

    threads = [begin(author) for author in AUTHORS]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
