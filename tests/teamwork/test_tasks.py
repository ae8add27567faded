"""The queue of a project, on both databases: nobody's task is another's, whoever asks at once."""

from __future__ import annotations

from collections import Counter
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from threading import Thread

import pytest

from pointbrush.accounts.roles import Role
from pointbrush.database import backup
from pointbrush.errors import ConflictError, NotFoundError
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.teamwork.tasks import Stretch, Task, Wanted
from pointbrush.values.team.projects import ProjectPatch
from pointbrush.work.backups.backup import make_backup
from pointbrush.workspace import Workspace
from tests.old_workspace import old_workspace

SEQUENCE = "juggling"
PROJECT = "default"


def add(store: WorkspaceStore, count: int, **more: str) -> list[Task]:
    stretches = [Stretch(SEQUENCE, number, number) for number in range(count)]
    return store.team.tasks.add(PROJECT, "lead", stretches, **more)


def test_no_two_people_at_two_servers_take_one_task(store: WorkspaceStore, url: str) -> None:
    add(store, 24)
    taken: list[tuple[str, int]] = []

    def work(store: WorkspaceStore, account: str) -> None:
        while (task := store.team.tasks.take(PROJECT, account)) is not None:
            taken.append((account, task.number))
            store.team.tasks.change(
                PROJECT, task.number, account, lambda t: replace(t, state="done")
            )

    with closing(WorkspaceStore(url)) as other:
        people = [
            Thread(target=work, args=(at, f"person {number}"))
            for number, at in enumerate((store, other, store, other))
        ]
        # And one person who asks at both at once.
        people += [Thread(target=lambda at=at: taken_once(at)) for at in (store, other)]
        for person in people:
            person.start()
        for person in people:
            person.join()
    numbers = Counter(number for _, number in taken)
    mine = store.team.tasks.entries(PROJECT, Wanted(assignee="twice"))
    assert len(mine) <= 1
    assert sorted(numbers.elements()) == sorted(set(range(1, 25)) - {t.number for t in mine})


def taken_once(store: WorkspaceStore) -> None:
    store.team.tasks.take(PROJECT, "twice")


def test_what_comes_next_is_ones_own_then_what_was_returned_then_what_is_free(
    store: WorkspaceStore,
) -> None:
    add(store, 4)
    tasks = store.team.tasks

    def put(number: int, **values: str) -> None:
        tasks.change(PROJECT, number, "lead", lambda task: replace(task, **values))

    put(2, assignee="ada")
    put(4, state="returned", assignee="ada")
    order = []
    for _ in range(3):
        task = tasks.take(PROJECT, "ada")
        assert task == tasks.take(PROJECT, "ada")
        order.append(task.number)
        put(task.number, state="done")
    assert order == [4, 2, 1]
    assert tasks.take(PROJECT, "ada", review=True) is None
    assert tasks.take(PROJECT, "grace", review=True).number == 1
    assert [(each.state, each.by) for each in tasks.history(PROJECT, 4)] == [
        ("done", "lead"),
        ("taken", "ada"),
        ("returned", "lead"),
        ("open", "lead"),
    ]


def test_a_call_that_is_repeated_makes_no_other_tasks_and_frames_have_one(
    store: WorkspaceStore,
) -> None:
    made = add(store, 2, batch="call")
    assert add(store, 2, batch="call") == made
    with pytest.raises(ConflictError, match="1 to 3 of 'juggling'"):
        store.team.tasks.add(PROJECT, "lead", [Stretch(SEQUENCE, 1, 3)])
    store.team.tasks.change(PROJECT, 2, "lead", lambda task: replace(task, state="accepted"))
    assert store.team.tasks.add(PROJECT, "lead", [Stretch(SEQUENCE, 1, 3)])[0].number == 3
    store.team.tasks.remove(PROJECT, 3)
    with pytest.raises(NotFoundError):
        store.team.tasks.history(PROJECT, 3)


def test_a_recording_moves_when_its_tasks_are_over_and_a_project_goes_when_it_is_empty(
    store: WorkspaceStore,
) -> None:
    projects = store.team.projects
    projects.create("night", ProjectPatch(name="Night", roles={"ada": "reviewer"}))
    add(store, 1)
    with pytest.raises(ConflictError, match="not accepted yet"):
        projects.change("night", ProjectPatch(recordings=[SEQUENCE]))
    store.team.tasks.change(PROJECT, 1, "lead", lambda task: replace(task, state="accepted"))
    assert projects.change("night", ProjectPatch(recordings=[SEQUENCE])).recordings == (SEQUENCE,)
    access = store.team.access
    assert access.to_sequence(SEQUENCE, "ada", "annotator") == "annotator"
    assert access.to_sequence(SEQUENCE, "bob", "reviewer") is None
    assert access.to_sequence(SEQUENCE, "bob", "manager") == "manager"
    with pytest.raises(ConflictError, match="has 'juggling'"):
        projects.remove("night")
    projects.change(PROJECT, ProjectPatch(recordings=[SEQUENCE]))
    projects.remove("night")
    assert [each.id for each in projects.all()] == [PROJECT]
    with pytest.raises(NotFoundError, match="taxonomy"):
        projects.change(PROJECT, ProjectPatch(categories=[7]))


def test_they_move_with_the_database_and_go_with_the_recording(
    store: WorkspaceStore, url: str, tmp_path: Path
) -> None:
    add(store, 2)
    store.team.projects.change(PROJECT, ProjectPatch(name="First", roles={"ada": "viewer"}))
    backup.back_up(store.database, tmp_path / "copy.sqlite")
    backup.restore(tmp_path / "copy.sqlite", f"sqlite:///{tmp_path / 'again.sqlite'}")
    with closing(WorkspaceStore(f"sqlite:///{tmp_path / 'again.sqlite'}")) as again:
        assert again.team.projects.get(PROJECT) == store.team.projects.get(PROJECT)
        assert again.team.tasks.entries(PROJECT, Wanted()) == store.team.tasks.entries(
            PROJECT, Wanted()
        )
    store.recordings.forget(SEQUENCE)
    assert store.team.tasks.entries(PROJECT, Wanted()) == []


def test_an_old_workspace_is_one_project(tmp_path: Path) -> None:
    with closing(Workspace(old_workspace(tmp_path))) as workspace:
        (project,) = workspace.labels.team.projects.all()
        assert (project.id, project.name, project.recordings) == (
            PROJECT,
            "Default",
            ("ball", "hall"),
        )
        other = workspace.labels.team.projects.create("other", ProjectPatch(recordings=["ball"]))
        make_backup(workspace.labels, workspace.library, tmp_path / "backup")
        workspace.labels.team.projects.change(PROJECT, ProjectPatch(recordings=["ball"]))
        workspace.labels.team.projects.remove("other")
        restored = workspace.restore_from_backup(tmp_path / "backup", "ball")
        assert other.recordings == ("ball",)
        assert set(workspace.labels.team.projects.get(PROJECT).recordings) == {
            "ball",
            "hall",
            restored,
        }


def test_an_id_of_a_closed_projects_recording_tells_nobody_else_of_the_next_one(
    store: WorkspaceStore,
) -> None:
    store.team.projects.create("night", ProjectPatch(roles={"ada": "annotator"}))
    access = store.team.access

    def seen(account: str) -> bool:
        return access.to_sequence("shelf", account, "reviewer") is not None

    assert not seen("bob"), "before an import has told its project"
    store.recordings.register("shelf", [3], "one", "night")
    assert (seen("ada"), seen("bob")) == (True, False)
    store.recordings.delete("shelf")
    store.recordings.register("shelf", [3], "two")
    assert (seen("ada"), seen("bob")) == (True, True)
    store.recordings.delete("shelf")
    assert not seen("bob"), "who saw the one before"
    store.recordings.register("shelf", [3], "three", "night")
    assert (seen("ada"), seen("bob")) == (True, False)


@pytest.mark.parametrize("roles", [{"ada": "annotator"}, {}])
def test_deleted_recordings_of_a_closed_project_stay_hidden_after_it_is_removed(
    store: WorkspaceStore, roles: dict[str, Role]
) -> None:
    store.team.projects.create("night", ProjectPatch(roles=roles))
    store.recordings.register("shelf", [3], "one", "night")
    number = store.recordings.delete("shelf").number
    store.team.projects.remove("night")
    seen = None if roles else "annotator"
    access = store.team.access
    assert access.to_number(number, "ada", "annotator") == seen
    assert access.to_number(number, "bob", "annotator") == seen
    assert access.to_number(number, "lead", "manager") == "manager"
    store.team.projects.create("night", ProjectPatch(roles={"bob": "annotator"}))
    assert access.to_number(number, "bob", "annotator") == seen, "the next project of this id"
    store.recordings.restore(number, "shelf")
    assert "shelf" in store.team.projects.get(PROJECT).recordings
    assert access.to_sequence("shelf", "bob", "annotator") == "annotator"
