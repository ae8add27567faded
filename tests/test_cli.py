"""The command, as a user runs it: what it prints, what it leaves, how it exits."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import plyfile
import pytest

from pointbrush.cli import main
from pointbrush.settings import Settings
from pointbrush.values.team.projects import ProjectPatch
from pointbrush.workspace import Workspace
from tests.faults.server import running
from tests.serving import settings_in


@pytest.fixture(autouse=True)
def workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "workspace"
    monkeypatch.setenv("POINTBRUSH_WORKSPACE", str(path))
    return path


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    """Three frames of a ball of 500 points that moves 2 cm a frame before a wall."""
    folder = tmp_path / "moving ball"
    folder.mkdir()
    rng = np.random.default_rng(0)
    wall = np.column_stack([rng.uniform(-1, 1, (3000, 2)), np.full(3000, 2.0)])
    ball = rng.normal(size=(500, 3))
    ball *= 0.1 / np.linalg.norm(ball, axis=1, keepdims=True)
    for i in range(3):
        xyz = np.concatenate([wall, ball + [0.02 * i, 0, 1]]).astype(np.float32)
        rgb = np.repeat(np.array([[90, 90, 90], [200, 40, 40]], np.uint8), [3000, 500], axis=0)
        np.savez(folder / f"{i}.npz", xyz=xyz, rgb=rgb)
    return folder


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


def painted(workspace: Path) -> str:
    """Import, add a label and paint the ball in frame 0, over REST against `pointbrush serve`."""
    sequence = "moving-ball"
    with running(workspace) as server, server.api() as api:
        base = f"/sequences/{sequence}"
        label = api.post(f"{base}/labels", json={"name": "ball"}).raise_for_status().json()
        stroke = {
            "label": label["id"],
            "shape": "sphere",
            "radius": 0.15,
            "samples": [{"origin": [0, 0, 1], "direction": [0, 0, 1]}],
        }
        answer = api.post(f"{base}/frames/0/strokes", json=stroke).raise_for_status().json()
        assert answer["changed"] == 500
    return sequence


def test_import_info_paint_track_export(
    workspace: Path, recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("import", recording, "--fps", 10) == 0
    assert "imported moving-ball: 3 frames, 10,500 points" in capsys.readouterr().out
    # The server that took the stroke is killed right after its answer.
    sequence = painted(workspace)
    assert run("info", sequence) == 0
    assert "ball" in capsys.readouterr().out

    command = ["track", sequence, "--from", 0, "--to", 2, "--labels", "ball", "--method", "icp"]
    assert run(*command) == 0
    assert run("export", sequence, "--format", "ply", "--out", tmp_path / "ply") == 0
    for i, path in enumerate(sorted((tmp_path / "ply").glob("**/*.ply"))):
        vertex = plyfile.PlyData.read(path)["vertex"]
        source = np.load(recording / f"{i}.npz")["xyz"]
        xyz = np.column_stack([vertex["x"], vertex["y"], vertex["z"]])
        assert np.array_equal(xyz, source), "points leave in the source's order"
        assert (vertex["label"][3000:] > 0).mean() > 0.95
        assert (vertex["label"][:3000] > 0).mean() < 0.01
    capsys.readouterr()
    assert run("export", sequence, "--format", "semantickitti", "--out", tmp_path / "kitti") == 0
    printed = capsys.readouterr()
    assert "SemanticKITTI does not hold: provenance, colours" in printed.out
    assert "without a category, each a class of its own in the export: ball" in printed.err
    about = json.loads((tmp_path / "kitti" / "export.json").read_text())
    assert "colours" in about["cannot_hold"]
    first = np.fromfile(next((tmp_path / "kitti").glob("**/000000.label")), np.uint32)
    assert len(first) == 3500
    assert (first[3000:] >> 16 > 0).all(), "instance in the upper half"
    assert (first[3000:] & 0xFFFF > 0).all(), "category in the lower half"
    palette = json.loads(next((tmp_path / "kitti").glob("**/palette.json")).read_text())
    assert "ball" in json.dumps(palette)
    training = ["export", sequence, "--format", "openpcdet", "--out", tmp_path / "training"]
    assert run(*training, "--val", "1:3") == 0
    split = json.loads((tmp_path / "training" / "export.json").read_text())["split"]
    assert (len(split["train"]), len(split["val"])) == (1, 2)
    assert run("check") == 0


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["import", "nowhere"], "nowhere"),
        (["info", "nothing"], "nothing"),
        (["export", "nothing", "--format", "ply", "--out", "x"], "nothing"),
        (["track", "nothing", "--from", 0, "--to", 1], "nothing"),
        (["token", "add", "me", "--role", "king"], "king"),
    ],
)
def test_what_fails_says_so_in_one_line(
    arguments: list[object], says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings_in(tmp_path)
    assert run(*arguments) == 1
    error = capsys.readouterr().err.strip().splitlines()
    assert len(error) == 1
    assert says in error[0]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ("fly", "fly"),
        ("import", "PATH"),
        ("import x --fps -1", "expected a number above 0, got '-1'"),
        ("import x --fps fast", "expected a number above 0, got 'fast'"),
        ("serve --port 99999", "expected an integer from 0 to 65535, got 99999"),
        ("serve --workers 0", "expected an integer from 1, got 0"),
        ("demo --sample-frames 0", "expected an integer from 1, got '0'"),
        ("track x --from -1 --to 2", "expected a frame number from 0, got '-1'"),
        ("review x --port 0", "expected a port from 1 to 65535, got '0'"),
    ],
)
def test_a_usage_error_exits_with_two(
    arguments: str, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as caught:
        main(arguments.split())
    assert caught.value.code == 2
    assert says in capsys.readouterr().err


def bad_files(folder: Path) -> Iterator[tuple[str, Path]]:
    good = np.zeros((10, 3), np.float32)
    empty = folder / "empty.ply"
    empty.write_bytes(b"")
    yield "empty", empty
    truncated = folder / "truncated.npy"
    np.save(truncated, good)
    truncated.write_bytes(truncated.read_bytes()[:-17])
    yield "truncated", truncated
    nan = folder / "nan.npy"
    np.save(nan, np.where(np.arange(10)[:, None] == 4, np.nan, good))
    yield "NaN", nan
    mixed = folder / "mixed"
    mixed.mkdir()
    np.save(mixed / "a.npy", good)
    (mixed / "b.xyz").write_text("0 0 0\n1 1 1\n")
    yield "mixed", mixed


def test_each_in_a_folder_becomes_a_recording_of_a_project(
    recording: Path, workspace: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with closing(Workspace(Settings(workspace=workspace))) as opened:
        opened.labels.team.projects.create("night", ProjectPatch("Night"))
    drives = tmp_path / "drives"
    (drives / "drive 2").mkdir(parents=True)
    for place in (drives / "drive 2" / "0.npz", drives / "drive 10.npz"):
        place.write_bytes((recording / "0.npz").read_bytes())
    assert run("import", drives, "--each", "--name", "one") == 1
    assert run("import", drives, "--each", "--project", "night") == 0
    assert "drive-10" in capsys.readouterr().out
    with closing(Workspace(Settings(workspace=workspace))) as opened:
        assert opened.labels.team.projects.get("night").recordings == ("drive-10", "drive-2")


def test_bad_recordings_are_refused_and_leave_nothing(
    tmp_path: Path, workspace: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, path in bad_files(tmp_path):
        assert run("import", path) == 1, name
        error = capsys.readouterr().err
        assert "expected" in error, f"{name}: {error}"
        assert "Traceback" not in error
        assert list((workspace / "sequences").iterdir()) == [], name


def test_frames_may_differ_in_size(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "sizes"
    folder.mkdir()
    for i, n in enumerate((5, 1, 300)):
        np.save(folder / f"{i}.npy", np.random.default_rng(i).normal(size=(n, 3)))
    assert run("import", folder) == 0
    assert run("info", "sizes") == 0
    assert "1 to 300 a frame" in capsys.readouterr().out


def test_backup_and_restore(
    workspace: Path, recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert run("import", recording) == 0
    painted(workspace)
    assert run("backup", tmp_path / "backup") == 0
    assert run("backup", tmp_path / "backup") == 1, "an existing folder is never overwritten"
    monkeypatch.setenv("POINTBRUSH_WORKSPACE", str(tmp_path / "restored"))
    assert run("restore", tmp_path / "backup") == 0
    assert run("check") == 0
    assert run("export", "moving-ball", "--format", "npz", "--out", tmp_path / "out") == 0
    first = np.load(sorted((tmp_path / "out").glob("**/*.npz"))[0])
    assert (first["label"] > 0).sum() == 500


def test_check_finds_a_flipped_byte(
    workspace: Path, recording: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("import", recording) == 0
    largest = max((workspace / "sequences").glob("**/*"), key=lambda p: p.stat().st_size)
    data = bytearray(largest.read_bytes())
    data[len(data) // 2] ^= 1
    largest.write_bytes(data)
    assert run("check") == 1
    assert largest.name in capsys.readouterr().out


def test_answers_come_as_json_too(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def answer(*arguments: object) -> Any:
        assert run(*arguments, "--json") == 0
        return json.loads(capsys.readouterr().out)

    assert answer("import", recording, "--dry-run")["frames"] == 3
    assert answer("import", recording, "--fps", 10)["sequence"] == "moving-ball"
    (listed,) = answer("info")
    assert (listed["id"], listed["frames"], listed["points"]) == ("moving-ball", 3, [3500] * 3)
    assert answer("info", "moving-ball")["labels"] == []
    assert answer("labels", "moving-ball") == []
    assert answer("rename", "moving-ball", "A ball")["name"] == "A ball"
    assert answer("info", "A ball")["name"] == "A ball"
    assert answer("token", "list") == []
    assert answer("check")["problems"] == []
    assert answer("delete", "moving-ball") == {"sequence": "moving-ball"}
    assert answer("info") == []
    assert answer("undelete", "moving-ball") == {"sequence": "moving-ball"}
    assert [each["id"] for each in answer("info")] == ["moving-ball"]


def test_check_labels_fails_where_something_is_suspicious(
    workspace: Path, recording: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("import", recording) == 0
    with closing(Workspace(Settings(workspace=workspace))) as opened:
        opened.labels.create_label("moving-ball", "me", name="ball")
    capsys.readouterr()
    assert run("check-labels", "moving-ball") == 0
    assert "ball" in capsys.readouterr().out
    assert run("check-labels", "moving-ball", "--fail") == 1
    printed = capsys.readouterr()
    assert "ball" in printed.out
    assert printed.err == "pointbrush: 1 suspicious\n"


def test_labels_are_listed_with_their_points(
    workspace: Path, recording: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("import", recording) == 0
    painted(workspace)
    capsys.readouterr()
    assert run("labels", "moving ball") == 0
    assert capsys.readouterr().out.split("\t")[2::2] == ["ball", "500\n"]
    assert run("labels", "moving-ball", "--json") == 0
    assert [each["points"] for each in json.loads(capsys.readouterr().out)] == [500]


def test_a_name_that_several_recordings_have_is_refused_with_their_ids(
    recording: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for _ in range(2):
        assert run("import", recording, "--name", "Ball") == 0
    capsys.readouterr()
    assert run("labels", "Ball") == 1
    assert "expected the name of one recording, got the name of ball, ball-2" in (
        capsys.readouterr().err
    )
    assert run("labels", "ball-2") == 0


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
def test_a_shell_completes_commands_and_flags(
    shell: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("completion", shell) == 0
    script = capsys.readouterr().out
    assert "check-labels" in script
    assert "wrong-tokens-per-minute" in script


def test_help_of_serve_is_in_groups(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        run("serve", "--help")
    printed = capsys.readouterr().out
    heads = [line for line in printed.splitlines() if line.endswith(":") and line[0] != " "]
    assert heads == [
        "options:",
        "workspace:",
        "storage:",
        "address and TLS:",
        "access:",
        "work:",
        "backups:",
        "limits:",
    ]


def test_tokens_are_added_listed_and_revoked(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("token", "add", "Ada", "--role", "annotator", "--days", 7) == 0
    secret = capsys.readouterr().out.strip()
    assert run("token", "list") == 0
    listed = capsys.readouterr().out
    assert "Ada" in listed
    assert secret not in listed, "secrets are shown once"
    assert run("token", "revoke", listed.split()[0]) == 0
    assert run("token", "list") == 0
    assert "revoked" in capsys.readouterr().out


HEAVY = (
    "numpy", "scipy", "numba", "sqlalchemy", "psycopg", "pydantic", "fastapi", "uvicorn", "viser",
    "PIL", "tqdm", "pointbrush.tracking", "pointbrush.streaming", "pointbrush.web",
    "pointbrush.review", "pointbrush.samples", "pointbrush.work.reviewing",
    "pointbrush.formats.registry", "pointbrush.formats.writers",
)  # fmt: skip
"""Packages that take their time to import."""
STORED = ("numpy", "sqlalchemy")
"""Those that reading a workspace needs; a tuple, since sets name tests in any order."""


@pytest.mark.parametrize(
    ("command", "may"),
    [
        (["--help"], ()),
        (["serve", "--help"], ()),
        (["info"], STORED),
        (["token", "list"], STORED),
        (["export", "none", "--format", "ply", "--out", "out"], STORED),
        (["report", "none", "--out", "out.csv"], (*STORED, "pointbrush.work.reviewing")),
        (["check"], STORED),
    ],
    ids=" ".join,
)
def test_a_command_imports_nothing_that_it_does_not_need(
    tmp_path: Path, command: list[str], may: tuple[str, ...]
) -> None:
    code = (
        "import contextlib, sys\n"
        "from pointbrush.cli import main\n"
        "with contextlib.suppress(SystemExit):\n"
        "    main(sys.argv[1:])\n"
        f"print([name for name in {HEAVY} if name in sys.modules])"
    )
    workspace = settings_in(tmp_path).workspace
    place = [] if "--help" in command else ["--workspace", str(workspace)]
    line = [sys.executable, "-c", code, *command, *place]
    found = subprocess.run(line, capture_output=True, text=True, check=True)
    imported = set(ast.literal_eval(found.stdout.splitlines()[-1]))
    assert imported <= set(may), found.stderr


def test_a_server_listens_without_what_only_some_of_its_work_needs() -> None:
    rare = ("scipy", "numba", "psycopg", "segno", "cryptography", "viser", "pointbrush.review",
            "pointbrush.samples.generating", "pointbrush.tracking.tracker")  # fmt: skip
    code = f"import sys, pointbrush.web.server; print([n for n in {rare} if n in sys.modules])"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ast.literal_eval(found.stdout) == []
