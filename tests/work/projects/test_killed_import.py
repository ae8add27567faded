"""A server is killed as an import into a closed project ends: nobody else sees the recording."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from pointbrush.client import Client
from pointbrush.errors import NotFoundError
from pointbrush.labels.recordings import Recordings
from pointbrush.sequences.storage.manifest import read_manifest
from pointbrush.values.team.projects import ProjectPatch
from pointbrush.workspace import Workspace
from tests.forked import call
from tests.serving import serving, settings_in
from tests.waiting import eventually

SECRET, PROJECT = "scan", "night"
ROLES = {"ada": "annotator"}


def die(*_: object, **__: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def import_until_killed(folder: Path, kept: bool) -> None:
    """Import into the closed project, and die before its recording is registered.

    ``kept``: the job is written down, so that the next server goes on with it.
    """
    workspace = Workspace(settings_in(folder))
    workspace.labels.team.projects.create(PROJECT, ProjectPatch(roles=ROLES))
    if kept:
        workspace.keep_jobs()
    Recordings.register = die  # type: ignore[method-assign, assignment]
    job = workspace.imports.begin([folder / f"{SECRET}.xyz"], project=PROJECT)
    workspace.runner.wait(job.id)


@pytest.mark.parametrize("kept", [True, False])
def test_the_recording_is_in_its_project_after_the_restart(tmp_path: Path, kept: bool) -> None:
    (tmp_path / f"{SECRET}.xyz").write_text("1 2 3\n4 5 6\n")
    assert call(import_until_killed, tmp_path, kept) == -signal.SIGKILL
    settings = settings_in(tmp_path)
    assert read_manifest(settings.workspace / "sequences" / SECRET).project == PROJECT
    with serving(settings) as served:
        tokens = served.workspace.labels.tokens
        ada, bob = (Client(served.url, tokens.add("annotator", name)) for name in ("ada", "bob"))
        with ada, bob:
            assert [each.id for each in bob.sequences()] == []
            with pytest.raises(NotFoundError):
                bob[SECRET].labels()
            assert ada[SECRET].manifest.project == PROJECT
            if kept:
                jobs = lambda: ada.call("GET", "/jobs").json()  # noqa: E731
                eventually(lambda: [job["state"] for job in jobs()] == ["done"])
            assert bob.call("GET", "/jobs").json() == []
            assert [each.id for each in bob.sequences()] == []
