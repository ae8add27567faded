"""Review states that four people give to the same frames at once."""

from __future__ import annotations

import random
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import repeat
from typing import Any

import httpx

from pointbrush.teamwork.store import WorkspaceStore
from tests.faults.clients import FRAMES, SEQUENCE
from tests.faults.server import ServerProcess
from tests.faults.torture import make_workspace
from tests.torture.authors import quiet
from tests.torture.framework import Arena, Tally, scenario
from tests.torture.operations import ROOT

PEOPLE = {"ann": "annotator", "rob": "reviewer", "ria": "reviewer", "max": "manager"}
STATES = {"annotator": ("open", "review"), "": ("open", "review", "accepted", "rejected")}
SECONDS = 1.5
MOST = 1000
"""Decisions that the history gives."""


@dataclass
class Judge:
    """A person, and the notes of the decisions that were answered."""

    name: str
    role: str
    rng: random.Random
    api: httpx.Client
    answered: list[str] = field(default_factory=list)
    sent: int = 0

    def judge(self, tally: Tally, end: float) -> None:
        """Decide until ``end``; each decision has a note of its own."""
        while time.monotonic() < end:
            self.sent += 1
            first, last = sorted(self.rng.choices(range(FRAMES), k=2))
            note = f"{self.name} {self.sent}"
            state = self.rng.choice(STATES.get(self.role, STATES[""]))
            body: dict[str, Any] = {"first": first, "last": last, "state": state, "note": note}
            if self.role == "manager" and self.rng.random() < 0.3:
                body["assignee"] = self.rng.choice(list(PEOPLE))
            answer = self.api.put(f"{ROOT}/review", json=body)
            if tally.status(answer.status_code, answer.text):
                self.answered.append(note)


def _judged(arena: Arena, url: str, servers: int) -> None:
    workspace = arena.folder / "workspace"
    make_workspace(workspace)
    served = arena.serve(workspace, url, servers)
    store = WorkspaceStore(url or f"sqlite:///{workspace / 'labels.sqlite'}")
    judges = [
        Judge(
            name,
            role,
            random.Random(arena.seed + number),
            arena.stack.enter_context(
                served[number % servers].api(store.tokens.add(role, name, None))
            ),
        )
        for number, (name, role) in enumerate(PEOPLE.items())
    ]
    store.close()
    pool = arena.stack.enter_context(ThreadPoolExecutor(len(judges)))
    for _ in arena.rounds():
        end = time.monotonic() + SECONDS
        list(pool.map(Judge.judge, judges, repeat(arena.tally), repeat(end)))
        for server in served:
            _compare(server, judges, arena.tally)
    for server in served:
        quiet(server, arena.tally)


def _compare(server: ServerProcess, judges: list[Judge], tally: Tally) -> None:
    """Compare the history with what was answered, and how the frames stand with the history."""
    with server.api() as api:
        history = api.get(f"{ROOT}/review/history?limit={MOST}").raise_for_status().json()
        overview = api.get(f"{ROOT}/review").raise_for_status().json()
    noted = [entry["note"] for entry in history]
    for judge in judges:
        # The oldest may be beyond what the history gives.
        newest = judge.answered[-MOST // (2 * len(judges)) :]
        for note in newest:
            if noted.count(note) != 1:
                tally.count("lost", f"{note} is {noted.count(note)} times in the history")
    frames: list[dict[str, Any]] = [{} for _ in range(FRAMES)]
    for entry in reversed(history):
        there = frames[entry["first"] : entry["last"] + 1]
        taken = [each for each in there if each.get("state") == "accepted"]
        if PEOPLE[entry["by"]] == "annotator" and taken:
            tally.count("differs", f"{entry['note']} took back what {taken[0]['by']} accepted")
        for each in there:
            each.update({k: entry[k] for k in ("state", "note", "by")})
            if entry["assignee"] is not None:
                each["assignee"] = entry["assignee"]
    for run in overview["frames"]:
        for wanted in frames[run["first"] : run["last"] + 1]:
            if any(run[name] != wanted[name] for name in wanted):
                tally.count("differs", f"{SEQUENCE}: expected {wanted}, got {run}")


@scenario("four people set review states of the same frames at once, one SQLite server", 1)
def reviews(arena: Arena) -> None:
    """Each decision is in the history once, and an annotator takes back no acceptance."""
    _judged(arena, "", 1)


@scenario("the same with two servers on PostgreSQL", 1)
def reviews_two_servers(arena: Arena) -> None:
    """Two people at each server."""
    _judged(arena, arena.postgres().new_labels(), 2)
