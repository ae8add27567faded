"""The Python client against a real server."""

from __future__ import annotations

import asyncio
import zipfile
from collections.abc import Iterator
from pathlib import Path

import httpx
import numpy as np
import pytest

from pointbrush.client import AsyncClient, Client
from pointbrush.errors import (
    BadInputError,
    ConflictError,
    NotFoundError,
    TooLargeError,
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
        assert found.edit == wall.edits()[0].id
        (first, *_) = wall.tracks()
        assert (first.label, first.pose.shape) == (label.id, (4, 4))
        assert {track.frame for track in wall.tracks()} >= {1}
        packed = np.where(np.arange(len(xyz)) % 2, 40, 0).astype("<u4")
        (tmp_path / "000000.label").write_bytes(packed.tobytes())
        report = wall.import_labels([tmp_path / "000000.label"], dry_run=True)
        assert report["labelled"] == len(xyz) // 2
        held = {each.format: each.cannot_hold for each in client.export_formats()}
        assert held["labels-only"] == ()
        assert "provenance" in held["ply"]
        out = wall.export("npz", tmp_path / "out.zip", frames="0:1")
        with zipfile.ZipFile(out) as archive:
            assert "000000.npz" in archive.namelist()
        splits = {each.format for each in client.export_formats() if each.splits}
        assert splits == {"pointcept", "openpcdet", "openpcdet-boxes"}
        out = wall.export("openpcdet", tmp_path / "split.zip", val="1:3")
        with zipfile.ZipFile(out) as archive:
            assert len(archive.read("ImageSets/val.txt").split()) == 2
        assert [each.index for each in wall.frames[1:]] == [1, 2]
        assert wall.update_label(label.id, name="stone").name == wall.label("stone").name
        assert (wall.delete_label(label.id).changed > 0, wall.labels()) == (True, [])
        wall.delete()
        assert [each.id for each in client.deleted()] == ["wall"]
        assert client.restore("wall").name == "wall"


def test_the_whole_way_awaited(served: Served, tmp_path: Path) -> None:
    async def work() -> None:
        async with AsyncClient(served.url, TOKEN) as client:
            wall = await client["wall"]
            brick, stone = await asyncio.gather(
                wall.create_label("brick"), wall.create_label("stone")
            )
            places = await asyncio.gather(*(frame.points() for frame in wall.frames))
            edits = await asyncio.gather(
                *(
                    frame.stroke(label=brick.id, radius=0.3, samples=points["xyz"][:1])
                    for frame, points in zip(wall.frames, places, strict=True)
                )
            )
            assert len({edit.revision for edit in edits}) == len(wall.frames)
            values = await wall.frames[0].annotation()
            await wall.frames[0].annotate(values, if_match=values.etag)
            run = await wall.track([brick.id], 0, 1, method="icp", progress=False)
            assert run.frames == 2
            out = await wall.export("npz", tmp_path / "out.zip")
            split = await wall.export("openpcdet", tmp_path / "split.zip", val="wall")
            with zipfile.ZipFile(split) as archive:
                assert not archive.read("ImageSets/train.txt")
            assert zipfile.is_zipfile(out)
            assert (await wall.review.counts())["open"] == 3
            with pytest.raises(NotFoundError, match="nothing"):
                await client["nothing"]
            with pytest.raises(BadInputError):
                await wall.export("nothing", tmp_path / "none.zip")
            assert {path.name for path in tmp_path.glob("*.zip")} == {"out.zip", "split.zip"}
            assert stone.id in [label.id for label in await wall.labels()]

    asyncio.run(work())


def test_folders_are_uploaded_as_they_are(served: Served, tmp_path: Path) -> None:
    folder = tmp_path / "drift" / "points"
    folder.mkdir(parents=True)
    for i in range(3):
        np.save(folder / f"{i}.npy", np.full((50, 3), i, np.float32))
    (folder / ".hidden").write_text("no part of it")
    with Client(served.url, TOKEN) as client:
        preview = client.preview([folder.parent])
        assert (preview.frames, preview.format) == (3, "npy")
        recording = client.import_files([folder.parent], fps=5.0, drop_invalid=True)
        assert (recording.name, recording.manifest.fps) == ("drift", 5.0)
        assert (recording.frames[2].points()["xyz"] == 2).all()
        (tmp_path / "empty").mkdir()
        with pytest.raises(BadInputError, match="none in"):
            client.import_files([tmp_path / "empty"])


def test_a_path_is_of_this_machine_unless_it_is_named_as_the_servers(tmp_path: Path) -> None:
    inbox, mine = tmp_path / "inbox", tmp_path / "mine"
    for folder, frames in ((inbox, 1), (mine, 2)):
        folder.mkdir()
        for i in range(frames):
            np.save(folder / f"{i}.npy", np.ones((20, 3), np.float32))
    settings = settings_in(tmp_path, import_roots=str(inbox))
    with serving(settings) as served, Client(served.url, TOKEN) as client:
        assert client.preview(str(mine)).frames == client.preview(mine).frames == 2
        assert client.preview(server_path=inbox).frames == 1
        assert client.wait(client.start_import(str(mine)))["frames"] == 2
        assert client.wait(client.start_import(server_path=str(inbox)))["frames"] == 1
        assert len(client.import_files(str(mine)).frames) == 2
        room = client.import_files(server_path=inbox)
        assert len(room.frames) == 1
        for place in (inbox, mine):
            np.full(20, 40, "<u4").tofile(place / "000000.label")
        labels = str(mine / "000000.label")
        assert room.import_labels(labels, dry_run=True)["labelled"] == 20
        on_server = inbox / "000000.label"
        assert room.import_labels(server_path=on_server, dry_run=True)["labelled"] == 20
        with pytest.raises(NotFoundError, match="server_path="):
            client.preview("/of/the/server")
        for both in ({}, {"files": mine, "server_path": inbox}):
            with pytest.raises(BadInputError, match="neither" if not both else "both"):
                client.start_import(**both)


def test_an_upload_to_a_preview_may_not_be_too_large(tmp_path: Path) -> None:
    np.save(tmp_path / "large.npy", np.zeros((1_000, 3), np.float32))
    with (
        serving(settings_in(tmp_path, max_upload=5_000)) as served,
        Client(served.url, TOKEN) as client,
        pytest.raises(TooLargeError),
    ):
        client.preview(str(tmp_path / "large.npy"))


def test_a_lost_answer_is_asked_for_again_where_that_is_safe(served: Served) -> None:
    class Losing(httpx.HTTPTransport):
        """A network that loses the first answer to each call on its way back."""

        lost: set[str]

        def handle_request(self, request: httpx.Request) -> httpx.Response:
            answer = super().handle_request(request)
            if f"{request.method} {request.url}" not in self.lost:
                self.lost.add(f"{request.method} {request.url}")
                answer.close()
                raise httpx.ReadError("lost on the way")
            return answer

    network = Losing()
    network.lost = set()
    with Client(served.url, TOKEN, transport=network) as client:
        wall = client["wall"]
        label = wall.create_label("brick")
        samples = wall.frames[0].points()["xyz"][:1]
        edit = wall.frames[0].stroke(label=label.id, radius=0.3, samples=samples)
        assert (wall.frames[0].annotation() == label.id).sum() == edit.changed > 0
        assert wall.undo().changed == edit.changed
        assert [each.undone for each in wall.edits() if each.id == edit.edit] == [True]
        wall.delete()
        assert [each.id for each in client.deleted()] == ["wall"]
        wall.delete()
        assert client.restore("wall").id == "wall"
        with pytest.raises(UnavailableError, match="lost on the way"):
            client.call("DELETE", "/sequences/wall")


def test_an_annotation_is_replaced_only_as_it_was_read(served: Served) -> None:
    with Client(served.url, TOKEN) as client:
        frame = client["wall"].frames[1]
        label = client["wall"].create_label("brick")
        values = frame.annotation()
        frame.annotate(np.full(len(values), label.id, np.uint16), if_match=values.etag)
        with pytest.raises(ConflictError):
            frame.annotate(values, if_match=values.etag)
        assert (frame.annotation() == label.id).all()


def test_labels_of_any_type_that_fits_are_taken(served: Served) -> None:
    with Client(served.url, TOKEN) as client:
        frame = client["wall"].frames[1]
        label = client["wall"].create_label("brick")
        count = len(frame.annotation())
        for kind in (np.int64, np.float32, np.uint8):
            frame.annotate(np.full(count, label.id, kind))
            assert (frame.annotation() == label.id).all()
            frame.annotate(np.zeros(count, kind))
        for wrong in (-1, 70_000, 0.5, np.nan):
            with pytest.raises(BadInputError, match=f"fit uint16, got {wrong}"):
                frame.annotate(np.full(count, wrong))
        assert not frame.annotation().any()


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
        assert [line.state for line in wall.review.history(2)] == ["accepted", "rejected"]
        assert [each.settled for each in wall.review.checks()] == [True]
        assert wall.review.agreement("wall").same is None
        boxes = wall.review.agreement("wall", boxes=True).boxes
        assert boxes is not None
        assert boxes.classes == ()
        assert wall.review.difference("wall", 0).startswith(b"\x89PNG")
        page = wall.review.report(tmp_path / "wall.html").read_text()
        assert page.startswith("<!doctype html>")
        people = wall.review.report(tmp_path / "wall.csv", "people").read_text()
        assert people.startswith("frame,person,")
        with pytest.raises(NotFoundError):
            wall.review.put(7, state="open")


def test_many_frames_are_annotated_as_one_edit(served: Served) -> None:
    with Client(served.url, TOKEN) as client:
        wall = client["wall"]
        brick = wall.create_label("brick")
        made = {
            frame: (np.arange(wall.manifest.points[frame]) % 3 == 0) * brick.id for frame in (0, 2)
        }
        edit = wall.annotate(made)
        assert edit.changed == sum(np.count_nonzero(values) for values in made.values())
        for frame, values in made.items():
            assert (wall.frames[frame].annotation() == values).all()
        wall.undo()
        assert not wall.frames[0].annotation().any()
        assert not wall.frames[2].annotation().any()
        wrong = {"frames": {9: made[0]}, "shape": {1: made[0][1:]}, "at least one": {}}
        for sentence, values in wrong.items():
            with pytest.raises(BadInputError, match=sentence):
                wall.annotate({0: made[0], **values} if values else {})
        assert not wall.frames[0].annotation().any(), "nothing is written in part"


def test_a_recording_is_found_by_its_name_and_a_server_by_the_environment(
    served: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("POINTBRUSH_SERVER", f"{served.url}/?token={TOKEN}")
    monkeypatch.delenv("POINTBRUSH_TOKEN", raising=False)
    with Client() as client:
        client["wall"].update(name="The <Wall>")
        wall = client["The <Wall>"]
        assert wall.id == "wall"
        assert "The &lt;Wall&gt;" in wall._repr_html_()
    for wrong in ("", "example", served.url):
        monkeypatch.setenv("POINTBRUSH_SERVER", wrong)
        with pytest.raises(BadInputError, match="expected"):
            Client()
