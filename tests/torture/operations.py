"""Operations that a server may be killed in, and what each must have left."""

from __future__ import annotations

import hashlib
import io
import threading
import time
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import httpx
import numpy as np

from tests.faults.clients import ENDED, FRAMES, SEQUENCE
from tests.faults.server import ServerProcess
from tests.faults.torture import make_workspace
from tests.torture.authors import at_rest
from tests.torture.framework import Arena
from tests.waiting import eventually

ROOT = f"/sequences/{SEQUENCE}"
FAR = 120.0
BUSY, PAUSE = 429, 0.1
"""Status of an export while the one before holds its place, and seconds until the next try."""
STROKES = ((1, (0.0, 0.0, 1.0)), (1, (0.4, 0.4, 1.3)), (2, (-0.4, -0.4, 1.3)))
"""Label and place of the strokes that each frame has: label 1 is in two pieces."""
PLACE = {"centre": [0.0, 0.0, 1.0], "quaternion": [0.0, 0.0, 0.6, 0.8]}
BOX = {"label": 1, "size": [0.3, 0.5, 3.0], "poses": {str(n): PLACE for n in range(FRAMES)}}
"""A box of some of label 1's points, and of others."""
TRACKED = 2
"""Provenance of what tracking found."""
CLASSES = ("stone", "brick", "clay")
State = dict[str, Any]


class Place:
    """A workspace with labels, and the server on it, which is killed and begins again."""

    def __init__(self, arena: Arena) -> None:
        self.arena, self.tally = arena, arena.tally
        self.workspace = arena.folder / "workspace"
        make_workspace(self.workspace)
        self.server = ServerProcess(self.workspace)
        self.seconds: dict[str, float] = {}
        with self.server.api() as api:
            for name in ("one", "two"):
                api.post(f"{ROOT}/labels", json={"name": name}).raise_for_status()
            for frame in range(FRAMES):
                for label, origin in STROKES:
                    stroke = {"label": label, "radius": 0.2, "samples": [{"origin": origin}]}
                    path = f"{ROOT}/frames/{frame}/strokes"
                    api.post(path, json=stroke).raise_for_status()
            api.post(f"{ROOT}/boxes", json=BOX).raise_for_status()

    def killed(self, act: Callable[[httpx.Client], object], after: float) -> bool:
        """Kill the server ``after`` seconds of ``act`` and restart it; whether it was answered."""
        answered: list[bool] = []

        def call() -> None:
            with self.server.api(timeout=FAR) as api:
                try:
                    act(api)
                    answered.append(True)
                except httpx.TransportError:
                    return
                except httpx.HTTPStatusError as error:
                    self.tally.status(error.response.status_code, error.response.text)

        thread = threading.Thread(target=call)
        thread.start()
        time.sleep(after)
        self.server.kill()
        thread.join(FAR)
        self.server = ServerProcess(self.workspace)
        with self.server.api() as api:
            eventually(lambda: at_rest(api), FAR)
        self.tally.answered += bool(answered)
        return bool(answered)


def waited(api: httpx.Client, job: httpx.Response) -> dict[str, Any]:
    """Wait for the end of a job; returns it."""
    found: dict[str, Any] = job.raise_for_status().json()
    while found["state"] not in ENDED:
        time.sleep(0.01)
        found = api.get(f"/jobs/{found['id']}").raise_for_status().json()
    assert found["state"] == "done", found
    return found


def labels_of(api: httpx.Client) -> State:
    """Return the name of each point's label in each frame, and how it came."""
    palette = api.get(f"{ROOT}/labels").raise_for_status().json()
    names = {0: "", **{label["id"]: f"{label['name']} {label['category']}" for label in palette}}
    found: State = {"palette": sorted(names.values())}
    for frame in range(FRAMES):
        for layer in ("label", "provenance"):
            path = f"{ROOT}/frames/{frame}/annotation?layer={layer}"
            values = np.load(io.BytesIO(api.get(path).raise_for_status().content)).tolist()
            found[f"{layer} {frame}"] = [names[n] for n in values] if layer == "label" else values
    boxes = api.get(f"{ROOT}/boxes").raise_for_status().json()["boxes"]
    found["boxes"] = [(names[box["label"]], box["size"], box["poses"]) for box in boxes]
    return found


def classes_of(api: httpx.Client) -> State:
    """Return the classes of the workspace."""
    found: State = api.get("/taxonomy").raise_for_status().json()
    return found


def recordings_of(api: httpx.Client) -> State:
    """Return all recordings with their labels, and those deleted."""
    deleted = api.get("/sequences?deleted=true").raise_for_status().json()
    listed = api.get("/sequences").raise_for_status().json()
    return {
        "listed": [(each["name"], each["points"], each["damaged"]) for each in listed],
        "deleted": [each["name"] for each in deleted],
    }


def nothing(_: httpx.Client) -> None:
    """Leave everything as it is."""


@dataclass(frozen=True)
class Operation:
    """Something that is done by one call or one job.

    ``ready`` makes what it needs before; ``state`` is all that it changes; ``back`` takes it back.
    """

    name: str
    act: Callable[[httpx.Client], object]
    state: Callable[[httpx.Client], State] = labels_of
    back: Callable[[httpx.Client], object] = field(
        default=lambda api: api.post(f"{ROOT}/undo").raise_for_status()
    )
    ready: Callable[[httpx.Client], object] = nothing

    def round(self, place: Place) -> None:
        """Do it while the server is killed, then in peace, and compare."""
        with place.server.api() as api:
            self.ready(api)
            before = self.state(api)
            if self.name not in place.seconds:
                started = time.monotonic()
                self.act(api)
                place.seconds[self.name] = time.monotonic() - started
                self.back(api)
                self._same(place, "taken back", before, self.state(api))
        after = place.seconds[self.name] * place.arena.rng.uniform(0.0, 1.3)
        answered = place.killed(self.act, after)
        with place.server.api() as api:
            left = self.state(api)
            done = left != before
            if answered and not done:
                place.tally.count("lost", f"{self.name}: answered, and not there")
            if done:
                self.back(api)
                self._same(place, "taken back after a kill", before, self.state(api))
            self.act(api)
            whole = self.state(api)
            if done:
                self._same(place, "done in peace", whole, left)
            self.back(api)

    def _same(self, place: Place, when: str, wanted: State, found: State) -> None:
        for part in wanted.keys() | found.keys():
            if wanted.get(part) != found.get(part):
                told = f"expected {str(wanted.get(part))[:400]}, got {str(found.get(part))[:400]}"
                place.tally.count("differs", f"{self.name} {when}: {part}: {told}")


def _track(api: httpx.Client) -> None:
    run = {"start": 0, "stop": FRAMES - 1, "method": "icp", "labels": [1], "overwrite": "all"}
    waited(api, api.post(f"{ROOT}/tracking", json=run))


def _import_labels(api: httpx.Client) -> None:
    count = int(api.get(ROOT).json()["points"][0])
    files = [
        ("files", (f"{frame:06d}.label", np.full(count, 40 + frame, "<u4").tobytes()))
        for frame in range(FRAMES)
    ]
    waited(api, api.post(f"{ROOT}/annotations", files=files, data={"format": "semantickitti"}))


def _classes(names: tuple[str, ...]) -> Callable[[httpx.Client], object]:
    entries = [{"number": 900 + i, "name": name} for i, name in enumerate(names)]
    return lambda api: api.put("/taxonomy", json={"categories": entries}).raise_for_status()


def _post(path: str, body: dict[str, Any]) -> Callable[[httpx.Client], object]:
    return lambda api: api.post(f"{ROOT}{path}", json=body).raise_for_status()


def _is_tracked(api: httpx.Client) -> bool:
    """Return whether frame 1 has something that tracking found."""
    path = f"{ROOT}/frames/1/annotation?layer=provenance"
    return bool((np.load(io.BytesIO(api.get(path).raise_for_status().content)) == TRACKED).any())


def _tracked(api: httpx.Client) -> None:
    """Have something in frame 1 that tracking found."""
    if not _is_tracked(api):
        _track(api)


def _untracked(api: httpx.Client) -> None:
    """Have nothing that tracking found: the same again would change nothing."""
    while _is_tracked(api):
        api.post(f"{ROOT}/undo").raise_for_status()


def _of_box(method: str, path: str, body: dict[str, Any]) -> Callable[[httpx.Client], object]:
    """Make a call about the box that is there."""

    def call(api: httpx.Client) -> object:
        box = api.get(f"{ROOT}/boxes").raise_for_status().json()["boxes"][0]["id"]
        return api.request(method, f"{ROOT}/boxes/{box}{path}", json=body).raise_for_status()

    return call


EDITS = (
    Operation("track", _track, ready=_untracked),
    Operation("label import", _import_labels),
    Operation("merge", _post("/labels/1/merge", {"labels": [2]})),
    Operation("split", _post("/labels/1/split", {"frame": 0, "least": 1})),
    Operation("box", _post("/boxes", BOX)),
    Operation("box moved", _of_box("PATCH", "", {"poses": {"0": None}, "size": [1.0, 1.0, 1.0]})),
    Operation("points of a box", _of_box("POST", "/points", {})),
    Operation(
        "accept", _post("/accept", {"labels": [1], "start": 0, "stop": FRAMES - 1}), ready=_tracked
    ),
    Operation(
        "classes",
        _classes(CLASSES),
        classes_of,
        back=_classes(tuple(f"old {name}" for name in CLASSES)),
        ready=_classes(tuple(f"old {name}" for name in CLASSES)),
    ),
)


def _import(api: httpx.Client) -> None:
    content = io.BytesIO()
    np.savez(content, xyz=np.ones((5_000, 3), np.float32), label=np.arange(5_000) % 3)
    files = [("files", (f"{i}.npz", content.getvalue())) for i in range(3)]
    waited(api, api.post("/sequences", files=files, data={"name": "new"}))


def _drop(api: httpx.Client) -> None:
    for each in api.get("/sequences").raise_for_status().json():
        if each["name"] == "new":
            api.delete(f"/sequences/{each['id']}").raise_for_status()


def _imported(api: httpx.Client) -> State:
    """Return the recordings named new, with the labels that came in their files."""
    listed = api.get("/sequences").raise_for_status().json()
    found = [each for each in listed if each["name"] == "new"]
    labels = [api.get(f"/sequences/{each['id']}/labels").json() for each in found]
    parts = {"count": len(found), "names": [[entry["name"] for entry in each] for each in labels]}
    for each in found:
        path = f"/sequences/{each['id']}/frames/2/annotation"
        content = api.get(path).raise_for_status().content
        parts["labels"] = np.bincount(np.load(io.BytesIO(content))).tolist()
        parts["damaged"] = each["damaged"]
    return parts


def _export(api: httpx.Client) -> None:
    _exported(api)


def _exported(api: httpx.Client) -> State:
    while (answer := api.get(f"{ROOT}/export?format=npz")).status_code == BUSY:
        time.sleep(PAUSE)
    answer.raise_for_status()
    with zipfile.ZipFile(io.BytesIO(answer.content)) as archive:
        return {
            name: hashlib.sha256(archive.read(name)).hexdigest()
            for name in archive.namelist()
            if name.endswith(".npz")
        }


def _delete(api: httpx.Client) -> None:
    api.delete(ROOT).raise_for_status()


def _present(api: httpx.Client) -> None:
    if not api.get(ROOT).is_success:
        _restore(api)


def _absent(api: httpx.Client) -> None:
    if api.get(ROOT).is_success:
        _delete(api)


def _restore(api: httpx.Client) -> None:
    api.post(f"{ROOT}/restore").raise_for_status()


RECORDINGS = (
    Operation("import", _import, _imported, _drop),
    Operation("export", _export, _exported, nothing, ready=_present),
    Operation("delete", _delete, recordings_of, _restore, ready=_present),
    Operation("restore", _restore, recordings_of, _delete, ready=_absent),
)
