"""Random edits as plain data, done to a store and to the model alike."""

from __future__ import annotations

import random
from typing import Any

import numpy as np

from pointbrush.geometry.oriented_box import BoxPose, OrientedBox
from pointbrush.labels import Commit, Write
from pointbrush.labels.versions import PastLabels
from pointbrush.teamwork.store import WorkspaceStore
from tests.labels.label_model import Model

PLACES = [0, 1, 2, 3, 4, 5, 65_534, 65_535, 65_536, 65_537]
POINTS = [65_540, 65_540, 20]
AUTHORS = ["ann", "bob", "cat"]
KINDS = ["paint"] * 8 + ["run"] * 2 + ["undo"] * 3 + ["redo"] * 2 + ["create", "rename", "delete"]
KINDS += ["box", "move", "move", "unbox"]


def random_edit(rng: random.Random) -> dict[str, Any]:
    """An edit as JSON."""
    edit: dict[str, Any] = {"kind": rng.choice(KINDS), "label": rng.randint(1, 4)}
    if edit["kind"] == "paint":
        edit["frame"] = rng.randrange(2)
        edit["points"] = sorted(rng.sample(PLACES, rng.randint(1, 8)))
        edit["paint"] = rng.choice([None, 0, 1, 2, 3])
        edit["deleted"] = rng.choice([None, None, True, False])
        edit["only"] = rng.choice(["any", "unlabeled"])
    elif edit["kind"] == "run":
        edit["points"] = sorted(rng.sample(range(20), 12))
    elif edit["kind"] in ("box", "move", "unbox"):
        edit |= {"box": rng.randint(1, 4), "frame": rng.randrange(3), "x": float(rng.randrange(4))}
    elif edit["kind"] == "rename":
        edit["name"] = f"name {rng.randrange(9)}"
    return edit


def _made(store: WorkspaceStore, sequence: str, edit_id: str) -> Commit:
    commit = store.find(sequence, edit_id)
    assert commit is not None
    return commit


def apply_to_store(
    store: WorkspaceStore, sequence: str, author: str, edit_id: str, edit: dict[str, Any]
) -> Commit:
    """Do the edit."""
    match edit["kind"]:
        case "undo":
            return store.undo(sequence, author, edit_id)
        case "redo":
            return store.redo(sequence, author, edit_id)
        case "create":
            store.create_label(sequence, author, name="new", edit_id=edit_id)
            return _made(store, sequence, edit_id)
        case "rename":
            store.update_label(sequence, author, edit["label"], name=edit["name"], edit_id=edit_id)
            return _made(store, sequence, edit_id)
        case "delete":
            return store.delete_label(sequence, author, edit["label"], edit_id=edit_id)
        case "box":
            box = box_at(edit["label"], edit["frame"], edit["x"])
            return store.boxes.add(sequence, author, box, edit_id=edit_id).commit
        case "move":
            change = {"poses": {str(edit["frame"]): place_at(edit["x"])}}
            return store.boxes.change(sequence, author, edit["box"], change, edit_id=edit_id).commit
        case "unbox":
            return store.boxes.remove(sequence, author, edit["box"], edit_id=edit_id)
    frames = range(3) if edit["kind"] == "run" else [edit["frame"]]
    number, provenance, deleted, only = _values(edit)
    write = Write(np.array(edit["points"]), number, provenance, deleted, only)  # type: ignore[arg-type]
    return store.apply(
        sequence,
        edit_id=edit_id,
        author=author,
        kind=edit["kind"],
        writes=[(frame, write) for frame in frames],
        summary="",
        tracks=[
            {"frame": frame, "label": edit["label"], "by": edit_id}
            for frame in frames
            if edit["kind"] == "run"
        ],
    )


def apply_to_model(model: Model, author: str, edit_id: str, edit: dict[str, Any]) -> None:
    """Do the same to the model."""
    match edit["kind"]:
        case "undo":
            model.undo(author)
        case "redo":
            model.redo(author)
        case "create":
            model.create(author, "new", None)
        case "rename":
            model.change(author, edit["label"], name=edit["name"])
        case "delete":
            model.delete(author, edit["label"])
        case "box":
            model.add_box(author, edit["label"], edit["frame"], edit["x"])
        case "move":
            model.move_box(author, edit["box"], edit["frame"], edit["x"])
        case "unbox":
            model.remove_box(author, edit["box"])
        case _:
            frames = range(3) if edit["kind"] == "run" else [edit["frame"]]
            where = [(frame, point) for frame in frames for point in edit["points"]]
            run = edit["kind"] == "run"
            tracks = dict.fromkeys(((f, edit["label"]) for f in frames), edit_id) if run else {}
            model.write(author, where, *_values(edit), tracks=tracks)


def differences(store: WorkspaceStore, sequence: str, model: Model) -> list[str]:
    """Where a store differs from the model."""
    found: dict[tuple[int, int], tuple[int, int, bool]] = {}
    for frame in range(len(POINTS)):
        values = store.values(sequence, frame)
        marked = np.flatnonzero(values.label | values.provenance | values.deleted)
        for point in marked.tolist():
            found[frame, point] = (
                int(values.label[point]),
                int(values.provenance[point]),
                bool(values.deleted[point]),
            )
    palette = {n: fields["name"] for n, fields in model.palette().items()}
    tracks = {(t["frame"], t["label"]): t["by"] for t in store.tracks(sequence)}
    pairs = {
        "points": (found, model.visible()),
        "counts": (store.counts(sequence), model.counts()),
        "palette": ({label.id: label.name for label in store.palette(sequence)}, palette),
        "tracks": (tracks, model.tracks()),
        "boxes": (boxes_of(store, sequence), model.boxes()),
    }
    return [f"{what}: {got} != {want}" for what, (got, want) in pairs.items() if got != want]


def box_at(label: int, frame: int, x: float) -> OrientedBox:
    """A box in one frame."""
    place = place_at(x)
    pose = BoxPose(np.array(place["centre"]), np.array(place["quaternion"]))
    return OrientedBox(0, label, np.ones(3), {frame: pose})


def place_at(x: float) -> dict[str, list[float]]:
    """Its place there."""
    return {"centre": [x, 0.0, 0.0], "quaternion": [0.0, 0.0, 0.0, 1.0]}


def boxes_of(
    store: WorkspaceStore | PastLabels, sequence: str
) -> dict[int, tuple[int, dict[int, float]]]:
    """The boxes of a store as the model has them."""
    return {
        box.id: (box.label, {frame: float(pose.centre[0]) for frame, pose in box.poses.items()})
        for box in store.boxes.listing(sequence).boxes
    }


def _values(edit: dict[str, Any]) -> tuple[int | None, int | None, bool | None, str]:
    if edit["kind"] == "run":
        return edit["label"], 2, None, "not_painted"
    provenance = None if edit["paint"] is None else int(edit["paint"] > 0)
    return edit["paint"], provenance, edit["deleted"], edit["only"]
