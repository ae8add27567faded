"""A recording whose own labels did not come in says so everywhere, and is tried again."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import httpx
import numpy as np
import pytest

from pointbrush.cli import main
from pointbrush.client import Client
from pointbrush.errors import ConflictError, PointbrushError, UnavailableError
from tests.serving import Served, serving, settings_in

POINTS = 40
REASON = "nothing was changed: no room for labels"
NO_IMPORTS = (
    "CREATE TRIGGER full BEFORE INSERT ON edits WHEN NEW.kind = 'import' "
    "BEGIN SELECT RAISE(ABORT, 'no room for labels'); END"
)


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Served]:
    with serving(settings_in(tmp_path)) as running:
        yield running


def database(served: Served, statement: str) -> None:
    path = served.workspace.settings.workspace / "labels.sqlite"
    with closing(sqlite3.connect(path)) as connection:
        connection.execute(statement)
        connection.commit()


def upload(folder: Path) -> Path:
    """A drive with a car 3, a car 7 and points without a label."""
    drive = folder / "sequences" / "04"
    for name in ("velodyne", "labels"):
        (drive / name).mkdir(parents=True)
    scan = np.random.default_rng(0).uniform(-20, 20, (POINTS, 4)).astype("<f4")
    scan[:, 3] = 0.5
    (drive / "velodyne" / "000000.bin").write_bytes(scan.tobytes())
    packed = np.array([0, 10 | 3 << 16, 10 | 7 << 16, 40], "<u4")[np.arange(POINTS) % 4]
    (drive / "labels" / "000000.label").write_bytes(packed.tobytes())
    return folder


def test_labels_that_did_not_come_in_are_told_and_tried_again(
    served: Served, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    database(served, NO_IMPORTS)
    listed = f"{served.url}/api/v1/sequences"
    with Client(served.url, served.token) as client:
        with pytest.raises(PointbrushError, match=f"its labels were not imported: .*{REASON}"):
            client.import_files([upload(tmp_path / "drive")], name="drive")
        (known,) = client.manifests()
        assert known.labels_missing is not None
        assert REASON in known.labels_missing
        for path in ("", f"/{known.id}"):
            told = httpx.get(listed + path, headers=served.headers).json()
            assert REASON in (told if path else told[0])["labels_missing"]
        assert main(["info", "--server", served.url, "--token", served.token]) == 0
        assert f"labels did not come in: {known.labels_missing}" in capsys.readouterr().out
        (problem, *_) = served.workspace.listing.problems(known.id)
        assert REASON in problem

        recording = client[known.id]
        with pytest.raises(UnavailableError, match=REASON):
            recording.import_source_labels()
        database(served, "DROP TRIGGER full")
        for _ in range(2):
            recording.import_source_labels()
        assert client[known.id].manifest.labels_missing is None
        assert client[known.id].manifest.revision == 1
        names = {label.name for label in recording.labels()}
        assert names == {"car 3", "car 7", "road"}, "as of the uploaded files, which are gone"


def test_files_whose_points_have_no_label_are_not_missing_any(
    served: Served, tmp_path: Path
) -> None:
    (tmp_path / "a.csv").write_text("x,y,z,label\n1,2,3,0\n4,5,7,0\n")
    with Client(served.url, served.token) as client:
        recording = client.import_files([tmp_path / "a.csv"])
        assert recording.manifest.labels_missing is None


def test_files_without_labels_make_no_edit_and_have_none_to_bring(
    served: Served, tmp_path: Path
) -> None:
    (tmp_path / "a.csv").write_text("x,y,z\n1,2,3\n4,5,7\n")
    with Client(served.url, served.token) as client:
        recording = client.import_files([tmp_path / "a.csv"])
        assert recording.manifest.revision == 0
        assert list(recording.edits()) == []
        with pytest.raises(ConflictError, match="labels: expected some in the files of 'a'"):
            recording.import_source_labels()
