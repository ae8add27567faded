"""What an import would do is said before anything is written, and can be corrected."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from PIL import Image

from pointbrush.cli import main
from pointbrush.sequences import open_sequence
from pointbrush.web.upload_files import KEPT_SECONDS, KeptUploads, Upload
from tests.serving import Served, serving, settings_in
from tests.waiting import PATIENCE


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    folder = tmp_path_factory.mktemp("previews")
    (folder / "inbox").mkdir()
    with serving(settings_in(folder, import_roots=str(folder / "inbox"))) as running:
        yield running


def inbox(served: Served) -> Path:
    return served.workspace.settings.roots[0]


def room(path: Path, frames: int = 2, scale: float = 1.0, z: int = 2) -> Path:
    """Frames of an open box of 4 x 3 m that is 2.5 m high, with its floor at 0 along axis ``z``."""
    path.mkdir()
    rng = np.random.default_rng(0)
    for i in range(frames):
        floor = rng.uniform([-2, -1.5, 0], [2, 1.5, 0.01], (2000, 3))
        wall = rng.uniform([-2, 1.49, 0], [2, 1.5, 2.5], (1500, 3))
        side = rng.uniform([-2, -1.5, 0], [-1.99, 1.5, 2.5], (1500, 3))
        points = np.concatenate([floor, wall, side]) * scale
        order = [(a + 2 - z) % 3 for a in range(3)]
        np.savetxt(path / f"{i}.csv", points[:, order], delimiter=";", fmt="%.3f")
    return path


def ask(served: Served, body: dict[str, Any]) -> httpx.Response:
    url = f"{served.url}/api/v1/imports/preview"
    return httpx.post(url, json=body, headers=served.headers)


def send(served: Served, call: str, files: dict[str, bytes], **fields: str) -> httpx.Response:
    return httpx.post(
        f"{served.url}/api/v1/{call}",
        files=[("files", (name, data)) for name, data in files.items()],
        data=fields,
        headers=served.headers,
    )


def imported(served: Served, answer: httpx.Response) -> dict[str, Any]:
    assert answer.status_code == 202, answer.text
    job = served.workspace.runner.wait(answer.json()["id"], PATIENCE)
    assert job.state == "done", job.error
    assert job.result is not None
    return job.result


def test_a_preview_says_what_an_import_would_do_and_writes_nothing(served: Served) -> None:
    folder = room(inbox(served) / "room")
    (folder / "poses.txt").write_text("1 0 0 0 0 1 0 0 0 0 1 0\n" * 2)
    answer = ask(served, {"path": str(folder), "fps": 12.5})
    assert answer.status_code == 200, answer.text
    found = answer.json()
    assert (found["name"], found["format"], found["frames"]) == ("room", "text", 2)
    assert (found["fps"], found["fps_from"]) == (12.5, "given")
    assert found["order"] == "by number in the file names"
    assert found["points"] == [{"points": 5000, "left_out": 0}] * 2
    assert [c["meaning"] for c in found["columns"]] == ["x", "y", "z"]
    assert found["poses"] == {"source": "poses.txt", "agree": None}
    assert (found["units"]["name"], found["up"]) == ("metres", "z")
    assert any("no 'Tr'" in warning for warning in found["warnings"])
    assert served.workspace.library.manifests() == []


def test_units_and_up_are_guessed_shown_and_corrected(served: Served) -> None:
    folder = room(inbox(served) / "wide", scale=1000, z=1)
    found = ask(served, {"path": str(folder)}).json()
    assert (found["units"]["name"], found["units"]["scale"]) == ("millimetres", 0.001)
    assert found["up"] == "y"
    assert any("scale 0.001" in warning for warning in found["warnings"])
    body = {"path": str(folder), "scale": 0.001, "up": "-x", "name": "Turned"}
    corrected = ask(served, body).json()
    assert corrected["units"]["name"] == "metres"
    assert (corrected["up"], corrected["name"]) == ("-x", "Turned")
    assert corrected["warnings"] == []
    url = f"{served.url}/api/v1/sequences"
    result = imported(served, httpx.post(url, json=body, headers=served.headers))
    recording = served.workspace.recording(result["sequence"])
    assert np.ptp(recording[0].read_source(0, 5000, ["xyz"])["xyz"], axis=0).max() == pytest.approx(
        4, abs=0.1
    )
    assert recording.manifest.T_room_local[1, :3] == pytest.approx([-1, 0, 0], abs=0.35)


def test_sent_files_wait_for_corrections_and_are_imported_without_being_sent_again(
    served: Served,
) -> None:
    files = {"odd.txt": b"1 2 3 0.5 400\n4 5 6 0.6 500\n", "notes.csv": b""}
    refused = send(served, "imports/preview", {"odd.txt": b"a;b\n1;2\n"})
    assert refused.status_code == 422
    assert "expected numbers" in refused.json()["detail"]
    assert len(refused.json()["upload"]) == 32
    files.pop("notes.csv")
    found = send(served, "imports/preview", files, columns="x,y,z,intensity,label").json()
    assert [c["meaning"] for c in found["columns"]] == ["x", "y", "z", "intensity", "label"]
    assert found["labels"] is True
    again = ask(served, {"upload": found["upload"], "columns": "x,y,z,-,intensity"}).json()
    assert again["upload"] == found["upload"]
    assert [c["name"] for c in again["columns"]] == ["x", "y", "z", "intensity"]
    url = f"{served.url}/api/v1/sequences"
    body = {"upload": found["upload"], "columns": ["x", "y", "z", "-", "intensity"]}
    result = imported(served, httpx.post(url, json=body, headers=served.headers))
    intensity = served.workspace.recording(result["sequence"]).manifest.intensity_range
    assert intensity == pytest.approx([400, 500], abs=1)
    gone = httpx.post(url, json=body, headers=served.headers)
    assert gone.status_code == 404
    dropped = f"{served.url}/api/v1/imports/{refused.json()['upload']}"
    assert httpx.delete(dropped, headers=served.headers).status_code == 204
    assert httpx.delete(dropped, headers=served.headers).status_code == 404


def test_poses_of_an_upload_are_one_of_its_files_and_no_other(served: Served) -> None:
    files = {f"run/{i}.xyz": b"1 2 3\n4 5 6\n" for i in range(2)}
    files["run/where.txt"] = b"0 0 0 0 0 0 1\n9 0 0 0 0 0 1\n"
    result = imported(served, send(served, "sequences", files, poses="run/where.txt", format="xyz"))
    poses = served.workspace.recording(result["sequence"]).manifest.poses
    assert [pose and pose[3] for pose in poses] == [0, 9]
    for elsewhere in ("/etc/passwd", "../../x", "absent.txt"):
        answer = send(served, "sequences", files, poses=elsewhere)
        assert answer.status_code == 422, answer.text


def test_paths_and_poses_outside_the_roots_are_refused(served: Served) -> None:
    folder = room(inbox(served) / "inside")
    for body in ({"path": "/etc"}, {"path": str(folder), "poses": "/etc/hostname"}):
        assert ask(served, body).status_code == 403
    for body in ({}, {"path": str(folder), "upload": "0" * 32}):
        assert ask(served, body).status_code == 422


def test_warnings_of_an_import_are_in_its_result(served: Served) -> None:
    files = {"a.xyz": b"1 2 3\n", "b.xyz": b"1 2 3\n", "poses.txt": b"1 2\n"}
    result = imported(served, send(served, "sequences", files))
    warnings = " ".join(result["warnings"])
    assert "the poses are not used: poses.txt line 1: expected 12 numbers" in warnings


@pytest.mark.parametrize(("name", "fps"), [("{}.xyz", 30), ("velodyne/{}.bin", 10)])
def test_a_rate_that_nothing_states_is_named_as_assumed(
    served: Served, name: str, fps: float
) -> None:
    folder = inbox(served) / f"assumed-{fps}"
    for k in range(2):
        path = folder / name.format(k)
        path.parent.mkdir(parents=True, exist_ok=True)
        points = np.random.default_rng(k).uniform(0, 9, (50, 4)).astype("<f4")
        path.write_bytes(points.tobytes()) if path.suffix == ".bin" else np.savetxt(path, points)
    body = {"path": str(folder)}
    found = ask(served, body).json()
    assert (found["fps"], found["fps_from"]) == (fps, "assumed")
    url = f"{served.url}/api/v1/sequences"
    result = imported(served, httpx.post(url, json=body, headers=served.headers, timeout=60))
    assert result["fps"] == fps
    assert f"the rate of {fps} frames a second is assumed" in " ".join(result["warnings"])
    answer = httpx.post(url, json={**body, "fps": 5}, headers=served.headers, timeout=60)
    result = imported(served, answer)
    assert result["fps"] == 5
    assert "assumed" not in " ".join(result["warnings"])


def test_files_wait_for_an_hour_and_for_their_owner(tmp_path: Path) -> None:
    now = [0.0]
    kept = KeptUploads(lambda: now[0])

    def sent(number: int) -> Upload:
        folder = tmp_path / f"owner.{number:032x}"
        folder.mkdir()
        return kept.keep(Upload("", "ann", folder, (folder,), None))

    first = sent(1)
    assert kept.find(first.id, "ann") == first
    with pytest.raises(Exception, match="send them again"):
        kept.find(first.id, "bob")
    now[0] = KEPT_SECONDS + 1
    with pytest.raises(Exception, match="send them again"):
        kept.find(first.id, "ann")
    sent(2)
    assert not first.folder.exists()


def test_the_command_previews_without_a_workspace(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = room(tmp_path / "room", scale=1000)
    workspace = tmp_path / "workspace"
    given = ["import", str(folder), "--dry-run", "--workspace", str(workspace), "--up=z"]
    assert main(given) == 0
    printed = capsys.readouterr().out
    for expected in ("text (XYZ, TXT, PTS, CSV)", "2, by number", "millimetres", "nothing was"):
        assert expected in printed
    assert not workspace.exists()


def test_poses_of_other_names_are_taken_by_order_when_a_person_says_so(
    served: Served, tmp_path: Path
) -> None:
    folder = room(inbox(served) / "ordered")
    for number, name in enumerate("ab"):
        (folder / f"{number}.csv").rename(folder / f"{name}.csv")
    (folder / "poses.txt").write_text("first 0 0 0 0 0 0 1\nlast 1 0 0 0 0 0 1\n")
    found = ask(served, {"path": str(folder)}).json()
    assert found["poses"] is None
    assert "--by-order" in found["warnings"][-1]
    found = ask(served, {"path": str(folder), "by_order": True}).json()
    assert found["poses"]["source"] == "poses.txt"
    assert found["files"] == [{"file": "a.csv", "frame": 0}, {"file": "b.csv", "frame": 1}]
    asked = ["import", str(folder), "--by-order", "--workspace", str(tmp_path / "ws")]
    assert main(asked) == 0
    (recording,) = (tmp_path / "ws" / "sequences").iterdir()
    pose = open_sequence(recording)[1].pose
    assert pose is not None
    assert pose[0, 3] == 1


def test_a_preview_states_colours_intrinsics_and_unused_pictures(
    served: Served, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = inbox(served) / "kinect"
    for name, shape in (("depth", ()), ("left", (3,)), ("seg", (3,))):
        (folder / name).mkdir(parents=True)
        for k in range(2):
            kind = np.uint8 if shape else np.uint16
            pixels = np.full((424, 512, *shape), 150, kind)
            Image.fromarray(pixels).save(folder / name / f"{k:04d}.png")
    (camera,) = ask(served, {"path": str(folder)}).json()["cameras"]
    assert camera == {
        "name": "depth",
        "projects": True,
        "color": "left, 2 of 2 frames",
        "intrinsics": "assumed: those of a Kinect v2",
        "unused": ["seg/0000.png (2)"],
    }
    assert main(["import", str(folder), "--dry-run"]) == 0
    said = capsys.readouterr().out
    assert "depth (colour: left, 2 of 2 frames; intrinsics: assumed: those of a Kinect v2" in said
    shutil.rmtree(folder / "left")
    (camera,) = ask(served, {"path": str(folder)}).json()["cameras"]
    assert camera["color"] == "none"
