"""Recordings in a folder and in object storage: one suite, and what only a bucket can do wrong."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from unittest.mock import MagicMock
from urllib.request import urlopen

import fsspec
import numpy as np
import pytest
from s3fs import S3FileSystem
from sqlalchemy import update

from pointbrush.client import Client
from pointbrush.database import schema
from pointbrush.errors import DamagedError, NotFoundError, PointbrushError, UnavailableError
from pointbrush.labels import KEPT_SECONDS
from pointbrush.labels.recordings import SURE_SECONDS
from pointbrush.sequences import RecordingInfo, import_frames, open_sequence, verify
from pointbrush.sequences.storage import files
from pointbrush.sequences.storage.bucket import Bucket
from pointbrush.sequences.storage.bucket_files import BucketFiles
from pointbrush.sequences.storage.file_cache import FileCache
from pointbrush.settings import Settings
from pointbrush.work.backups.backup import make_backup
from pointbrush.work.imports.importing import ImportWork
from pointbrush.work.imports.requests import ImportRequest
from pointbrush.work.trash import ids_for
from pointbrush.workspace import Workspace
from tests import forked
from tests.buckets import s3, s3_endpoint  # noqa: F401  # fixtures
from tests.serving import TOKEN, serving, settings_in, surface
from tests.streaming.client import viewer
from tests.waiting import eventually

FRAMES, POINTS = 4, 300


def source(folder: Path) -> Path:
    """Files of a recording with colours, further fields and labels."""
    made = folder / "room"
    made.mkdir(parents=True)
    for index in range(FRAMES):
        rng = np.random.default_rng(index)
        rows = np.column_stack(
            [rng.uniform(-1, 1, (POINTS, 3)), rng.integers(0, 200, (POINTS, 3)), np.arange(POINTS)]
        )
        np.savetxt(
            made / f"{index}.csv", rows, delimiter=",", header="x,y,z,r,g,b,echo", comments=""
        )
    return made


@pytest.fixture(params=["folder", "s3"])
def settings(request: pytest.FixtureRequest, tmp_path: Path) -> Settings:
    url = "" if request.param == "folder" else request.getfixturevalue("s3")
    return settings_of(tmp_path, url)


def settings_of(folder: Path, url: str, cache: str = "cache", **more: object) -> Settings:
    return settings_in(folder, sequences=url, sequence_cache=str(folder / cache), **more)


@pytest.fixture
def workspace(settings: Settings) -> Iterator[Workspace]:
    with closing(Workspace(settings)) as opened:
        yield opened


class Channel:
    """Nobody listens; a process of its own for each import would take seconds."""

    def progress(self, fraction: float, message: str) -> None: ...

    def item(self, value: object) -> None: ...


def imported(workspace: Workspace, folder: Path) -> str:
    library, guards = workspace.library, workspace.labels.guards
    guard = guards.reserve(ids_for("room"), library.is_free)
    target = library.store.target(guard.sequence)
    ImportWork(ImportRequest((source(folder),)), target, guard.sequence)(Channel())
    guards.end(guard)
    assert guard.sequence in [one.id for one in workspace.listing.all()]
    return guard.sequence


def objects(url: str) -> set[str]:
    fs, root = fsspec.url_to_fs(url, use_listings_cache=False)
    return {name.removeprefix(f"{root}/") for name in fs.find(root)}


def test_a_recording_lives(workspace: Workspace, settings: Settings, tmp_path: Path) -> None:
    assert workspace.listing.all() == []
    assert imported(workspace, tmp_path) == "room"
    assert [(one.id, one.damaged) for one in workspace.listing.all()] == [("room", None)]
    first = workspace.recording("room")
    expected = np.random.default_rng(2).uniform(-1, 1, (POINTS, 3))
    assert np.allclose(first[2].source_xyz(), expected, atol=1e-6)
    assert first.other_of(2, 0, POINTS)["echo"].tolist() == list(range(POINTS))
    assert len(first[2].wire(0, 1)) > 0
    assert workspace.listing.problems("room") == []

    workspace.update_sequence("room", name="Hall")
    label_all(workspace)
    with closing(Workspace(settings)) as other:
        assert [one.name for one in other.listing.all()] == ["Hall"]
        assert other.annotations.read("room", 0)[0].all()
        # Others open it too: a worker process has no more than this.
        again = open_sequence(other.recording("room").files)
        assert np.array_equal(again[1].xyz, first[1].xyz)

    make_backup(workspace.labels, workspace.library, tmp_path / "backup")
    kept = open_sequence(tmp_path / "backup" / "sequences" / "room")
    assert kept[3].source_xyz().tobytes() == first[3].source_xyz().tobytes()
    workspace.update_sequence("room", name="Room")
    workspace.back_up(tmp_path / "later", tmp_path / "backup")
    first, later = (
        {path.relative_to(root): path for path in root.rglob("*") if path.is_file()}
        for root in (tmp_path / "backup" / "sequences", tmp_path / "later" / "sequences")
    )
    copied = {path.name for path, file in later.items() if not file.samefile(first[path])}
    assert copied <= {"manifest.json", "checksums.json", "sensor.json"}
    assert workspace.restore_from_backup(tmp_path / "later", "room") == "room-2"
    assert workspace.listing.problems("room-2") == []
    assert workspace.annotations.read("room-2", 0)[0].all()


def label_all(workspace: Workspace) -> None:
    """Give all points of the first frame one label."""
    workspace.labels.create_label("room", "ada", name="wall")
    workspace.annotations.put("room", 0, np.ones(POINTS, np.uint16), author="ada")


def test_deleting_and_restoring(workspace: Workspace, settings: Settings, tmp_path: Path) -> None:
    imported(workspace, tmp_path / "once")
    label_all(workspace)
    with closing(Workspace(settings)) as other:
        assert [one.id for one in other.listing.all()] == ["room"]
        workspace.deletion.delete("room")
        assert other.listing.all() == workspace.listing.all() == []
    with pytest.raises(NotFoundError):
        workspace.recording("room")
    again = imported(workspace, tmp_path / "again")
    restored = workspace.deletion.restore("room")
    assert {again, restored} == {"room", "room-2"}
    assert {one.id: one.damaged for one in workspace.listing.all()} == {
        "room": None,
        "room-2": None,
    }
    assert workspace.annotations.read(restored, 0)[0].all()
    assert workspace.listing.problems(restored) == []

    workspace.deletion.delete(restored)
    columns = schema.sequences.c
    over = update(schema.sequences).where(columns.deleted.is_not(None))
    earlier = columns.deleted - KEPT_SECONDS - SURE_SECONDS - 1
    with workspace.labels.database.write() as connection:
        connection.execute(over.values(deleted=earlier, expired=earlier + KEPT_SECONDS))
    assert workspace.deletion.deleted() == []
    assert [one.id for one in workspace.listing.all()] == [again]
    if settings.sequences:
        assert {name.partition("/")[0] for name in objects(settings.sequences)} == {again}


def killed(settings: Settings, found: Path) -> None:
    """Import, killed once all is there but what makes it a recording."""

    def die(*_: object) -> None:
        os.kill(os.getpid(), signal.SIGKILL)

    with closing(Workspace(settings)) as workspace, pytest.MonkeyPatch.context() as patch:
        workspace.labels.guards.reserve(["room"], workspace.library.is_free)
        patch.setattr(*(Bucket, "write") if settings.sequences else (files, "_rename"), die)
        target = workspace.library.store.target("room")
        ImportWork(ImportRequest((found,)), target, "room")(MagicMock())


def test_an_import_that_is_killed_is_not_listed_and_leaves_nothing(
    settings: Settings, tmp_path: Path
) -> None:
    assert forked.call(killed, settings, source(tmp_path / "killed")) == -signal.SIGKILL
    if settings.sequences:
        assert len(objects(settings.sequences)) > FRAMES
    with closing(Workspace(settings)) as workspace:
        assert workspace.listing.all() == []
        assert imported(workspace, tmp_path / "again") == "room"
        assert workspace.listing.problems("room") == []
        folder = workspace.library.folder
        assert [path for path in folder.rglob(".tmp-*") if path.is_dir()] == []


# ── what only a bucket can do ────────────────────────────────────────────────────────────


@pytest.fixture
def served_from(s3: str, tmp_path: Path) -> Settings:  # noqa: F811
    """Settings of a workspace with a recording in a bucket, and an empty cache."""
    frames = (surface(POINTS, index) for index in range(FRAMES))
    import_frames(frames, tmp_path / "room", RecordingInfo("room", "room", 30))
    Bucket(s3, FileCache(tmp_path / "other", 1 << 30)).publish(tmp_path / "room", "room")
    return settings_of(tmp_path, s3)


def test_the_main_job_on_a_server(s3: str, tmp_path: Path) -> None:  # noqa: F811
    with serving(settings_of(tmp_path, s3)) as served, Client(served.url, TOKEN) as client:
        room = client.import_files([*source(tmp_path).iterdir()], name="room")
        wall = room.create_label("wall")
        edit = room.frames[0].stroke(
            label=wall.id, shape="sphere", radius=0.5, samples=[[0.0, 0.0, 0.0]]
        )
        assert edit.changed > 0
        run = room.track([wall.id], start=0, stop=FRAMES - 1, method="icp")
        assert run.frames
        out = room.export("npz", tmp_path / "out")
        assert out.exists()
        with urlopen(f"{served.url}/readyz") as answer:
            assert json.load(answer)["parts"]["sequences"] == "ok"
        assert any(name.startswith("room/frames/") for name in objects(s3))


def test_a_viewer_sees_a_frame_as_soon_as_it_can_be_had(
    served_from: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def scenario(url: str) -> None:
        async with viewer(url, TOKEN) as client:
            with monkeypatch.context() as patch:
                asked = away(patch)
                await client.open("room", frame=0)
                await asyncio.to_thread(eventually, lambda: asked)
                assert 0 not in client.frames
            while not (0 in client.frames and client.frames[0].final):
                await client.receive()
            assert client.frames[0].total == POINTS

    with serving(served_from) as served:
        asyncio.run(scenario(served.url))


def test_frames_after_one_that_is_looked_at_are_fetched_ahead(served_from: Settings) -> None:
    with closing(Workspace(served_from)) as workspace:
        recording = workspace.recording("room")
        _ = recording[0]
        frames = recording.path / "frames"
        eventually(lambda: len(list(frames.glob("*.points"))) == FRAMES)


@pytest.mark.parametrize("change", ["other bytes", "fewer bytes", "none"])
def test_a_frame_whose_object_changed_is_named_and_served_again_once_it_is_right(
    served_from: Settings, change: str
) -> None:
    fs, root = fsspec.url_to_fs(served_from.sequences, use_listings_cache=False)
    name = f"{root}/room/frames/000002.points"
    whole = fs.cat_file(name)
    other = {"other bytes": whole[:-1] + bytes([whole[-1] ^ 1]), "fewer bytes": whole[:-9]}
    fs.rm_file(name) if change == "none" else fs.pipe_file(name, other[change])
    with closing(Workspace(served_from)) as workspace:
        recording = workspace.recording("room")
        for _ in range(2):
            with pytest.raises(DamagedError, match="frame 2 is damaged"):
                _ = recording[2].xyz
        assert len(recording[1].xyz) == POINTS
        fs.pipe_file(name, whole)
        assert len(recording[2].xyz) == POINTS


def test_an_octree_and_a_lack_of_room(
    s3: str,  # noqa: F811
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("pointbrush.sequences.importer.LARGE_POINTS", POINTS)
    whole = surface(20 * POINTS, 0)
    import_frames([whole], tmp_path / "scan", RecordingInfo("scan", "scan", 1))
    bucket = Bucket(s3, FileCache(tmp_path / "cache", 1))
    bucket.publish(tmp_path / "scan", "scan")
    recording = open_sequence(BucketFiles(bucket, "scan"))
    frame = recording[0]
    assert frame.large
    assert frame.source_xyz().tobytes() == whole.xyz.tobytes()
    # There is room for nothing, but what is open stays.
    assert open_sequence(BucketFiles(bucket, "scan"))[0].read("rgb", 0, 9).shape == (9, 3)
    assert frame.read("rgb", 0, POINTS).shape == (POINTS, 3)
    assert verify(BucketFiles(bucket, "scan")) == []


def test_damage_in_the_bucket_is_found_and_in_the_cache_mended(served_from: Settings) -> None:
    fs, root = fsspec.url_to_fs(served_from.sequences)
    name = f"{root}/room/frames/000002.points"
    whole = fs.cat_file(name)
    fs.pipe_file(name, whole[:-1] + bytes([whole[-1] ^ 1]))
    with closing(Workspace(served_from)) as workspace:
        recording = workspace.recording("room")
        with pytest.raises(PointbrushError, match="not those that were imported"):
            _ = recording[2]
        assert any("000002.points" in problem for problem in workspace.listing.problems("room"))
        fs.pipe_file(name, whole)
        expected = recording[2].xyz.copy()
        (recording.path / "frames" / "000002.points").write_bytes(b"")
        assert np.array_equal(open_sequence(recording.files)[2].xyz, expected)


def test_a_small_cache_is_enough(served_from: Settings) -> None:
    with closing(Workspace(replace(served_from, sequence_cache_bytes=1))) as workspace:
        frame = workspace.recording("room")[0]
        for other in range(FRAMES):
            _ = workspace.recording("room")[other].xyz
        assert len(frame.wire(0, 1)) > 0


def test_while_the_store_is_away_what_is_here_is_served(
    served_from: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    with closing(Workspace(served_from)) as workspace:
        recording = workspace.recording("room")
        known = recording[0].xyz.copy()
        away(monkeypatch)
        # As if it were long ago that the bucket was asked.
        monkeypatch.setattr("pointbrush.work.bucket_store.FRESH_SECONDS", -1.0)
        assert np.array_equal(workspace.recording("room")[0].xyz, known)
        with pytest.raises(UnavailableError, match="expected an answer from the bucket"):
            workspace.listing.all()
        with pytest.raises(UnavailableError):
            workspace.ready_checks()["sequences"]()


def away(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Have every call of the store fail as if nothing listened at its address; return the calls."""
    asked: list[str] = []

    async def fail(_: object, method: str, *__: object, **___: object) -> None:
        asked.append(method)
        raise ConnectionRefusedError("nobody listens")

    monkeypatch.setattr("s3fs.core.S3FileSystem._call_s3", fail)
    return asked


def test_what_cannot_be_used_says_why(
    s3: str,  # noqa: F811
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def problem(url: str) -> str:
        with pytest.raises(PointbrushError) as caught:
            Workspace(settings_of(tmp_path, url))
        return str(caught.value)

    assert "expected a bucket that exists" in problem("s3://nobodys-bucket/recordings")
    assert "expected a URL such as s3://" in problem("lab/recordings")
    assert "expected a URL that fsspec knows" in problem("carrier-pigeon://lab")
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "s3fs", None)
        patch.setitem(sys.modules, "fsspec", None)
        assert "pip install 'pointbrush[s3]'" in problem(s3)
    with monkeypatch.context() as patch:
        S3FileSystem.clear_instance_cache()
        patch.delenv("AWS_ACCESS_KEY_ID")
        patch.setenv("AWS_SHARED_CREDENTIALS_FILE", str(tmp_path / "none"))
        patch.setenv("AWS_CONFIG_FILE", str(tmp_path / "none"))
        assert "expected credentials for the bucket" in problem(s3)
    S3FileSystem.clear_instance_cache()
    with monkeypatch.context() as patch:
        away(patch)
        assert "expected an answer from the bucket, got none" in problem(s3)
