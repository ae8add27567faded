"""Commands on the workspace of a server: the same lines as on one of this machine."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Iterator
from inspect import signature
from pathlib import Path

import numpy as np
import pytest

from pointbrush.cli import main, parser
from pointbrush.client import Client
from pointbrush.commands.grammar import VERBS
from pointbrush.settings.command_sets import CLIENTS, LOCAL, REMOTE, SERVERS
from tests.serving import TOKEN, Served, serving, settings_in


@pytest.fixture
def served(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Served]:
    monkeypatch.setenv("POINTBRUSH_WORKSPACE", str(tmp_path / "here"))
    with serving(settings_in(tmp_path / "there")) as running:
        yield running


def drift(folder: Path) -> Path:
    folder.mkdir()
    cube = np.random.default_rng(0).uniform(-0.1, 0.1, (2000, 3))
    for i in range(3):
        np.save(folder / f"{i}.npy", (cube + [0.01 * i, 0, 2]).astype(np.float32))
    return folder


def test_the_whole_way_on_a_server(
    served: Served,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setenv("POINTBRUSH_SERVER", served.url)
    monkeypatch.setenv("POINTBRUSH_TOKEN", TOKEN)

    def run(*arguments: object) -> str:
        assert main([str(argument) for argument in arguments]) == 0, capsys.readouterr().err
        return capsys.readouterr().out

    folder = drift(tmp_path / "drift")
    assert "frames     3, by number" in run("import", folder, "--dry-run")
    assert run("info") == ""
    imported = run("import", folder, "--fps", "5").splitlines()
    assert imported[0] == "imported drift: 3 frames, 6,000 points"
    assert imported[1] == "up is -y, guessed from the points; --up changes it"
    assert run("info").startswith("drift\t3 frames\t5 fps\t6,000 points")
    np.full(2000, 40, "<u4").tofile(tmp_path / "000000.label")
    named = tmp_path / "names.txt"
    named.write_text("40 cube\n")
    labels = ("import-labels", "drift", tmp_path / "000000.label", "--map", named)
    assert "found 2,000 labelled points in 1 of 3 frames" in run(*labels, "--dry-run")
    assert "imported 2,000" in run(*labels)
    np.zeros(2000, "<u4").tofile(tmp_path / "000001.label")
    empty = ("import-labels", "drift", tmp_path / "000001.label")
    for more in ([], ["--dry-run"]):
        assert main([str(word) for word in (*empty, *more)]) == 1
        assert "expected some labelled points or boxes, got none" in capsys.readouterr().err
        assert "0 labelled points in 1 of 3 frames" in run(*empty, "--allow-empty", *more)
    assert "cube" in run("info", "drift")
    tracked = run("track", "drift", "--from", 0, "--to", 2, "--labels", "cube", "--method", "icp")
    assert tracked.startswith("tracked 3 frames, 4,000 points")
    run("export", "drift", "--format", "semantickitti", "--out", tmp_path / "out")
    assert len(list((tmp_path / "out").rglob("*.label"))) == 3
    run("export", "drift", "--format", "npz", "--out", tmp_path / "out.zip", "--frames", "0:1")
    assert (tmp_path / "out.zip").read_bytes().startswith(b"PK")
    with Client(served.url, TOKEN) as client:
        client.projects["default"].snapshot("As imported")
        client["drift"].frames[1].clear([label.id for label in client["drift"].labels()])
    was = ("export", "drift", "--format", "npz", "--frames", "1:2", "--out")
    run(*was, tmp_path / "now.zip")
    run(*was, tmp_path / "then", "--snapshot", "As imported")
    run(*was, tmp_path / "then.zip", "--snapshot", "as-imported")
    then = dict(np.load(next((tmp_path / "then").rglob("*.npz"))))
    assert then["label"].any()
    with (
        zipfile.ZipFile(tmp_path / "now.zip") as now,
        zipfile.ZipFile(tmp_path / "then.zip") as old,
    ):
        name = next(each for each in now.namelist() if each.endswith(".npz"))
        assert not np.load(io.BytesIO(now.read(name)))["label"].any()
        assert np.array_equal(np.load(io.BytesIO(old.read(name)))["label"], then["label"])
    training = ("export", "drift", "--format", "pointcept", "--out", tmp_path / "training")
    run(*training, "--val", "2:3")
    assert len(list((tmp_path / "training" / "val").iterdir())) == 1
    assert run("report", "drift", "--out", tmp_path / "drift.html").startswith("wrote")
    assert "suspicious" in run("check-labels", "drift")
    assert "source     drift\n" in run("info", "drift"), "no path of the server's"
    assert run("labels", "drift").split("\t")[2::2] == ["cube", "4000\n"]
    run("rename", "drift", "Drifting cube")
    assert json.loads(run("info", "--json"))[0]["name"] == "Drifting cube"
    assert [each["points"] for each in json.loads(run("labels", "Drifting cube", "--json"))] == [
        4000
    ]
    run("delete", "drift")
    assert run("info") == ""
    assert run("undelete", "drift") == "restored drift\n"
    assert not (tmp_path / "here").exists()


COMMANDS = {
    "import": "import FILES",
    "import-labels": "import-labels drift FILES",
    "track": "track drift --from 0 --to 1",
    "fit-boxes": "fit-boxes drift",
    "find-people": "find-people drift",
    "align-sensors": "align-sensors drift",
    "example": "example",
    "export": "export drift --format npz --out OUT/export",
    "info": "info",
    "labels": "labels drift",
    "delete": "delete drift",
    "undelete": "undelete drift",
    "rename": "rename drift other",
    "check-labels": "check-labels drift",
    "compare": "compare drift drift",
    "report": "report drift --out OUT/report.csv",
    "project": "project list",
    "task": "task list",
    "webhook": "webhook list",
    "undo": "undo drift",
    "token": "token list",
    "check": "check",
    "backup": "backup OUT/backup",
    "restore": "restore FILES",
    "review": "review drift",
    "move": "move sqlite",
}
"""A line of each command that works on a workspace, but those that serve one."""
OTHERS = {"demo", "serve", "headset-report", "completion", "bench"}


def lines(tmp_path: Path) -> dict[str, list[str]]:
    files = drift(tmp_path / "files")
    places = {"FILES": str(files), "OUT": str(tmp_path)}
    return {
        name: [places.get(part, part).replace("OUT/", f"{tmp_path}/") for part in line.split()]
        for name, line in COMMANDS.items()
    }


def test_each_command_has_a_place_to_work() -> None:
    (names,) = (each.choices for each in parser()._actions if isinstance(each.choices, dict))
    assert set(names) == COMMANDS.keys() | OTHERS
    places = {each.name: [*signature(each.run).parameters.values()][1].annotation for each in VERBS}
    assert {name for name, place in places.items() if place == "Place"} == {*REMOTE}
    assert {name for name, place in places.items() if place == "Client"} == {*CLIENTS} - {*REMOTE}
    assert {name for name, place in places.items() if place == "LocalClient"} == {*LOCAL, *SERVERS}
    assert COMMANDS.keys() == {*CLIENTS, *LOCAL}


@pytest.mark.parametrize("command", COMMANDS)
def test_where_there_is_a_server_no_command_works_here_unasked(
    command: str,
    served: Served,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.delenv("POINTBRUSH_WORKSPACE")
    monkeypatch.setenv("POINTBRUSH_SERVER", served.url)
    monkeypatch.setenv("POINTBRUSH_TOKEN", TOKEN)
    (tmp_path / "cwd").mkdir()
    monkeypatch.chdir(tmp_path / "cwd")
    code, printed = main(lines(tmp_path)[command]), capsys.readouterr()
    if command in LOCAL:
        assert code == 1
        assert printed.err == (
            f"pointbrush: pointbrush {command} works on a workspace's folder; POINTBRUSH_SERVER is "
            "set: unset it or give --workspace\n"
        )
    elif "drift" in COMMANDS[command]:
        assert "drift" in printed.err  # the server has no such recording
    else:
        assert code == 0, printed.err
    assert list((tmp_path / "cwd").iterdir()) == []


@pytest.mark.parametrize("command", sorted(COMMANDS.keys() - {"import", "restore"}))
def test_a_command_that_reads_makes_no_workspace(
    command: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    for name in ("SERVER", "WORKSPACE"):
        monkeypatch.delenv(f"POINTBRUSH_{name}", raising=False)
    line = lines(tmp_path)[command]
    (tmp_path / "cwd").mkdir()
    monkeypatch.chdir(tmp_path / "cwd")
    assert main(line) == 1
    error = capsys.readouterr().err
    wanted = (
        "give --server URL" if command in {*CLIENTS} - {*REMOTE} else "expected a folder with a"
    )
    assert (error.count("\n"), wanted in error) == (1, True), error
    assert list((tmp_path / "cwd").iterdir()) == []
    assert {path.name for path in tmp_path.iterdir()} == {"cwd", "files"}


def test_the_flag_of_a_workspace_wins_over_the_servers_variable(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("POINTBRUSH_SERVER", "http://127.0.0.1:9")
    here = ("--workspace", str(settings_in(tmp_path).workspace))
    assert main(["token", "list", *here]) == 0
    assert main(["info", *here]) == 0
    capsys.readouterr()
    assert main(["info", *here, "--server", "http://127.0.0.1:9"]) == 1
    assert "--server: expected no --workspace" in capsys.readouterr().err


def test_tokens_of_a_server(
    served: Served, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("POINTBRUSH_SERVER", served.url)
    monkeypatch.setenv("POINTBRUSH_TOKEN", TOKEN)

    def run(line: str) -> str:
        assert main(line.split()) == 0, capsys.readouterr().err
        return capsys.readouterr().out.strip()

    secret = run("token add ida --role reviewer --days 7")
    with Client(served.url, secret) as client:
        assert client.call("GET", "/session").json() == {"author": "ida", "role": "reviewer"}
    (row,) = [line for line in run("token list").splitlines() if "\tida\t" in line]
    token, *told = row.split("\t")
    assert told == ["reviewer", "ida", "valid"]
    run(f"token revoke {token}")
    assert f"{token}\treviewer\tida\trevoked" in run("token list")
    for wrong, words in (
        ("token revoke 00000000", "expected the id of a token, got '00000000'"),
        ("token add", "name: expected a value, got none"),
        ("token add ida --role king", "role"),
    ):
        assert main(wrong.split()) == 1
        assert words in capsys.readouterr().err


def test_projects_tasks_webhooks_and_undo_of_a_server(
    served: Served,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setenv("POINTBRUSH_SERVER", served.url)
    monkeypatch.setenv("POINTBRUSH_TOKEN", TOKEN)

    def run(line: str) -> str:
        assert main(line.split()) == 0, capsys.readouterr().err
        return capsys.readouterr().out

    assert run("project add Night") == "added project night\n"
    assert "night\tadmin\t0\tNight" in run("project list")
    run(f"import {drift(tmp_path / 'drift')} --project night --name Drift")
    line = "task add Drift --project night --every 2 --assignee ada"
    assert main(line.split()) == 0
    printed = capsys.readouterr()
    assert "no account is called 'ada'" in printed.err
    added = printed.out.splitlines()
    assert [line.split("\t")[1:3] for line in added] == [["drift", "0:2"], ["drift", "2:3"]]
    assert run("task list --project night --state open --assignee ada").splitlines() == added
    numbers = " ".join(line.split("\t")[0] for line in added)
    run(f"task delete {numbers} --project night")
    assert json.loads(run("task list --project night --json")) == []
    made = json.loads(run("webhook add https://1.1.1.1/hook --topics task,job --json"))
    assert run("webhook list") == f"{made['id']}\ttask,job\thttps://1.1.1.1/hook\n"
    run(f"webhook delete {made['id']}")
    assert run("webhook list") == ""
    with Client(served.url, TOKEN) as client:
        recording = client["drift"]
        label = recording.create_label("cube")
        recording.frames[0].stroke(label=label.id, radius=9.0, samples=[[0, 0, 2]])
    assert run("undo Drift") == "undid your last edit of drift: 2,000 points changed\n"
    run("delete drift")
    run("project delete night")
    assert "night" not in run("project list")
    for wrong, words in (
        ("task delete first", "expected the number of a task, got 'first'"),
        ("task delete", "task: expected a value, got none"),
        ("project add", "project: expected a value, got none"),
        ("webhook add", "webhook: expected a value, got none"),
    ):
        assert main(wrong.split()) == 1
        assert words in capsys.readouterr().err


def test_a_job_of_a_server_draws_no_bar_into_a_log(
    served: Served,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setenv("POINTBRUSH_SERVER", served.url)
    monkeypatch.setenv("POINTBRUSH_TOKEN", TOKEN)
    with Client(served.url, TOKEN) as client:
        recording = client.import_files(drift(tmp_path / "drift"), progress=True)
        label = recording.create_label("cube")
        recording.frames[0].stroke(label=label.id, radius=9.0, samples=[[0, 0, 2]])
    assert main(["fit-boxes", "drift"]) == 0
    printed = capsys.readouterr()
    assert "\r" not in printed.err
    assert printed.out == "fitted 1 box\n"


def test_what_is_wrong_is_one_line(
    served: Served, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    printed = f"{served.url}/?token={TOKEN}"
    with Client(served.url, TOKEN) as client:
        client.import_files([drift(tmp_path / "drift")])
    assert main(["info", "--server", printed]) == 0
    full = tmp_path / "full"
    full.mkdir()
    (full / "kept").write_text("mine")
    export = ["export", "drift", "--format", "npz", "--out", str(full)]
    wrong = {
        "expected one for the server": ["info", "--server", served.url],
        "expected http": ["info", "--server", "example"],
        "nothing": ["info", "nothing", "--server", printed],
        "new or empty": [*export, "--server", printed],
        "names or ids": [
            *("track", "drift", "--from", "0", "--to", "1"),
            *("--labels", "cube", "--server", printed),
        ],
    }
    for sentence, arguments in wrong.items():
        assert main(arguments) == 1
        error = capsys.readouterr().err
        assert (error.count("\n"), sentence in error) == (1, True), error
    assert (full / "kept").read_text() == "mine"
