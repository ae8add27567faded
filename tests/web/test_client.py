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
