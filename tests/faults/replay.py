"""What the annotations must be: the journal's order, and what each author asked for.

Which points a stroke takes is found by brute force; what it does to them, undo and the palette by
the slow model of tests/labels.  Only a tracking run's findings are taken from its own record.
"""

from __future__ import annotations

import io
import itertools
import json
from contextlib import closing
from pathlib import Path
from typing import Any

import httpx
import numpy as np
from numpy.typing import NDArray
from sqlalchemy import select

from pointbrush.database.database import Database
from pointbrush.database.schema import edit_blocks, edit_tracks
from pointbrush.labels.packing import LABELS, decode_change, label_of, provenance_of
from pointbrush.sequences import open_sequence
from tests.faults.clients import SEQUENCE, Asked, Edit, Person
from tests.labels.label_model import Edit as ModelEdit
from tests.labels.label_model import Mark, Model

ALIKE = {"create": "label", "change": "label", "remove": "label", "track": "tracking"}
"""What the journal calls an edit."""


class QuickModel(Model):
    """The model, with a replay that goes on where the last one ended as long as it may."""

    def __init__(self) -> None:
        super().__init__()
        self._held: dict[str, tuple[list[bool], dict[Any, Any]]] = {}

    def top(self, layer: str) -> dict[tuple[int, int], tuple[Any, ModelEdit]]:
        flags = [edit.in_force for edit in self.edits]
        seen, found = self._held.get(layer, ([], {}))
        if flags[: len(seen)] != seen:
            seen, found = [], {}
        for edit in self.edits[len(seen) :]:
            if edit.in_force:
                found.update({p: (value, edit) for p, value in getattr(edit, layer).items()})
        self._held[layer] = flags, found
        return found


class Replay:
    """The model of one sequence, brought up to date after every restart."""

    def __init__(self, workspace: Path, database: str = "") -> None:
        recording = open_sequence(workspace / "sequences" / SEQUENCE)
        self.database = database or f"sqlite:///{workspace / 'labels.sqlite'}"
        self._source_index = [recording[i].source_index for i in range(len(recording))]
        self._xyz = [recording[i].source_xyz().astype(np.float64) for i in range(len(recording))]
        self.model = QuickModel()
        self.revision = 0
        self.edits = self.runs = 0

    def check(self, api: httpx.Client, people: list[Person]) -> None:
        """Catch up and compare; again if a resumed run was committed meanwhile."""
        while True:
            self.catch_up(api, people)
            try:
                return self.compare(api)
            except AssertionError:
                if not self._rows(api):
                    raise

    # ── the journal against what was asked ──

    def catch_up(self, api: httpx.Client, people: list[Person]) -> None:
        """Take in what was committed since; raises AssertionError where a promise is broken."""
        rows = self._rows(api)
        assert [row["revision"] for row in rows] == [
            self.revision + 1 + i for i in range(len(rows))
        ], "revisions have gaps"
        mine = {person.name: self._due(person) for person in people}
        for row in rows:
            if row["author"] == "setup":
                asked = Asked({"kind": "create", "name": row["summary"].split("'")[1]})
            else:
                assert row["author"] in mine, f"an author nobody knows: {row}"
                asked = self._match(row, mine[row["author"]])
            self._apply(row, asked)
            self.revision = row["revision"]
        for name, due in mine.items():
            for asked in due:
                assert asked.answer is None, f"an answered edit of {name} is missing: {asked}"

    def _rows(self, api: httpx.Client) -> list[dict[str, Any]]:
        rows: list[dict[str, Any]] = []
        before = None
        while True:
            params = {"limit": 1000, **({} if before is None else {"before": before})}
            found = api.get(f"/sequences/{SEQUENCE}/edits", params=params).raise_for_status().json()
            rows += [row for row in found if row["revision"] > self.revision]
            if not found or found[-1]["revision"] <= self.revision + 1:
                return rows[::-1]
            before = found[-1]["revision"]

    def _due(self, person: Person) -> list[Asked]:
        """What may be new in the journal, in the order it was asked; sees to the answers."""
        due = []
        for asked in person.asked:
            if asked.revision is None:
                if asked.refused is None:
                    due.append(asked)
                continue
            # In the journal before: sent again, it must be answered as it was the first time.
            if asked.answer is not None and "revision" in asked.answer:
                assert asked.answer["revision"] == asked.revision, f"applied twice: {asked}"
            assert asked.refused is None or asked.edit["kind"] == "track", asked
        person.asked = [asked for asked in due if asked is person.waiting or asked.answer]
        return due

    def _match(self, row: dict[str, Any], due: list[Asked]) -> Asked:
        while due:
            asked = due.pop(0)
            if self._is(row, asked.edit):
                asked.revision = row["revision"]
                self._compare_answer(row, asked)
                return asked
            assert asked.answer is None, f"missing or out of order: {asked}, the journal has {row}"
        raise AssertionError(f"an edit that nobody asked for, or that was refused: {row}")

    def _is(self, row: dict[str, Any], edit: Edit) -> bool:
        kind = edit["stroke"]["tool"] if edit["kind"] == "stroke" else edit["kind"]
        return bool(row["kind"] == ALIKE.get(kind, kind) and row["id"] == edit["id"])

    @staticmethod
    def _compare_answer(row: dict[str, Any], asked: Asked) -> None:
        if asked.answer is not None and "revision" in asked.answer:
            said = (asked.answer["revision"], asked.answer["changed"])
            assert said == (row["revision"], row["points"]), f"{asked}: the journal has {row}"

    # ── the model ──

    def _apply(self, row: dict[str, Any], asked: Asked) -> None:
        edit, author, model = asked.edit, row["author"], self.model
        self.edits += 1
        match edit["kind"]:
            case "stroke":
                self._stroke(author, edit["frame"], edit["stroke"])
            case "undo":
                model.undo(author)
            case "redo":
                model.redo(author)
            case "create":
                model.create(author, edit["name"], None)
            case "change":
                model.change(author, edit["label"], **edit["fields"])
            case "remove":
                model.delete(author, edit["label"])
            case "track":
                self._track(author, row["revision"])

    def _stroke(self, author: str, frame: int, stroke: dict[str, Any]) -> None:
        shown = self.model.visible()
        taken = swept(self._xyz[frame], stroke).tolist()
        wants_deleted = stroke["tool"] == "restore"
        points = [
            (frame, point)
            for point in taken
            if shown.get((frame, point), (0, 0, False))[2] == wants_deleted
        ]
        only = "unlabeled" if stroke["only_unlabeled"] else "any"
        seen = {"hidden": frozenset(stroke["hidden"])}
        match stroke["tool"]:
            case "paint":
                self.model.write(author, points, stroke["label"], 1, None, only, **seen)
            case "erase":
                self.model.write(author, points, 0, 1, None, "labeled", **seen)
            case "delete":
                self.model.write(author, points, None, None, True, only, **seen)
            case "restore":
                self.model.write(author, points, None, None, False)

    def _track(self, author: str, revision: int) -> None:
        """A run's findings as recorded; all of its frames must be there."""
        self.runs += 1
        edit = ModelEdit(author)
        database = Database(self.database)
        with closing(database), database.read() as connection:
            blocks = connection.execute(
                select(edit_blocks.c.frame, edit_blocks.c.block, edit_blocks.c.data).where(
                    edit_blocks.c.revision == revision, edit_blocks.c.layer == LABELS
                )
            )
            for frame, block, data in blocks.all():
                assert block == 0
                change = decode_change(data)
                sources = self._source_index[frame][change.indices].tolist()
                marks = zip(label_of(change.after), provenance_of(change.after), strict=True)
                for point, (label, provenance) in zip(sources, marks, strict=True):
                    edit.marks[frame, point] = Mark(int(label), int(provenance))
            tracks = connection.execute(
                select(edit_tracks.c.frame, edit_tracks.c.label, edit_tracks.c.data).where(
                    edit_tracks.c.revision == revision
                )
            ).all()
        edit.tracks = {(frame, label): json.loads(data) for frame, label, data in tracks}
        start = next(iter(edit.tracks.values()))["start"]
        frames = {frame for frame, _ in edit.tracks}
        assert frames == set(range(min(frames), max(frames) + 1)), "a run with frames missing"
        assert start in (min(frames), max(frames)), "a run without its start"
        assert len(frames) > 1, "a run that is cut short"
        self.model.commit(edit)

    # ── the model against what the server shows ──

    def compare(self, api: httpx.Client) -> None:
        """Every layer of every frame, the palette and the tracks."""
        visible, base = self.model.visible(), f"/sequences/{SEQUENCE}"
        for frame, xyz in enumerate(self._xyz):
            wanted = [visible.get((frame, point), (0, 0, False)) for point in range(len(xyz))]
            for column, layer in enumerate(("label", "provenance", "deleted")):
                path = f"{base}/frames/{frame}/annotation?layer={layer}"
                response = api.get(path).raise_for_status()
                shown = np.load(io.BytesIO(response.content))
                expected = np.array([values[column] for values in wanted])
                wrong = np.flatnonzero(shown != expected)
                assert not len(wrong), (
                    f"frame {frame}, {layer}: {len(wrong)} points differ from the replay of "
                    f"{self.edits} edits, such as {wrong[:5]}: {shown[wrong[:5]]}, expected "
                    f"{expected[wrong[:5]]}"
                )
        labels = api.get(f"{base}/labels").raise_for_status().json()
        palette = {n: (f["name"], f["locked"]) for n, f in self.model.palette().items()}
        shown_labels = {label["id"]: (label["name"], label["locked"]) for label in labels}
        assert shown_labels == palette, f"expected {palette}, the server shows {shown_labels}"
        shown_tracks = api.get(f"{base}/tracks").raise_for_status().json()
        shown = {(t["frame"], t["label"]): t["points"] for t in shown_tracks}
        expected = {place: track["points"] for place, track in self.model.tracks().items()}
        assert shown == expected, f"tracks: expected {expected}, the server shows {shown}"


def swept(xyz: NDArray[np.float64], stroke: dict[str, Any]) -> NDArray[np.int64]:
    """Points within the radius of the samples' polyline, one by one."""
    line = np.array([sample["origin"] for sample in stroke["samples"]])
    near = np.zeros(len(xyz), np.bool_)
    for a, b in itertools.pairwise(np.concatenate([line, line[-1:]])):
        axis = b - a
        length = axis @ axis
        along = np.clip((xyz - a) @ axis / length, 0, 1) if length else np.zeros(len(xyz))
        nearest = a + along[:, None] * axis
        near |= ((xyz - nearest) ** 2).sum(axis=1) <= stroke["radius"] ** 2
    return np.flatnonzero(near)
