"""Closed projects: ids used again, and members of two who call each other's."""

from __future__ import annotations

import io
import itertools
import threading
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import numpy as np

from pointbrush.teamwork.store import WorkspaceStore
from tests.faults.clients import SEQUENCE, RefusedError, SocketTalk
from tests.faults.server import ServerProcess, running
from tests.serving import add_sequence, settings_in
from tests.torture.authors import NAMES, Authors, quiet
from tests.torture.framework import Arena, Tally, scenario
from tests.torture.operations import waited
from tests.torture.strangers import (
    CALLS,
    STROKE,
    Secrets,
    Stranger,
    call,
    looking,
    require_unseen,
)

SHELF = "shelf"
"""Id that recordings have one after the other."""
HOMES = ("red", "blue", "default")
PLACES = {"red": 1234.5, "blue": 4321.5, "default": 0.5}
"""Coordinate x of all points, by project."""
CLASS = {"category": "stone"}
"""Of labels; all people of a workspace see its classes, which labels without one become."""
CALLS_OF_A_ROUND = 100
PAUSE = 0.05
"""Seconds between two edits of the second recording."""
FRAMES = 2


def _tokens(workspace: Path, roles: dict[str, str]) -> dict[str, str]:
    store = WorkspaceStore(f"sqlite:///{workspace / 'labels.sqlite'}")
    try:
        return {name: store.tokens.add(role, name, None) for name, role in roles.items()}
    finally:
        store.close()


def _close(api: httpx.Client, project: str, secrets: Secrets, **fields: object) -> None:
    """Make a project whose members alone see it."""
    name = f"secret-{project}"
    api.post("/projects", json={"name": name, "id": project, **fields}).raise_for_status()
    secrets.add(project, name)


# ── ids used again ───────────────────────────────────────────────────────────────────────────


@scenario("recordings of closed projects are deleted, their id is used again, three people look", 1)
def reused_ids(arena: Arena) -> None:
    """Nobody is told a name, edit, job, snapshot or point of what is not theirs, at any time."""
    settings, secrets = settings_in(arena.folder), Secrets()
    server = arena.stack.enter_context(running(settings.workspace))
    roles = {"ann": "annotator", "bob": "reviewer", "eve": "reviewer"}
    tokens = _tokens(settings.workspace, roles)
    people = {
        "red": Stranger("ann", tokens["ann"], ("blue",)),
        "blue": Stranger("bob", tokens["bob"], ("red",)),
        "default": Stranger("eve", tokens["eve"], ("red", "blue")),
    }
    with server.api() as api:
        for home in HOMES[:2]:
            member = people[home].name
            _close(api, home, secrets, roles={member: roles[member]})
            secrets.add(home, np.float32(PLACES[home]).tobytes(), str(PLACES[home]))
        for number in arena.rounds():
            seen = looking(
                server, people.values(), secrets, arena.tally, arena.seed + number,
                seq=[SHELF], p=list(HOMES),
            )  # fmt: skip
            with seen:
                for home in arena.rng.sample(HOMES, 2):
                    _lives(api, server, home, number, people[home], secrets, arena)
    quiet(server, arena.tally)


def _lives(
    api: httpx.Client, server: ServerProcess, home: str, number: int, member: Stranger,
    secrets: Secrets, arena: Arena,
) -> None:  # fmt: skip
    """Import the recording of a project, label it, show it to its member, and delete it."""
    root, name = f"/sequences/{SHELF}", f"secret-{home} {number}"
    ids = [str(uuid.uuid4()) for _ in range(3)]
    if home != "default":
        secrets.add(home, *ids)
    secrets.jobs += ids[:2]
    cloud = io.BytesIO()
    xyz = np.random.default_rng(number).normal(size=(60, 3))
    xyz[:, 0] = PLACES[home]
    np.savez(cloud, xyz=xyz.astype(np.float32))
    files = [("files", (f"{i}.npz", cloud.getvalue())) for i in range(FRAMES)]
    data = {"name": SHELF, "id": ids[0], "project": home}
    imported = waited(api, api.post("/sequences", files=files, data=data))
    assert imported["sequence"] == SHELF, imported
    api.patch(root, json={"name": name}).raise_for_status()
    label = api.post(f"{root}/labels", json={"name": name, **CLASS}).raise_for_status().json()["id"]
    for frame in range(FRAMES):
        stroke = {**STROKE, "label": label, "id": ids[2] if frame else str(uuid.uuid4())}
        stroke["samples"] = [{"origin": [PLACES[home], 0.0, 0.0]}]
        api.post(f"{root}/frames/{frame}/strokes", json=stroke).raise_for_status()
    run = {"id": ids[1], "labels": [label], "start": 0, "stop": 1, "method": "icp"}
    waited(api, api.post(f"{root}/tracking", json=run))
    made = api.post(f"/projects/{home}/snapshots", json={"name": name}).raise_for_status()
    secrets.snapshots.append(made.json()["id"])
    with server.api(member.token) as own:
        for path in ("/sequences", root, f"{root}/labels", f"/projects/{home}/snapshots"):
            answer = own.get(path)
            if name not in answer.text:
                arena.tally.count("lost", f"{member.name} does not see {name}: {answer.text}")
        arena.tally.answered += 1
    api.delete(root).raise_for_status()


# ── two projects ─────────────────────────────────────────────────────────────────────────────


@scenario("members of two closed projects call each other's routes while both are edited", 1)
def two_projects(arena: Arena) -> None:
    """No call of a stranger is a success, and all edits are of members."""
    workspace, secrets = arena.folder / "workspace", Secrets()
    authors = Authors(workspace, arena.seed)
    add_sequence(settings_in(arena.folder), "cube", frames=FRAMES, points=300)
    blue = {"bea": "reviewer", "ned": "annotator", "vic": "viewer"}
    red = {"rex": "reviewer", **dict.fromkeys(NAMES, "annotator")}
    tokens = _tokens(workspace, {"rex": "reviewer", **blue})
    tokens |= {one.name: one.token for one in authors.people}
    server = arena.stack.enter_context(running(workspace))
    strangers = {
        "red": [Stranger(name, tokens[name], ("red",)) for name in blue],
        "blue": [Stranger(name, tokens[name], ("blue",)) for name in ("rex", *NAMES[:2])],
    }
    targets = {"red": {"seq": SEQUENCE, "p": "red"}, "blue": {"seq": "cube", "p": "blue"}}
    apis = {name: arena.stack.enter_context(server.api(tokens[name])) for name in tokens}
    with server.api() as api:
        _close(api, "red", secrets, roles=red, recordings=[SEQUENCE])
        _close(api, "blue", secrets, roles=blue, recordings=["cube"])
        for project, names in targets.items():
            body = {"name": f"secret-{project}"}
            api.patch(f"/sequences/{names['seq']}", json=body).raise_for_status()
            made = api.post(f"/projects/{project}/snapshots", json=body).raise_for_status()
            secrets.snapshots.append(made.json()["id"])
            api.post(f"/projects/{project}/tasks", json={}).raise_for_status()
        answered: list[str] = []
        for _ in arena.rounds():
            with (
                authors.editing(lambda: [server.url]),
                _painting(apis["ned"], answered, arena.tally),
            ):
                for _ in range(CALLS_OF_A_ROUND):
                    project = arena.rng.choice(HOMES[:2])
                    stranger = arena.rng.choice(strangers[project])
                    _try(apis[stranger.name], stranger, targets[project], secrets, arena)
                for stranger in strangers["red"]:
                    _try_socket(server, stranger, arena.tally)
            authors.settle(server, arena.tally)
            _compare_edits(api, answered, arena.tally)
    quiet(server, arena.tally)


def _try(
    api: httpx.Client, one: Stranger, target: dict[str, str], secrets: Secrets, arena: Arena
) -> None:
    method, template = chosen = arena.rng.choice(CALLS)
    answer = call(api, chosen, secrets, arena.rng, **target)
    what = f"{method} {answer.url}"
    done = arena.tally.status(answer.status_code, f"{what} {answer.text[:300]}")
    if done and ("{seq}" in template or "{p}" in template):
        arena.tally.count("differs", f"{one.name}: {what} was done: {answer.text[:300]}")
    require_unseen(one, what, answer.content, secrets, arena.tally)


def _try_socket(server: ServerProcess, one: Stranger, tally: Tally) -> None:
    try:
        with SocketTalk(server.url, one.token):
            tally.count("differs", f"{one.name} has opened a recording of others")
    except RefusedError:
        tally.answered += 1


@contextmanager
def _painting(api: httpx.Client, answered: list[str], tally: Tally) -> Iterator[None]:
    """Have a member label the second recording; ``answered`` gets the ids of the edits."""
    stop = threading.Event()

    def paint() -> None:
        for number in itertools.count():
            if stop.wait(PAUSE):
                return
            edit = str(uuid.uuid4())
            path, body = "/sequences/cube/labels", {"name": f"secret-blue {edit}", **CLASS}
            if number % 2:
                path, body = "/sequences/cube/frames/0/strokes", {**STROKE, "id": edit}
            answer = api.post(path, json=body, params={} if number % 2 else {"edit": edit})
            if tally.status(answer.status_code, answer.text):
                answered.append(edit)

    thread = threading.Thread(target=paint)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


def _compare_edits(api: httpx.Client, answered: list[str], tally: Tally) -> None:
    """Compare the newest edits of the second recording with the answers."""
    newest = api.get("/sequences/cube/edits?limit=1000").raise_for_status().json()
    found = {row["id"]: row["author"] for row in newest}
    for edit in answered[-len(found) :]:
        if edit not in found:
            tally.count("lost", f"edit {edit} of the second recording")
    if others := {author for author in found.values() if author != "ned"}:
        tally.count("differs", f"edits of the second recording by {others}")
