"""A workspace holds a bounded number of each thing, and refuses the next one in words."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from threading import Thread

import pytest

from pointbrush.classify.classifier import Classifier
from pointbrush.errors import BadInputError, ConflictError
from pointbrush.labels import versions
from pointbrush.labels.boxes import journal as box_journal
from pointbrush.labels.classes import palette
from pointbrush.teamwork import projects, tasks, webhooks
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.teamwork.tasks import Stretch
from pointbrush.values.team.projects import ProjectPatch
from pointbrush.values.team.tasks import NewTasks
from pointbrush.work.classifiers import files
from pointbrush.work.classifiers.files import ClassifierFiles
from pointbrush.work.projects import queue
from pointbrush.workspace import Workspace
from tests.serving import add_sequence, settings_in

SEQUENCE = "juggling"
PROJECT = "default"


def add_project(store: WorkspaceStore, number: int) -> object:
    return store.team.projects.create(f"project-{number}", ProjectPatch())


def add_snapshot(store: WorkspaceStore, number: int) -> object:
    return store.versions.create(PROJECT, f"snapshot-{number}", "then", "ann")


def add_task(store: WorkspaceStore, number: int) -> object:
    return store.team.tasks.add(PROJECT, "lead", [Stretch(SEQUENCE, number, number)])


def add_webhook(store: WorkspaceStore, number: int) -> object:
    return store.team.webhooks.add(PROJECT, f"https://example.org/{number}", ["task"])


def add_label(store: WorkspaceStore, number: int) -> object:
    return store.create_label(SEQUENCE, "ann", name=f"label {number}")


@pytest.mark.parametrize(
    ("add", "module", "limit", "held", "words"),
    [
        (add_project, projects, "MOST_PROJECTS", 1, "projects: expected at most 3 in a workspace"),
        (add_snapshot, versions, "MOST_VERSIONS", 0, "snapshots: expected at most 3 in a project"),
        (add_task, tasks, "MOST_TASKS", 0, "tasks: expected at most 3 in a project"),
        (add_webhook, webhooks, "MOST_WEBHOOKS", 0, "webhooks: expected at most 3 in a project"),
        (add_label, palette, "HIGHEST", 0, "label: expected at most 3 labels"),
    ],
)
def test_the_first_one_too_many_is_refused_also_by_two_servers_at_once(
    store: WorkspaceStore,
    url: str,
    monkeypatch: pytest.MonkeyPatch,
    add: Callable[[WorkspaceStore, int], object],
    module: object,
    limit: str,
    held: int,
    words: str,
) -> None:
    monkeypatch.setattr(module, limit, 3)
    made, refused = [], []

    def work(at: WorkspaceStore, number: int) -> None:
        try:
            made.append(add(at, number))
        except (BadInputError, ConflictError) as error:
            refused.append(str(error))

    with closing(WorkspaceStore(url)) as other:
        threads = [Thread(target=work, args=(at, k)) for k, at in enumerate((store, other) * 2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    work(store, 4)
    assert len(made) == 3 - held
    assert len(refused) == 2 + held
    assert all(each.startswith(words) for each in refused)


def test_tasks_that_have_no_room_make_no_copies(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = settings_in(tmp_path)
    add_sequence(settings, "ball", frames=2, points=30)
    monkeypatch.setattr(tasks, "MOST_TASKS", 3)
    with closing(Workspace(settings)) as workspace:
        with pytest.raises(BadInputError, match="at most 3 in a project"):
            workspace.queue.add(PROJECT, "lead", NewTasks(every=1, people=2))
        assert list(workspace.library.ids()) == ["ball"]
        assert len(workspace.queue.add(PROJECT, "lead", NewTasks(people=2))) == 2


def test_a_workspace_has_a_bounded_number_of_classifiers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(files, "MOST_CLASSIFIERS", 1)
    kept = ClassifierFiles(tmp_path)
    kept.write(kept.free_id("mine"), Classifier("mine", ("a",), 0.5))
    with pytest.raises(BadInputError, match="classifiers: expected at most 1 in a workspace"):
        kept.free_id("other")
    kept.delete("mine")
    assert kept.free_id("other") == "other"


def test_the_documentation_has_these_numbers() -> None:
    page = (Path(__file__).parents[2] / "docs" / "limits.md").read_text(encoding="utf-8")
    table = page.partition("## Numbers of things")[2].partition("\n## ")[0]
    limits = {
        "projects": projects.MOST_PROJECTS,
        "snapshots": versions.MOST_VERSIONS,
        "tasks": tasks.MOST_TASKS,
        "people": queue.MOST_PEOPLE,
        "webhooks": webhooks.MOST_WEBHOOKS,
        "classifiers": files.MOST_CLASSIFIERS,
        "labels": palette.HIGHEST,
        "boxes": box_journal.MOST_BOXES,
    }
    for thing, limit in limits.items():
        row = next(line for line in table.splitlines() if line.startswith(f"| {thing} "))
        assert f"{limit:,}" in row
    assert f"{queue.MOST_TASKS:,}" in table
