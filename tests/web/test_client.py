"""The Python client against a real server."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from pointbrush.client import Client
from pointbrush.errors import (
    BadInputError,
    ConflictError,
    NotFoundError,
    UnauthorizedError,
    UnavailableError,
)
from tests.serving import TOKEN, Served, add_sequence, serving, settings_in


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Served]:
    settings = settings_in(tmp_path)
    add_sequence(settings, "wall", frames=3, points=2_000)
    with serving(settings) as running:
        yield running


def test_the_whole_way(served: Served, tmp_path: Path) -> None:
    with Client(served.url, TOKEN) as client:
        (wall,) = client.sequences()
        assert wall.id == client["wall"].id == "wall"
        label = wall.create_label("brick", category="stone")
        assert wall.labels() == [label]
        frame = wall.frames[0]
        xyz = frame.points()["xyz"]
        edit = frame.stroke(label=label.id, radius=0.3, samples=xyz[:1])
        values = frame.annotation()
        assert edit.changed == (values == label.id).sum() > 0
        assert wall.undo().changed == edit.changed
        wall.redo()
        found = wall.track([label.id], 0, 2, method="icp", progress=False)
        assert found["edit"]
        assert {track["frame"] for track in wall.tracks()} >= {1}
        packed = np.where(np.arange(len(xyz)) % 2, 40, 0).astype("<u4")
        (tmp_path / "000000.label").write_bytes(packed.tobytes())
        report = wall.import_labels([tmp_path / "000000.label"], dry_run=True)
        assert report["labelled"] == len(xyz) // 2
        out = wall.export("npz", tmp_path / "out.zip", frames="0:1")
        with zipfile.ZipFile(out) as archive:
            assert "000000.npz" in archive.namelist()
        assert [each.index for each in wall.frames[1:]] == [1, 2]


def test_an_annotation_is_replaced_only_as_it_was_read(served: Served) -> None:
    with Client(served.url, TOKEN) as client:
        frame = client["wall"].frames[1]
        label = client["wall"].create_label("brick")
        values = frame.annotation()
        frame.annotate(np.full(len(values), label.id, np.uint16), if_match=values.etag)
        with pytest.raises(ConflictError):
            frame.annotate(values, if_match=values.etag)
        assert (frame.annotation() == label.id).all()


def test_refusals_are_the_named_errors(served: Served) -> None:
    with Client(served.url, TOKEN) as client:
        with pytest.raises(NotFoundError, match="nothing"):
            _ = client["nothing"]
        with pytest.raises(BadInputError, match="label"):
            client["wall"].frames[0].stroke(label=0, samples=[[0, 0, 0]])
        with pytest.raises(IndexError):
            _ = client["wall"].frames[3]
    with Client(served.url, "wrong") as client, pytest.raises(UnauthorizedError):
        client.sequences()
    with Client("http://127.0.0.1:9", "t") as client, pytest.raises(UnavailableError):
        client.sequences()


def test_the_review(served: Served, tmp_path: Path) -> None:
    with Client(served.url, TOKEN) as client:
        wall = client["wall"]
        wall.create_label("brick")
        (unused,) = wall.review.checks()
        assert (unused.kind, unused.labels, unused.place) == ("few", (1,), None)
        wall.review.put(0, 1, assignee="grace")
        wall.review.put(1, state="rejected", note="open", place=(1, 2, 3))
        wall.review.put(label=1, state="accepted")
        assert wall.review.counts()["rejected"] == 1
        frame = wall.review.frame(1)
        assert (frame.note, frame.place, frame.assignee) == ("open", (1.0, 2.0, 3.0), "grace")
        assert [(each.first, each.label) for each in wall.review.standings()] == [
            (0, None),
            (1, None),
            (None, 1),
        ]
        assert [line["state"] for line in wall.review.history(2)] == ["accepted", "rejected"]
        assert [each.settled for each in wall.review.checks()] == [True]
        assert wall.review.agreement("wall")["same"] is None
        assert wall.review.difference("wall", 0).startswith(b"\x89PNG")
        page = wall.review.report(tmp_path / "wall.html").read_text()
        assert page.startswith("<!doctype html>")
        people = wall.review.report(tmp_path / "wall.csv", "people").read_text()
        assert people.startswith("frame,person,")
        with pytest.raises(NotFoundError):
            wall.review.put(7, state="open")
