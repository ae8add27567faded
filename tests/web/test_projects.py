"""Projects and their queues over REST and by the client: who may what, and who sees what."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from pointbrush.client import AsyncClient, Client
from pointbrush.database.job import Job
from pointbrush.errors import BadInputError, ConflictError, ForbiddenError, NotFoundError
from tests.serving import TOKEN, Served, add_sequence, serving, settings_in
from tests.streaming.client import viewer

ROLES = {
    "ada": "annotator",
    "bob": "annotator",
    "grace": "reviewer",
    "guest": "annotator",
    "lead": "manager",
}
PLACE = [0.5, -0.25, 3.0]


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """Two recordings of 6 frames, ``day`` and ``night``."""
    folder = tmp_path_factory.mktemp("projects")
    (folder / "inbox").mkdir()
    settings = settings_in(folder, import_roots=str(folder / "inbox"))
    for name in ("day", "night"):
        add_sequence(settings, name, frames=6, points=500)
    with serving(settings) as running:
        yield running


@pytest.fixture
def people(served: Served) -> Iterator[dict[str, Client]]:
    """A client of each person; the project ``night`` is theirs but for the guest."""
    tokens = served.workspace.labels.tokens
    for token in tokens.list():
        tokens.revoke(token.id)
    with ExitStack() as stack:
        clients = {
            name: stack.enter_context(Client(served.url, tokens.add(role, name)))
            for name, role in ROLES.items()
        }
        roles = {"ada": "annotator", "bob": "annotator", "grace": "reviewer"}
        project = clients["lead"].projects.create(
            "Night", id="night", roles=roles, recordings=["night"]
        )
        yield clients
        for task in project.tasks():
            project.delete_task(task.number)
        project = clients["lead"].projects["default"]
        project.change(recordings=["night"])
        clients["lead"].projects["night"].delete()


def test_a_task_goes_from_its_lead_to_a_person_to_a_reviewer_and_back(
    people: dict[str, Client],
) -> None:
    lead, ada, bob, grace = (
        people[name].projects["night"] for name in ("lead", "ada", "bob", "grace")
    )
    made = lead.add_tasks(every=2)
    assert [(task.first, task.last, task.state) for task in made] == [
        (0, 1, "open"),
        (2, 3, "open"),
        (4, 5, "open"),
    ]
    task = ada.next_task()
    assert (task.number, task.state, task.assignee) == (1, "taken", "ada")
    assert bob.next_task().number == 2
    with pytest.raises(ForbiddenError, match="another person's"):
        bob.put_task(1, state="done")
    with pytest.raises(ForbiddenError, match="role reviewer"):
        grace_as_annotator(bob, 1)
    ada.put_task(1, state="done")
    assert ada.put_task(1, state="done").state == "done"
    with pytest.raises(ForbiddenError, match="role reviewer"):
        ada.put_task(1, state="accepted")
    assert grace.next_task("review").number == 1
    returned = grace.put_task(1, state="returned", note="the door", frame=1, place=PLACE)
    assert (returned.note, returned.frame, returned.place) == ("the door", 1, tuple(PLACE))
    assert ada.next_task().number == 1
    ada.put_task(1, state="done")
    accepted = grace.put_task(1, state="accepted")
    assert (accepted.note, accepted.place, accepted.reviewer) == ("", None, "grace")
    with pytest.raises(ConflictError, match="accepted"):
        ada.put_task(1, state="taken")
    bob.put_task(2, state="open")
    assert ada.next_task().number == 2
    night = people["lead"].projects["night"]
    info = night.info
    assert "night" in repr(night)
    assert info.name in night._repr_html_()
    assert info.tasks == {"accepted": 1, "open": 1, "taken": 1}
    assert info.people == {"": {"open": 1}, "ada": {"accepted": 1, "taken": 1}}
    assert [line.state for line in lead.task_history(1)][:2] == ["accepted", "done"]
    assert [task.number for task in lead.tasks(person="ada")] == [1, 2]


def grace_as_annotator(project: Any, number: int) -> None:
    project.put_task(number, note="not mine to say")


@pytest.mark.parametrize(
    ("values", "error", "said"),
    [
        ({}, BadInputError, "a state, a note or an assignee"),
        ({"state": "done"}, ConflictError, "expected one of taken"),
        ({"note": "here", "frame": 5, "place": PLACE}, BadInputError, "0 to 1"),
        ({"note": "here", "frame": 1}, BadInputError, "together"),
        ({"state": "lost"}, BadInputError, "state"),
    ],
)
def test_steps_that_there_are_not_are_refused_in_words(
    people: dict[str, Client], values: dict[str, Any], error: type[Exception], said: str
) -> None:
    project = people["lead"].projects["night"]
    project.add_tasks(frames="0:2")
    with pytest.raises(error, match=said):
        project.put_task(1, **values)


def test_a_project_with_roles_is_not_there_for_others(
    people: dict[str, Client], served: Served
) -> None:
    guest, ada = people["guest"], people["ada"]
    assert [each.id for each in guest.sequences()] == ["day"]
    assert [each.id for each in guest.projects.all()] == ["default"]
    for look in (
        lambda: guest["night"],
        lambda: guest.projects["night"],
        lambda: guest["day"].review.agreement("night"),
        lambda: guest.classifiers.create("of others", ["night"]),
        lambda: guest.classifiers.create("of mine", ["day"], start_from=["night"]),
        lambda: guest.call("GET", "/sequences/night/frames/0/points"),
    ):
        with pytest.raises(NotFoundError):
            look()
    assert [each.id for each in ada.sequences()] == ["day", "night"]
    with pytest.raises(ForbiddenError, match="role manager"):
        ada.projects["night"].add_tasks()
    people["lead"].projects["night"].change(roles={"ada": "viewer"})
    with pytest.raises(ForbiddenError, match="role annotator"):
        ada["night"].create_label("wall")
    ada["day"].create_label("wall")
    with pytest.raises(NotFoundError):
        people["grace"].projects["night"].tasks()


def heard_jobs(served: Served, secret: str, *jobs: Job) -> list[str | None]:
    """Return the recordings of those jobs that reach a viewer; the last one must."""

    async def listen() -> list[str | None]:
        async with viewer(served.url, secret) as client:
            await client.open("day")
            for job in jobs:
                served.workspace._listeners.notify(job)
            await client.until("job", id=jobs[-1].id)
            return [each["sequence"] for each in client.log if each["type"] == "job"]

    return asyncio.run(listen())


def test_jobs_of_a_project_are_not_told_to_others(
    people: dict[str, Client], served: Served
) -> None:
    tokens = served.workspace.labels.tokens
    secrets = {role: tokens.add(role, f"a {role}") for role in ("annotator", "manager")}
    told = (
        Job(kind="tracking", sequence="night"),
        Job(kind="import", sequence="not-there-yet", request={"project": "night"}),
        Job(kind="tracking", sequence="day"),
    )

    assert heard_jobs(served, secrets["annotator"], *told) == ["day"]
    assert heard_jobs(served, secrets["manager"], *told) == ["night", "not-there-yet", "day"]


def test_a_recording_with_the_id_of_a_deleted_one_is_another_one(
    people: dict[str, Client], served: Served
) -> None:
    """The first one is in a project that the guest has no role in, the second one in none."""
    lead, guest = people["lead"], people["guest"]
    before = Job(kind="tracking", sequence="twice")
    cloud = served.workspace.settings.roots[0] / "twice.xyz"
    cloud.write_text("".join(f"{x} 0 0\n" for x in range(20)))
    secret = served.workspace.labels.tokens.add("annotator", "guest two")
    assert lead.import_path(cloud, project="night").id == "twice"
    with pytest.raises(NotFoundError):
        guest["twice"].labels()
    lead["twice"].delete()
    assert lead.import_path(cloud).id == "twice"
    assert len(guest["twice"].frames) == 1
    told = guest.call("GET", "/sequences/twice/events", params={"after": 0}).json()["jobs"]
    assert len(told) == 1, "the import of the first one is told"
    assert "twice" in {each.id for each in guest.sequences()}
    assert "twice" not in {each.id for each in guest.deleted()}
    assert "twice" in {each.id for each in lead.deleted()}
    after = Job(kind="tracking", sequence="twice")
    assert heard_jobs(served, secret, before, after) == ["twice"]
    assert heard_jobs(served, secret, before, Job(kind="tracking", sequence="day")) == ["day"]
    lead["twice"].delete()


def test_the_same_by_code_that_awaits(people: dict[str, Client], served: Served) -> None:
    async def walk() -> None:
        async with AsyncClient(served.url, TOKEN) as client:
            night = await client.projects["night"]
            (task,) = await night.add_tasks(["night"], assignee="owner")
            assert (await night.next_task()).number == task.number
            assert (await night.put_task(task.number, state="done")).state == "done"
            assert await night.next_task("review") is None
            assert [one.id for one in await client.projects.all()] == ["default", "night"]

    asyncio.run(walk())


def test_recordings_are_found_by_name_class_label_state_and_person(
    people: dict[str, Client], served: Served
) -> None:
    lead, ada, grace = people["lead"], people["ada"], people["grace"]
    night, day = ada["night"], ada["day"]
    car = night.create_label("car 1", category="car")
    wall = day.create_label("brickwork")
    for recording, label in ((night, car), (day, wall)):
        recording.frames[0].stroke(label=label.id, radius=0.5, samples=[[0, 0, 3]])
    project = lead.projects["night"]
    project.add_tasks(assignee="bob")

    def found(*text: str, **wanted: str) -> list[str]:
        return [each.id for each in grace.search(*text, **wanted)]

    assert found("igh") == found(project="night") == found(class_="CAR") == ["night"]
    assert found(label="brickwork") == found(class_="brickwork") == found("DAY") == ["day"]
    assert found(state="open") == found(person="bob") == ["night"]
    assert found(person="ada") == ["day", "night"]
    assert found(class_="car", label="brickwork") == found(state="taken") == []
    assert [each.id for each in people["guest"].search(person="ada")] == ["day"]
    figures = project.statistics()
    assert figures.recordings == figures.labelled_frames == figures.objects == 1
    ((cars,), (mine,)) = figures.classes, figures.people
    assert (cars.name, mine.name, mine.edits) == ("car", "ada", 2)
    assert cars.points == mine.points > 0
    assert cars.hours == mine.hours > 0
    project.put_task(1, state="open")


def test_a_folder_of_recordings_comes_in_at_once(people: dict[str, Client], served: Served) -> None:
    inbox = served.workspace.settings.roots[0]
    for number in (2, 10):
        (inbox / "drives" / f"drive {number}").mkdir(parents=True)
        for frame in range(2):
            text = "".join(f"{x} {frame} 0\n" for x in range(20))
            (inbox / "drives" / f"drive {number}" / f"{frame}.xyz").write_text(text)
    lead = people["lead"]
    project = lead.projects["night"]
    found = lead.entries(inbox / "drives")
    assert [(each.name, Path(each.path).parent) for each in found] == [
        ("drive 2", inbox / "drives"),
        ("drive 10", inbox / "drives"),
    ]
    texts = (inbox / "drives" / "drive 2").iterdir()
    assert found[0].bytes == sum(text.stat().st_size for text in texts)
    with pytest.raises(ForbiddenError):
        people["ada"].entries(inbox / "drives")
    with pytest.raises(ForbiddenError):
        people["ada"].projects["night"].import_each(inbox / "drives")
    made = [lead.wait(job)["sequence"] for job in project.import_each(inbox / "drives", fps=5.0)]
    assert made == ["drive-2", "drive-10"]
    assert lead["drive-2"].manifest.project == "night"
    assert [len(lead[each].frames) for each in made] == [2, 2]
    with pytest.raises(NotFoundError):
        people["guest"]["drive-2"]
    lead.projects["default"].change(recordings=made)
    for each in made:
        lead[each].delete()
