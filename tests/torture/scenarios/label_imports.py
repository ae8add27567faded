"""Imports of labels whose ids conflict, sent twice at once, undone and redone across each other."""

from __future__ import annotations

import io
import json
import random
import uuid
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any

import httpx
import numpy as np
from numpy.typing import NDArray

from pointbrush.teamwork.store import WorkspaceStore
from tests.faults.clients import FRAMES, SEQUENCE
from tests.faults.server import ServerProcess
from tests.faults.torture import make_workspace
from tests.torture.authors import quiet
from tests.torture.framework import Arena, Tally, scenario
from tests.torture.operations import ROOT, waited

PEOPLE = ("ann", "bob", "cat", "dan")
NAMES = ("stone", "brick", "clay", "wood")
"""Names of labels; each import gives them ids from 1 in an order of its own."""
POINTS = 400
TURNS = 4
"""Most undos and redos of each person in a round."""
Names = NDArray[np.str_]
"""Name of the label of each point of each frame, "" for none."""


@dataclass
class Import:
    """Labels brought in by one edit: the names that it gives, and whether it is in force."""

    author: str
    edit: str
    names: Names
    undone: bool = False
    revision: int = 0
    """Its place in the history, once that was looked at."""


@dataclass
class Importer:
    """A person who imports labels, and takes imports back."""

    name: str
    rng: random.Random
    apis: list[httpx.Client]
    """Of each server."""
    done: list[Import] = field(default_factory=list)
    """Imports in force and undone ones that can be redone, oldest first."""

    def bring_in(self, tally: Tally, both: ThreadPoolExecutor) -> None:
        """Import labels of some points, the same twice at once."""
        ids = self.rng.sample(range(1, len(NAMES) + 1), len(NAMES))
        numbers = np.zeros((FRAMES, POINTS), np.uint16)
        for frame in numbers:
            first = self.rng.randrange(POINTS // 2)
            count = self.rng.randint(POINTS // 4, POINTS // 2)
            frame[first : first + count] = self.rng.choices(ids, k=count)
        called = dict(zip(ids, NAMES, strict=True)) | {0: ""}
        files, data = _files(numbers, called), {"id": str(uuid.uuid4()), "format": "npy"}
        sent: list[Future[dict[str, Any]]] = [
            both.submit(_send, api, files, data, tally) for api in (self.apis[0], self.apis[-1])
        ]
        edits = {job["result"]["edit"] for job in (each.result() for each in sent) if job}
        if len(edits) != 1:
            tally.count("differs", f"one import that was sent twice became {edits}")
        names = np.vectorize(called.__getitem__, otypes=["<U8"])(numbers)
        self.done = [each for each in self.done if not each.undone]
        self.done.append(Import(self.name, edits.pop(), names))

    def turn(self, tally: Tally) -> None:
        """Take back some imports, and bring some back again."""
        for _ in range(self.rng.randint(1, TURNS)):
            undone = [each for each in self.done if each.undone]
            there = [each for each in self.done if not each.undone]
            back = bool(undone) and self.rng.random() < 0.5
            answer = self.rng.choice(self.apis).post(f"{ROOT}/{'redo' if back else 'undo'}")
            if not (undone if back else there):
                if answer.status_code != 409:
                    tally.count("differs", f"nothing to undo, and {answer.text}")
                continue
            if tally.status(answer.status_code, answer.text):
                (undone[0] if back else there[-1]).undone = not back


def _files(numbers: NDArray[np.uint16], called: dict[int, str]) -> list[Any]:
    labels = [
        {"id": number, "name": name, "category": name, "color": f"#0000{number:02x}"}
        for number, name in called.items()
        if number
    ]
    files = [("files", ("palette.json", json.dumps({"labels": labels}).encode()))]
    for i, frame in enumerate(numbers):
        content = io.BytesIO()
        np.save(content, frame)
        files.append(("files", (f"{i:06d}.npy", content.getvalue())))
    return files


def _send(
    api: httpx.Client, files: list[Any], data: dict[str, str], tally: Tally
) -> dict[str, Any] | None:
    answer = api.post(f"{ROOT}/annotations", files=files, data=data)
    if not tally.status(answer.status_code, answer.text):
        return None
    return waited(api, answer)


def _imported(arena: Arena, url: str, servers: int) -> None:
    workspace = arena.folder / "workspace"
    make_workspace(workspace)
    served = arena.serve(workspace, url, servers)
    importers = list(_people(arena, served, url or f"sqlite:///{workspace / 'labels.sqlite'}"))
    pool = arena.stack.enter_context(ThreadPoolExecutor(len(importers)))
    both = arena.stack.enter_context(ThreadPoolExecutor(2 * len(importers)))
    for _ in arena.rounds():
        list(pool.map(lambda one: one.bring_in(arena.tally, both), importers))
        list(pool.map(lambda one: one.turn(arena.tally), importers))
        for server in served:
            _compare(server, importers, arena.tally)
    for server in served:
        quiet(server, arena.tally)


def _people(arena: Arena, served: list[ServerProcess], url: str) -> Iterator[Importer]:
    store = WorkspaceStore(url)
    for number, name in enumerate(PEOPLE):
        token = store.tokens.add("annotator", name, None)
        apis = [arena.stack.enter_context(server.api(token)) for server in served]
        yield Importer(name, random.Random(arena.seed + number), apis)
    store.close()


def _compare(server: ServerProcess, importers: list[Importer], tally: Tally) -> None:
    """Compare the names of all points with those of the last import in force."""
    imports = [each for one in importers for each in one.done]
    known = {each.edit: each for each in imports if not each.revision}
    with server.api() as api:
        history = api.get(f"{ROOT}/edits?limit=1000").raise_for_status().json()
        for row in history:
            if row["id"] in known:
                known.pop(row["id"]).revision = row["revision"]
        for missing in known.values():
            tally.count("lost", f"{missing.author}'s import {missing.edit} is not in the history")
        wanted = np.full((FRAMES, POINTS), "", "<U8")
        for each in sorted(imports, key=lambda each: each.revision):
            if not each.undone:
                wanted = np.where(each.names == "", wanted, each.names)
        labels = api.get(f"{ROOT}/labels").raise_for_status().json()
        name_of = {label["id"]: label["name"] for label in labels}
        if len(set(name_of.values())) < len(name_of):
            tally.count("differs", f"several labels of one name: {name_of}")
        for frame in range(FRAMES):
            content = api.get(f"{ROOT}/frames/{frame}/annotation").raise_for_status().content
            found = [name_of.get(number, "") for number in np.load(io.BytesIO(content)).tolist()]
            wrong = np.flatnonzero(wanted[frame] != found)
            if len(wrong):
                at = int(wrong[0])
                tally.count(
                    "differs",
                    f"{SEQUENCE}, frame {frame}: {len(wrong)} points, such as {at}: expected "
                    f"{wanted[frame][at]!r}, got {found[at]!r}",
                )


@scenario("label imports with conflicting ids, each sent twice, undone in any order, SQLite", 1)
def label_imports(arena: Arena) -> None:
    """Each point has the name that the last import in force gives it, however it was sent."""
    _imported(arena, "", 1)


@scenario("the same with two servers on PostgreSQL, each import sent to both", 1)
def label_imports_two_servers(arena: Arena) -> None:
    """Undo and redo at either server."""
    _imported(arena, arena.postgres().new_database(), 2)
