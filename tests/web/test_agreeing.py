"""Two and three people on the same frames: not seen by each other, compared, merged, scored."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack

import numpy as np
import pytest

from pointbrush.client import Client
from pointbrush.errors import BadInputError, ForbiddenError, NotFoundError
from tests.serving import Served, add_sequence, serving, settings_in

PEOPLE = {"ada": "annotator", "bob": "annotator", "cat": "annotator", "lead": "manager"}


@pytest.fixture
def people(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Client]]:
    settings = settings_in(tmp_path_factory.mktemp("agreeing"))
    for name in ("room", "truth"):
        add_sequence(settings, name, frames=2, points=400)
    with serving(settings) as served, ExitStack() as stack:
        yield {
            name: stack.enter_context(Client(served.url, token_of(served, name, role)))
            for name, role in PEOPLE.items()
        }


def token_of(served: Served, name: str, role: str) -> str:
    return served.workspace.labels.tokens.add(role, name)


def paint(client: Client, sequence: str, *objects: tuple[int, int, int]) -> None:
    """Give points first to stop - 1 of frame 0 a label."""
    recording = client[sequence]
    values = np.zeros(recording.manifest.points[0], np.uint16)
    for label, first, stop in objects:
        values[first:stop] = label
    recording.frames[0].annotate(values)


def test_three_people_disagree_where_nobody_sees_the_others_and_the_majority_is_taken(
    people: dict[str, Client],
) -> None:
    lead = people["lead"]
    car = lead["room"].create_label("car", category="car").id
    tree = lead["room"].create_label("tree", category="tree").id
    project = lead.projects["default"]
    made = project.add_tasks(["room"], frames="0:1", people=3)
    assert [(task.first, task.last) for task in made] == [(0, 0)] * 3
    copies = {}
    for name in ("ada", "bob", "cat"):
        mine = people[name].projects["default"]
        copies[name] = mine.next_task().sequence
        assert mine.next_task().sequence == copies[name]
    assert len({*copies.values(), "room"}) == 4
    assert [each.id for each in lead.sequences()] == ["room", "truth"]
    with pytest.raises(NotFoundError):
        people["ada"][copies["bob"]]
    paint(people["ada"], copies["ada"], (car, 0, 100), (tree, 200, 300))
    paint(people["bob"], copies["bob"], (car, 0, 100))
    extra = people["cat"][copies["cat"]].create_label("van", category="car").id
    paint(people["cat"], copies["cat"], (extra, 0, 60), (tree, 200, 300))
    with pytest.raises(BadInputError, match="handed in"):
        project.merge("room")
    for name in copies:
        client = people[name].projects["default"]
        client.put_task(client.next_task().number, state="done")
        assert client.next_task() is None, "nobody labels a copy of what they have labelled"
    with pytest.raises(ForbiddenError):
        people["ada"].projects["default"].agreement("room")
    pairs = {(each.first, each.second): each for each in project.agreement("room")}
    found = pairs[copies["ada"], copies["bob"]]
    (missed,) = found.places
    assert (missed.kind, missed.first, missed.points) == ("missed", ("tree",), 100)
    assert len(missed.place) == 3
    assert found.agreement.same == 0.5
    assert project.merge("room").changed == 200
    values = lead["room"].frames[0].annotation()
    assert (values[:100] == car).all()
    assert (values[200:300] == tree).all()
    assert np.count_nonzero(values) == 200
    project.merge("room", copies["cat"])
    values = lead["room"].frames[0].annotation()
    names = {each.id: each.name for each in lead["room"].labels()}
    assert [names[int(n)] for n in values[[0, 59, 200]]] == ["van", "van", "tree"]
    assert values[60] == 0


def test_places_are_merged_one_by_one_and_tell_whose_labels_are_there(
    people: dict[str, Client],
) -> None:
    lead = people["lead"]
    car = lead["room"].create_label("car", category="car").id
    project = lead.projects["default"]
    project.add_tasks(["room"], people=2)
    copies = {}
    for name, size in (("ada", 100), ("bob", 40)):
        mine = people[name].projects["default"]
        task = mine.next_task()
        copies[name] = task.sequence
        own = people[name][task.sequence].create_label(f"tree of {name}", category="tree").id
        paint(people[name], task.sequence, (car, 0, size), (own, 200, 200 + size))
        mine.put_task(task.number, state="done")

    def places() -> list[tuple[str, tuple[tuple[int, ...], ...], int | None]]:
        (pair,) = project.agreement("room")
        found = [(each.kind, each.labels, each.has) for each in pair.places]
        return sorted(found, key=lambda each: each[1])

    assert places() == [("outline", ((1,), (1,)), None), ("outline", ((2,), (2,)), None)]
    for take, size in (("ada", 100), ("bob", 40), ("ada", 100)):
        labels = {copies["ada"]: [2], copies["bob"]: [2]}
        project.merge("room", copies[take], labels, frame=0)
        values = lead["room"].frames[0].annotation()
        assert np.count_nonzero(values) == np.count_nonzero(values[200 : 200 + size]) == size
        assert [each[2] for each in places()] == [None, 0 if take == "ada" else 1]
    assert sorted(each.name for each in lead["room"].labels()) == [
        "car",
        "tree of ada",
        "tree of bob",
    ]
    with pytest.raises(BadInputError, match="handed in"):
        project.merge("room", copies["ada"], labels, frame=5)


def test_who_labels_cannot_tell_a_copy_from_a_recording(people: dict[str, Client]) -> None:
    lead, ada = people["lead"], people["ada"]
    project, hers = lead.projects["default"], ada.projects["default"]
    project.add_tasks(["truth"], truth=True)
    with pytest.raises(NotFoundError):
        ada["truth"].labels()  # nor look up what they will be scored by
    scored = hers.next_task()
    hers.put_task(scored.number, state="done")
    project.add_tasks(["room"], people=2)
    task = hers.next_task()
    bobs = people["bob"].projects["default"].next_task()
    assert [each.id for each in ada.sequences()] == [task.sequence, scored.sequence]
    assert [task.sequence, bobs.sequence] == ["room-2", "room-3"]
    first, second = (recording.manifest for recording in ada.sequences())
    assert [first.name, second.name] == [each.manifest.name for each in lead.sequences()]
    assert [each.number for each in hers.tasks()] == [scored.number, task.number]
    info = ada.projects["default"].info
    assert dict(info.tasks) == {"done": 1, "taken": 1}
    assert info.recordings == (task.sequence, scored.sequence)
    assert ada["room"].id == task.sequence, "what she calls by its name is hers"
    assert [each.id for each in ada.search("room")] == [task.sequence]
    assert [each.id for each in lead.search("room")] == ["room"]
    with pytest.raises(NotFoundError):
        hers.task(bobs.number)
    (edit,) = ada[task.sequence].edits()
    assert (edit.kind, edit.summary) == ("import", "labels that came with the files, 0 frames")


def test_frames_of_known_truth_score_who_labels_them(people: dict[str, Client]) -> None:
    lead, ada = people["lead"], people["ada"]
    car = lead["truth"].create_label("car", category="car").id
    tree = lead["truth"].create_label("tree", category="tree").id
    paint(lead, "truth", (car, 0, 100), (tree, 200, 300))
    project = lead.projects["default"]
    project.add_tasks(["truth"], truth=True)
    task = ada.projects["default"].next_task()
    copy = ada[task.sequence]
    assert not copy.frames[0].annotation().any()
    assert [each.name for each in copy.labels()] == ["car", "tree"]
    assert ada.projects["default"].statistics().classes == ()  # as the truth has them
    assert {each.name for each in project.statistics().classes} == {"car", "tree"}
    other = copy.create_label("car 2", category="car").id
    paint(ada, task.sequence, (car, 0, 100), (other, 200, 300))
    assert project.scores() == []
    ada.projects["default"].put_task(task.number, state="done")
    (score,) = project.scores()
    assert (score.person, score.frames) == ("ada", 2)
    assert (score.found, score.missed, score.added) == (1, 1, 1)
    assert score.miou == pytest.approx(0.25)
