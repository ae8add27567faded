"""A whole study over REST: two simulated participants, its results, replays and deletion."""

from __future__ import annotations

import asyncio
import csv
import io
import json
import threading
import uuid
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pyarrow.parquet as parquet
import pytest
from sqlalchemy import select
from websockets.exceptions import ConnectionClosed, InvalidStatus

from pointbrush.accounts.accounts import digest_of
from pointbrush.client import Client
from pointbrush.database.schema import metadata
from pointbrush.errors import BadInputError, ConflictError, NotFoundError, PointbrushError
from pointbrush.settings import Settings
from pointbrush.web.problems import loggable
from pointbrush.work.projects.copies import make_copy
from pointbrush.work.studies import service
from pointbrush.work.studies.files import StudyFiles
from tests.serving import Served, add_sequence, serving, settings_in
from tests.streaming.acting import run
from tests.streaming.client import viewer
from tests.waiting import PATIENCE

API = "/api/v1"
FRAMES = range(1, 3)
LEVELS = (0.8, 0.9)
STUDY: dict[str, Any] = {
    "title": "Two halves",
    "consent": "We log what you do.",
    "conditions": [
        {"name": "desk", "input": "mouse"},
        {"name": "room", "device": "headset", "input": "controller"},
    ],
    "tasks": [
        {"name": "halves", "recording": "wall", "frames": "1:3", "labels": ["left", "right"],
         "time_limit_s": 600, "instructions": "Label both halves."},
        {"name": "try", "recording": "wall", "frames": "0:1", "labels": ["left"], "practice": True,
         "stop": "iou", "target_iou": 0.75},
    ],
    "questionnaires": [
        {"name": "sus", "scoring": "sus"},
        {"name": "tlx", "scoring": "tlx"},
        {"name": "end", "after": "study", "items": [{"text": "Which?", "steps": 7}]},
    ],
}  # fmt: skip


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving_wall(settings_in(tmp_path_factory.mktemp("studies"), max_body=400_000)) as running:
        yield running


@contextmanager
def serving_wall(settings: Settings) -> Iterator[Served]:
    """A server with the recording ``wall``, of which a half is "left" and the other "right"."""
    add_sequence(settings, "wall", frames=4, points=3_000)
    with serving(settings) as running:
        with Client(running.url, running.token) as client:
            wall = client["wall"]
            left, right = (wall.create_label(name).id for name in ("left", "right"))
            for frame in wall.frames:
                x = frame.points()["xyz"][:, 0]
                frame.annotate(np.where(x < 0, left, right).astype(np.uint16))
        yield running


@pytest.fixture(scope="module")
def lead(server: Served) -> Iterator[Client]:
    with Client(server.url, server.workspace.labels.tokens.add("manager", "lead")) as opened:
        yield opened


def ask(lead: Client, method: str, path: str = "", body: Any = None) -> Any:
    """Make a call of the experimenter below ``/studies``; return its answer, as JSON if it is."""
    answer = lead.call(method, f"/studies{path}", json=body)
    is_json = answer.content and answer.headers["content-type"] == "application/json"
    return answer.json() if is_json else answer.content


@dataclass
class Person:
    """A simulated participant, who keeps their own account of what happened."""

    http: httpx.Client
    code: str
    lead: Client
    forgets: bool = False
    """One stroke has no record in the log."""
    seen: list[dict[str, Any]] = field(default_factory=list)
    curves: dict[tuple[str, str], list[tuple[float, float]]] = field(default_factory=dict)
    logged: int = 0

    def call(self, method: str, path: str, body: Any = None) -> httpx.Response:
        return self.http.request(method, f"{API}{path}", json=body)

    def step(self, number: int | None = None, **more: Any) -> dict[str, Any]:
        path = f"/study/{self.code}/step"
        body = {"number": number} | more
        answer = self.call("GET", path) if number is None else self.call("POST", path, body)
        assert answer.status_code == 200, answer.text
        found: dict[str, Any] = answer.json()
        return found

    def log(self, *records: dict[str, Any], first: int | None = None) -> httpx.Response:
        begin = self.logged if first is None else first
        answer = self.call("POST", f"/study/{self.code}/log", {"first": begin, "records": records})
        if answer.status_code == 200:
            self.logged = answer.json()["next"]
        return answer

    def run(self, until: str = "done") -> dict[str, Any]:
        """Go through all steps, or until one of a kind; return it."""
        step = self.step()
        while step["kind"] != until:
            self.seen.append(step)
            answers: list[int] = []
            if step["kind"] in ("practice", "task"):
                self.work(step)
            if step["kind"] == "questionnaire":
                answers = [1 + n % item["steps"] for n, item in enumerate(items_of(step))]
            step = self.step(step["number"], answers=answers)
        return step

    def work(self, step: dict[str, Any]) -> None:
        """Paint one label, then a wrong stroke that is undone, then the others."""
        number, frames = step["number"], range(step["start"], step["stop"])
        key = step["condition"]["name"], step["task"]["name"]
        curve = self.curves[key] = [(0.0, self.iou(step))]
        self.log({"kind": "phase", "step": number, "t": 500, "phase": "painting"})
        t = 1000.0
        for label in step["labels"]:
            for frame in frames:
                edit = self.stroke(step["sequence"], frame, label, sign=label - 1.5)
                if not (self.forgets and step["kind"] == "task"):
                    self.log(stroke(number, t, edit, label, frame))
                    curve.append((t / 1000, self.iou(step)))
                self.forgets &= step["kind"] != "task"
                t += 1000
        wrong = self.stroke(step["sequence"], frames[0], step["labels"][0], sign=0.5)
        self.log(stroke(number, t, wrong, step["labels"][0], frames[0]))
        curve.append((t / 1000, self.iou(step)))
        assert self.call("POST", f"/sequences/{step['sequence']}/undo").status_code == 200
        self.log(
            {"kind": "undo", "step": number, "t": t + 250.0},
            {"kind": "pose", "step": number, "t": t + 300.0, "head": [0, 0, 0, 0, 0, 0, 1]},
            {"kind": "pose", "step": number, "t": t + 333.5, "head": [3, 4, 0, 0, 0, 0, 1],
             "right": [1, 1, 1, 0, 0, 0, 1]},
            {"kind": "pose", "step": number, "t": t + 366.5, "head": [3, 4, 2, 0, 0, 0, 1]},
            {"kind": "device", "step": number, "t": t + 370, "profile": {"gpu": "none"}},
        )  # fmt: skip
        curve.append((t / 1000 + 0.25, self.iou(step)))
        reached = step["kind"] == "practice"
        assert (step["reached"], self.step()["reached"]) == (False, reached)

    def stroke(self, sequence: str, frame: int, label: int, sign: float) -> str:
        """Paint most points of a half."""
        edit = str(uuid.uuid4())
        answer = self.call("POST", f"/sequences/{sequence}/frames/{frame}/strokes", {
            "id": edit, "label": label, "radius": 5.95,
            "samples": [{"origin": [sign * 12, 0, 3], "direction": [0, 0, -1], "t": 0}],
        })  # fmt: skip
        assert answer.status_code == 200, answer.text
        return edit

    def iou(self, step: dict[str, Any]) -> float:
        """Return the mean IoU of the exported labels, computed here."""
        copy, wall = self.lead[step["sequence"]], self.lead["wall"]
        pairs = [
            (copy.frames[n].annotation(), wall.frames[n].annotation())
            for n in range(step["start"], step["stop"])
        ]
        own, true = (np.concatenate(each) for each in zip(*pairs, strict=True))
        found = []
        for label in step["labels"]:
            both, any_ = (own == label) & (true == label), (own == label) | (true == label)
            found.append(both.sum() / any_.sum())
        return float(np.mean(found))


def items_of(step: dict[str, Any]) -> list[dict[str, Any]]:
    items: list[dict[str, Any]] = step["questionnaire"]["items"]
    return items


def stroke(step: int, t: float, edit: str, label: int, frame: int) -> dict[str, Any]:
    return {
        "kind": "stroke", "step": step, "t": t, "id": edit, "tool": "paint", "shape": "sphere",
        "label": label, "frame": frame,
    }  # fmt: skip


@pytest.fixture(scope="module")
def people(server: Served, lead: Client) -> Iterator[list[Person]]:
    """Two participants who have finished the study; the log of the second misses a stroke."""
    ask(lead, "POST", body={"text": json.dumps(STUDY), "id": "halves"})  # JSON is YAML
    made = ask(lead, "POST", "/halves/participants", {"count": 2})
    assert [each["conditions"] for each in made] == [["desk", "room"], ["room", "desk"]]
    assert made[0]["link"] == f"{server.url}/study/{made[0]['code']}"
    found = [enter(server, lead, each, forgets=each["number"] == 2) for each in made]
    pause_and_refuse(lead, found[0])
    for person in found:
        person.run()
    yield found
    for person in found:
        person.http.close()


def enter(server: Served, lead: Client, added: dict[str, Any], **fields: Any) -> Person:
    """Exchange a participant's code for the cookie."""
    http = httpx.Client(base_url=server.url)
    entered = http.post(f"{API}/study/{added['code']}")
    assert (entered.status_code, entered.json()["kind"]) == (200, "consent")
    return Person(http, added["code"], lead, **fields)


def pause_and_refuse(lead: Client, person: Person) -> None:
    """Pause a session, and send logs with a gap and with changed records."""
    person.step(0)
    path = "/halves/participants"
    assert ask(lead, "PATCH", f"{path}/1", {"paused": True})["state"] == "paused"
    paused = [person.step() for _ in range(2)]
    assert [each["kind"] for each in paused] == ["pause", "pause"]
    assert paused[0]["elapsed_s"] == paused[1]["elapsed_s"]
    refused = person.call("POST", f"/study/{person.code}/step", {"number": 1})
    assert (refused.status_code, "paused" in refused.text) == (409, True)
    assert ask(lead, "PATCH", f"{path}/{person.code}", {"paused": False})["state"] == "running"
    before = person.step()
    assert (before["kind"], before["condition"]["name"]) == ("instructions", "desk")
    assert person.step(0)["number"] == before["number"]  # a repeated call has no effect
    records = [{"kind": "label", "step": 1, "t": n, "label": n} for n in range(3)]
    assert person.log(*records).json() == {"next": 3}
    assert person.log(*records[1:], first=1).json() == {"next": 3}
    gap = person.log(records[0], first=5)
    assert gap.status_code == 409
    assert "expected record 3 next, got 5: records 3 to 4 are missing" in gap.text
    other = person.log(records[0], first=1)
    assert (other.status_code, "record 1 is stored with other content" in other.text) == (409, True)


def rows_of(table: bytes) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(table.decode())))


def test_steps_lead_through_practice_tasks_and_questionnaires(people: list[Person]) -> None:
    kinds = [(each["kind"], (each["task"] or {}).get("name")) for each in people[1].seen]
    condition = [
        ("instructions", None), ("instructions", "try"), ("practice", "try"),
        ("instructions", "halves"), ("task", "halves"), ("questionnaire", None),
        ("questionnaire", None),
    ]  # fmt: skip
    assert kinds == [("consent", None), *condition, *condition, ("questionnaire", None)]
    asked = [each["questionnaire"]["name"] for each in people[1].seen if each["questionnaire"]]
    assert asked == ["sus", "tlx", "sus", "tlx", "end"]
    copies = {each["sequence"] for person in people for each in person.seen} - {None}
    assert len(copies) == 8  # of each task in each condition, each without labels at first
    assert all(curve[0] == (0.0, 0.0) for person in people for curve in person.curves.values())


def test_results_equal_numbers_computed_from_exports(people: list[Person], lead: Client) -> None:
    info = ask(lead, "GET", "/halves")
    assert (info["participants"], info["done"]) == (2, 2)
    rows = rows_of(ask(lead, "GET", "/halves/results"))
    curves = rows_of(ask(lead, "GET", "/halves/results?table=curves"))
    assert [(each["participant"], each["condition"], each["task"]) for each in rows] == [
        ("1", "desk", "halves"), ("1", "room", "halves"),
        ("2", "room", "halves"), ("2", "desk", "halves"),
    ]  # fmt: skip
    for row in rows:
        person = people[int(row["participant"]) - 1]
        expected = person.curves[row["condition"], row["task"]]
        names = ("participant", "condition", "task")
        mine = [each for each in curves if all(each[name] == row[name] for name in names)]
        own = [(float(each["t_s"]), float(each["iou"])) for each in mine]
        np.testing.assert_allclose(own, expected, rtol=0, atol=1e-12)
        assert float(row["iou"]) == pytest.approx(expected[-1][1], abs=1e-12)
        for level in LEVELS:
            at = next((t for t, iou in expected if iou >= level), None)
            assert row[f"time_to_{level * 100:.0f}_s"] == ("" if at is None else str(at))
        forgot = person is people[1] and row["condition"] == "room"
        assert (row["strokes"], row["undos"]) == ("4" if forgot else "5", "1")
        assert (row["head_m"], row["right_m"], row["left_m"]) == ("7.0", "", "")
        spent, duration = float(row["painting"]), float(row["duration_s"])
        assert spent == pytest.approx(max(0.0, duration - 0.5) / duration, abs=2e-3)
        # Answers 1 2 3 4 5 1 2 3 4 5: (0+3+2+1+4 + 4+1+2+3+0) 2.5 = 50, and 1 to 6 of 21 steps.
        assert (float(row["sus"]), float(row["tlx"])) == (50, pytest.approx(100 * 2.5 / 20))
        assert (row["sus_5"], row["tlx_6"], row["end_1"]) == ("5", "6", "1")
    table = parquet.read_table(io.BytesIO(ask(lead, "GET", "/halves/results?format=parquet")))
    assert [str(each["iou"]) for each in table.to_pylist()] == [each["iou"] for each in rows]


def test_the_log_and_the_report_are_files(people: list[Person], lead: Client) -> None:
    rows = rows_of(ask(lead, "GET", "/halves/participants/1/log"))
    assert [int(each["record"]) for each in rows] == [*range(people[0].logged)]
    poses = [each for each in rows if each["kind"] == "pose"]
    assert [poses[1][f"head_{axis}"] for axis in ("x", "y", "z", "qw")] == [
        "3.0",
        "4.0",
        "0.0",
        "1.0",
    ]
    assert (poses[0]["right_x"], poses[1]["right_x"], poses[1]["task"]) == ("", "1.0", "try")
    report = ask(lead, "GET", "/halves/report").decode()
    assert "<h1>Two halves</h1>" in report
    assert "room – desk" in report
    assert report.count("<svg") > 5


def test_replay_gives_the_labels_or_the_first_difference(
    people: list[Person], lead: Client
) -> None:
    first, second = (
        ask(lead, "POST", f"/halves/participants/{key}/replay") for key in (1, people[1].code)
    )
    assert first == {"equal": True, "edits": 2 * (3 + 6), "difference": ""}
    assert not second["equal"]
    assert second["difference"].startswith("room, halves: the log has no record of edit ")


def test_a_step_can_be_replayed_edit_by_edit(people: list[Person], server: Served) -> None:
    def get(path: str, **query: Any) -> httpx.Response:
        headers = {"Authorization": f"Bearer {server.token}"}
        answer = httpx.get(f"{server.url}{API}{path}", params=query, headers=headers)
        assert answer.status_code == 200, answer.text
        return answer

    steps = get("/studies/halves/participants/1/steps").json()
    assert [(each["condition"]["name"], each["task"]["name"]) for each in steps] == [
        ("desk", "try"), ("desk", "halves"), ("room", "try"), ("room", "halves"),
    ]  # fmt: skip
    log = get("/studies/halves/participants/1/log", format="json").json()
    assert len(log) == people[0].logged
    number, sequence = steps[1]["number"], steps[1]["sequence"]
    revisions = {
        each["id"]: each["revision"] for each in get(f"/sequences/{sequence}/edits").json()
    }
    mine = [each for each in log if each["step"] == number and each["kind"] == "stroke"]
    after = [0, *(revisions[each["id"]] for each in mine if each["frame"] == 1)]
    path = f"/sequences/{sequence}/frames/1/annotation"
    labels = [np.load(io.BytesIO(get(path, revision=each).content)) for each in after]
    assert not labels[0].any()
    assert [np.unique(each[each > 0]).tolist() for each in labels[1:3]] == [[1], [1, 2]]
    assert not np.array_equal(labels[2], labels[3])  # the wrong stroke, which was undone
    assert np.array_equal(labels[2], np.load(io.BytesIO(get(path).content)))


def test_a_code_reaches_its_own_copies_alone_until_the_end(
    people: list[Person], lead: Client, server: Served
) -> None:
    (added,) = ask(lead, "POST", "/halves/participants", {"count": 1})
    person = enter(server, lead, added)
    own, other = person.run("practice")["sequence"], people[1].seen[3]["sequence"]
    listed = [each["id"] for each in person.call("GET", "/sequences?copies=true").json()]
    assert listed == [own]
    for sequence in ("wall", other):
        assert person.call("GET", f"/sequences/{sequence}/labels").status_code == 404
        stroke_ = {"label": 1, "samples": []}
        refused = person.call("POST", f"/sequences/{sequence}/frames/0/strokes", stroke_)
        assert refused.status_code == 404
    for path in ("/studies", "/jobs", f"/sequences/{own}/export?format=ply", "/taxonomy"):
        assert person.call("GET", path).status_code == 403
    assert person.call("DELETE", f"/sequences/{own}").status_code == 403
    early = person.log({"kind": "undo", "step": 99, "t": 0})
    assert (early.status_code, "got 99" in early.text) == (422, True)
    path = f"{server.url}{API}/study/{person.code}/log"
    deep = httpx.post(path, content="[" * 100_000, headers={"Content-Type": "application/json"})
    assert (deep.status_code, "nested too deeply" in deep.text) == (400, True)
    wrong = httpx.get(f"{server.url}{API}/study/{'x' * 32}/step")
    assert (wrong.status_code, "code" in wrong.json()["detail"]) == (401, True)
    # Copies are in no list of others, and not in statistics.
    with Client(server.url, server.workspace.labels.tokens.add("annotator", "ann")) as ann:
        assert [each.id for each in ann.sequences()] == ["wall"]
        with pytest.raises(NotFoundError):
            ann[own]
    # The first has finished the study.
    done = people[0]
    assert done.call("GET", "/sequences?copies=true").json() == []
    assert done.call("GET", f"/sequences/{done.seen[3]['sequence']}/labels").status_code == 404
    run(lambda: over_the_socket(server, lead, (person.code, own), (done, other)))
    person.http.close()


async def over_the_socket(
    server: Served, lead: Client, running: tuple[str, str], others: tuple[Person, str]
) -> None:
    (code, own), (done, other) = running, others
    async with viewer(server.url, code) as socket:
        for sequence in ("wall", other):
            await socket.send(type="open", sequence=sequence)
            assert (await socket.until("error"))["status"] == 404
        assert (await socket.open(own))["id"] == own
        await asyncio.to_thread(ask, lead, "DELETE", f"/halves/participants/{code}")
        await socket.send(type="undo", id=str(uuid.uuid4()))
        with pytest.raises(ConnectionClosed):
            await socket.until("stroke_result")
    with pytest.raises(InvalidStatus, match="401"):
        await viewer(server.url, code).__aenter__()
    async with viewer(server.url, done.code) as socket:
        await socket.send(type="open", sequence=done.seen[3]["sequence"])
        assert (await socket.until("error"))["status"] == 404


def test_polls_do_not_wait_for_the_copy_of_another_participant(
    people: list[Person], lead: Client, server: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = ask(lead, "POST", "/halves/participants", {"count": 2})
    first, second = (enter(server, lead, each) for each in made)
    copying, go_on = threading.Event(), threading.Event()

    def slow_copy(*arguments: Any) -> str:
        if not copying.is_set():
            copying.set()
            assert go_on.wait(PATIENCE)
        return make_copy(*arguments)

    monkeypatch.setattr(service, "make_copy", slow_copy)
    waiting = threading.Thread(target=first.run, args=("practice",))
    waiting.start()
    try:
        assert copying.wait(PATIENCE)
        assert second.run("practice")["sequence"]
    finally:
        go_on.set()
        waiting.join()
    for person in (first, second):
        ask(lead, "DELETE", f"/halves/participants/{person.code}")
        person.http.close()


def test_a_wrong_token_is_not_looked_up_as_a_code(server: Served) -> None:
    look, asked = server.workspace.labels.database.look, list[str]()

    def counted(statement: Any, values: Any) -> Any:
        asked.append(str(values))
        return look(statement, values)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(server.workspace.labels.database, "look", counted)
        refused = httpx.get(f"{server.url}{API}/me", headers={"Authorization": "Bearer wrong"})
    assert (refused.status_code, len(asked)) == (401, 1)


def test_the_log_of_the_server_has_no_code(people: list[Person]) -> None:
    code = people[0].code
    for path in (
        f"/study/{code}",
        f"{API}/study/{code}/step",
        f"{API}/studies/s/participants/{code}",
    ):
        assert code not in loggable(path)
        assert loggable(path).startswith(path.partition(code)[0])


def test_invalid_studies_name_the_fault(lead: Client) -> None:
    for text, words in (
        ("title: [", "expected YAML"),
        ("title: &a T\nconsent: *a", "without aliases"),
        (json.dumps(STUDY | {"questionnaires": [{"name": "iou"}]}), "results, got 'iou' twice"),
        (json.dumps(STUDY | {"questionnaires": [{"name": "q"}, {"name": "q"}]}), "'q' twice"),
        (json.dumps(STUDY | {"tasks": [STUDY["tasks"][0] | {"frames": "x"}]}), "got 'x'$"),
        (json.dumps(STUDY | {"tasks": 3}), "valid list, got '3'$"),
        (json.dumps(STUDY | {"seed": "x"}), "seed.*got 'x'"),
        (json.dumps(STUDY | {"design": "both"}), "design"),
        (json.dumps(STUDY | {"tasks": [STUDY["tasks"][0] | {"labels": ["up"]}]}), "left, right"),
        (json.dumps(STUDY | {"tasks": [STUDY["tasks"][0] | {"frames": "9:"}]}), "0:4"),
        (json.dumps(STUDY | {"tasks": [STUDY["tasks"][0] | {"recording": "none"}]}), "'none'"),
    ):
        with pytest.raises(PointbrushError, match=words):
            ask(lead, "POST", body={"text": text})
    with pytest.raises(ConflictError, match="without participants"):
        ask(lead, "PUT", "/halves", {"text": json.dumps(STUDY)})


def test_studies_created_at_once_have_different_ids(lead: Client) -> None:
    text = json.dumps(STUDY | {"title": "At once"})
    with ThreadPoolExecutor(8) as pool:
        made = [*pool.map(lambda _: ask(lead, "POST", body={"text": text})["id"], range(8))]
    assert len(set(made)) == 8
    for study in made:
        ask(lead, "DELETE", f"/{study}")


def test_a_label_that_was_renamed_is_named(
    people: list[Person], lead: Client, server: Served
) -> None:
    left = lead["wall"].label("left")
    lead["wall"].update_label(left.id, name="west")
    with pytest.raises(BadInputError, match="some of west, right for halves, got 'left'"):
        ask(lead, "GET", "/halves/results")
    lead["wall"].update_label(left.id, name="left")


def test_a_study_is_a_text(people: list[Person], lead: Client, server: Served) -> None:
    halves = ask(lead, "GET", "/halves")
    again = ask(lead, "POST", body={"text": halves["text"]})
    assert (again["id"], again["study"]) == ("two-halves", halves["study"])
    random = {"text": json.dumps(STUDY | {"order": "random"})}
    assert ask(lead, "PUT", "/two-halves", random)["study"]["order"] == "random"
    folder = server.workspace.settings.workspace / "studies"
    (folder / "two-halves.yaml").write_text("title: 3")
    with pytest.raises(BadInputError, match=r"two-halves: title: .*string"):
        ask(lead, "GET")
    (folder / "two-halves.yaml").write_bytes(halves["text"].encode("utf-16"))
    (folder / "other.yaml").mkdir()
    (folder / ".~lock.yaml").write_text("of an editor")
    with pytest.raises(BadInputError, match="two-halves: expected YAML, got"):
        ask(lead, "GET")
    (folder / "other.yaml").rmdir()
    assert ".~lock" not in StudyFiles(folder).ids()
    (folder / ".~lock.yaml").unlink()
    changed = ask(lead, "PUT", "/two-halves", {"text": halves["text"]})
    assert changed["study"] == halves["study"]
    ask(lead, "DELETE", "/two-halves")


def traces(server: Served, secrets: list[str]) -> set[str]:
    """Return the secrets that the workspace's files, their names or the database contain."""
    folder = server.workspace.settings.workspace
    files = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    contents = [*files.values(), *(str(path).encode() for path in files)]
    with server.workspace.labels.database.read() as connection:
        for table in metadata.sorted_tables:
            contents += [repr(tuple(row)).encode() for row in connection.execute(select(table))]
    return {text for text in secrets if any(text.encode() in each for each in contents)}


def delete(server: Served, lead: Client, person: Person) -> None:
    """Delete a participant, and search the workspace for what is left of them."""
    workspace = server.workspace
    session = workspace.labels.studies.get("halves", person.code)
    copies = workspace.labels.studies.copies(session)
    history = [edit for copy in copies.values() for edit in workspace.labels.edits(copy)]
    edits = [edit.id for edit in history if edit.kind != "import"]
    identities = [workspace.recording(copy).manifest.identity for copy in copies.values()]
    secrets = [person.code, session.account, digest_of(person.code), *edits, *identities]
    for identity in identities:  # as object clicks leave them
        folder = workspace.settings.workspace / "objects" / identity
        folder.mkdir(parents=True)
        (folder / "000000.npz").touch()
    # Only the digest of the code is stored.
    assert traces(server, secrets) == {*secrets} - {person.code}
    assert edits
    ask(lead, "DELETE", f"/halves/participants/{person.code}")
    assert traces(server, secrets) == set()
    assert person.call("GET", f"/study/{person.code}/step").status_code == 401
    assert person.call("GET", "/sequences").status_code == 401


def test_deletion_leaves_no_trace(people: list[Person], lead: Client, server: Served) -> None:
    delete(server, lead, people[1])
    assert [each["number"] for each in ask(lead, "GET", "/halves/participants")] == [1]
    assert ask(lead, "POST", "/halves/participants/1/replay")["equal"]
    ask(lead, "DELETE", "/halves")
    assert ask(lead, "GET") == []
    assert [each.id for each in lead.sequences()] == ["wall"]
    assert not any((server.workspace.settings.workspace / "studies").iterdir())


def test_deletion_leaves_no_trace_in_postgresql(postgres_url: str, tmp_path: Path) -> None:
    settings = settings_in(tmp_path, database=postgres_url)
    with serving_wall(settings) as server, Client(server.url, server.token) as lead:
        ask(lead, "POST", body={"text": json.dumps(STUDY), "id": "halves"})
        (added,) = ask(lead, "POST", "/halves/participants", {"count": 1})
        person = enter(server, lead, added)
        person.work(person.run("practice"))
        delete(server, lead, person)
        person.http.close()
