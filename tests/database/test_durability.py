"""Kill -9 at random moments, full disks, lost databases: what was answered stays.

POINTBRUSH_KILLS=200 pytest tests/database/test_durability.py   # the long version
"""

from __future__ import annotations

import json
import os
import random
import resource
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from postgres import PostgresServer
from sqlalchemy import event
from waiting import eventually

from pointbrush.errors import UnavailableError
from pointbrush.labels import Write
from pointbrush.teamwork.store import WorkspaceStore
from tests import forked
from tests.database.crash_child import edit_together
from tests.labels.label_model import Model
from tests.labels.random_edits import POINTS, apply_to_model, differences

KILLS = int(os.environ.get("POINTBRUSH_KILLS", "12"))
KILLS_PER_SEQUENCE = 4


def run_and_kill(
    url: str, sequence: str, seed: int, answers: int, seconds: float
) -> list[dict[str, Any]]:
    """What the child said before it was killed, some time after so many answers."""
    with forked.calling(edit_together, url, sequence, seed) as child:
        assert json.loads(child.stdout.readline())["ready"]
        lines: list[str] = []
        while sum("answered" in line for line in lines) < answers:
            lines.append(child.stdout.readline())
            assert lines[-1], "the child ended by itself"
        time.sleep(seconds)
        child.kill()
        # A last line may be cut short: then the answer did not get out.
        lines += [line for line in child.stdout if line.endswith("\n")]
    return [json.loads(line) for line in lines]


def verify(url: str, sequence: str, said: list[dict[str, Any]]) -> int:
    """Compare the database with a replay of what was asked; returns the number of edits."""
    asked = {line["asked"]: line for line in said if "asked" in line}
    answered = {line["answered"]: line for line in said if "answered" in line}
    refused = {line["refused"]: line["why"] for line in said if "refused" in line}
    store = WorkspaceStore(url)
    history = store.edits(sequence, limit=1000)
    while history and history[-1].revision > 1:
        history += store.edits(sequence, before=history[-1].revision, limit=1000)
    found = {edit.id: edit for edit in history}
    assert found.keys() <= asked.keys(), "an edit that nobody asked for"
    assert [refused[n] for n in found.keys() & refused.keys()] == [], "an edit that was refused"
    assert answered.keys() <= found.keys(), "an answered edit is missing"
    model = Model()
    for edit in reversed(history):
        if edit.id in answered:
            line = answered[edit.id]
            assert (line["revision"], line["changed"]) == (edit.revision, edit.points)
        apply_to_model(model, edit.author, edit.id, asked[edit.id]["edit"])
    assert differences(store, sequence, model) == []
    assert store.check(sequence) == []
    store.close()
    return len(history)


@pytest.mark.timeout(60 + KILLS * 10)
def test_killed_at_random_moments(url: str) -> None:
    rng = random.Random(7)
    said: list[dict[str, Any]] = []
    edits = 0
    for kill in range(KILLS):
        sequence = f"s{kill // KILLS_PER_SEQUENCE}"
        if kill % KILLS_PER_SEQUENCE == 0:
            said = []
            store = WorkspaceStore(url)
            store.recordings.register(sequence, POINTS)
            store.close()
        answers, seconds = rng.choice([0, 0, 5, 20, 50]), rng.uniform(0.0, 0.05)
        said += run_and_kill(url, sequence, kill, answers, seconds)
        edits = max(edits, verify(url, sequence, said))
    assert edits > 10


def test_a_full_disk_refuses_the_edit_and_keeps_the_rest(tmp_path: Path) -> None:
    store = WorkspaceStore(f"sqlite:///{tmp_path / 'labels.sqlite'}")
    store.recordings.register("s", [1_000_000])
    store.create_label("s", "ann", name="pin")
    limit = [0]

    @event.listens_for(store.database.engine, "begin")
    def fill(connection: Any) -> None:
        connection.exec_driver_sql(f"PRAGMA max_page_count={limit[0] or 2**30}")

    rng = np.random.default_rng(0)

    def stroke(name: str) -> None:
        points = np.flatnonzero(rng.random(1_000_000) < 0.1)
        write = Write(points, label=1, provenance=1)
        store.apply("s", edit_id=name, author="ann", kind="paint", writes={0: write}, summary="")

    stroke("before")
    before = store.values("s", 0)
    limit[0] = 1  # the file may not grow any more
    for attempt in range(3):
        with pytest.raises(UnavailableError, match="full"):
            stroke(f"refused {attempt}")
        with pytest.raises(UnavailableError):
            stroke("once more")
    after = store.values("s", 0)
    assert (before.label == after.label).all()
    assert before.revision == after.revision
    limit[0] = 0
    stroke("once more")
    assert store.values("s", 0).label.sum() > before.label.sum()
    assert store.find("s", "refused 0") is None
    assert store.check("s") == []
    store.undo("s", "ann")
    assert (store.values("s", 0).label == before.label).all()
    store.close()


def test_a_log_that_cannot_grow_refuses_the_edit(tmp_path: Path) -> None:
    path = tmp_path / "labels.sqlite"
    store = WorkspaceStore(f"sqlite:///{path}")
    store.recordings.register("s", [500_000])
    store.create_label("s", "ann", name="pin")
    rng = np.random.default_rng(0)

    def stroke(name: str) -> int:
        points = np.flatnonzero(rng.random(500_000) < 0.2)
        write = Write(points, label=1, provenance=1)
        commit = store.apply(
            "s", edit_id=name, author="ann", kind="paint", writes={0: write}, summary=""
        )
        return commit.revision

    stroke("before")
    before = store.values("s", 0)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    log = path.with_name("labels.sqlite-wal")
    resource.setrlimit(resource.RLIMIT_FSIZE, (log.stat().st_size + 20_000, hard))
    try:
        with pytest.raises(UnavailableError):
            stroke("after")
        assert (store.values("s", 0).label == before.label).all()
        assert store.find("s", "after") is None
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert stroke("after") == before.revision + 1
    again = WorkspaceStore(f"sqlite:///{path}")
    assert (again.values("s", 0).label == store.values("s", 0).label).all()
    assert again.check("s") == []
    again.close()
    store.close()


def test_a_database_that_goes_away_and_comes_back(postgres_server: PostgresServer) -> None:
    store = WorkspaceStore(postgres_server.new_labels())
    store.recordings.register("s", [100])
    store.create_label("s", "ann", name="pin")
    heard: list[int] = []
    store.subscribe(lambda commit: heard.append(commit.revision))

    def stroke(point: int) -> int:
        write = Write(np.array([point]), label=1)
        commit = store.apply(
            "s", edit_id=f"p{point}", author="ann", kind="paint", writes={0: write}, summary=""
        )
        return commit.revision

    assert stroke(1) == 2
    postgres_server.stop()
    try:
        with pytest.raises(UnavailableError):
            stroke(2)
        with pytest.raises(UnavailableError):
            store.values("s", 0)
        with pytest.raises(UnavailableError):
            WorkspaceStore(postgres_server.url("away"))
    finally:
        postgres_server.start()
    assert store.values("s", 0).label.sum() == 1
    assert stroke(2) == 3
    assert stroke(1) == 2
    eventually(lambda: heard == [2, 3])
    assert store.check("s") == []
    store.close()
