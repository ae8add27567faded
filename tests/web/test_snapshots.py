"""Versions of a project's labels over REST: difference and export."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

from pointbrush.client import Client
from pointbrush.errors import NotFoundError
from tests.serving import TOKEN, Served


def test_two_versions_differ_by_what_was_done_between_and_export_as_they_were(
    served: Served, tmp_path: Path
) -> None:
    with Client(served.url, TOKEN) as client:
        wall, project = client["wall"], client.projects["default"]
        brick, door = wall.create_label("brick"), wall.create_label("door")
        count = len(wall.frames[0].points()["xyz"])
        values = np.zeros(count, np.uint16)
        values[:100], values[100:150] = brick.id, door.id
        wall.frames[0].annotate(values)
        first = project.snapshot("First")
        values[50:120], values[140:150], values[200:230] = door.id, 0, door.id
        wall.frames[0].annotate(values)
        wall.frames[2].annotate(np.full(len(wall.frames[2].points()["xyz"]), brick.id, np.uint16))
        second = project.snapshot("First")
        assert (first.id, second.id) == ("first", "first-2")
        window = wall.create_label("window")
        wall.delete_label(door.id)
        (found,) = project.difference(first.id, second.id)
        assert found.labels == ()
        points = [(each.frame, each.came, each.went, each.changed) for each in found.frames]
        assert points == [(0, 30, 10, 50), (2, len(wall.frames[2].points()["xyz"]), 0, 0)]
        assert found.frames[1].objects_came == (brick.id,)
        (back,) = project.difference(second.id, first.id)
        assert (back.frames[0].came, back.frames[0].went) == (10, 30)
        (now,) = project.difference(second.id, sequence="wall")
        assert {(each.name, each.kind) for each in now.labels} == {
            ("door", "went"),
            ("window", "came"),
        }
        assert now.frames[0].objects_went == (door.id,)
        assert window.id not in now.frames[0].objects_came
        out = wall.export("npz", tmp_path / "out.zip", frames="0:1", snapshot=second.id)
        with zipfile.ZipFile(out) as archive, archive.open("000000.npz") as file:
            assert np.array_equal(np.load(file)["label"], values)
        then = wall.frames[0].annotation(snapshot=second.id)
        assert np.array_equal(then, values)
        assert not np.array_equal(wall.frames[0].annotation(), values)
        assert [each.id for each in project.snapshots()] == ["first-2", "first"]
        project.delete_snapshot(first.id)
        with pytest.raises(NotFoundError, match="snapshot"):
            wall.frames[0].annotation(snapshot=first.id)
        with pytest.raises(NotFoundError):
            project.difference(first.id)
