"""Jobs outlive the server that ran them, killed or stopped."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import httpx
import numpy as np
import pytest

from pointbrush.workspace import Workspace
from tests.faults.server import ServerProcess, running
from tests.serving import settings_in, surface
from tests.waiting import PATIENCE, eventually

ENDED = ("done", "failed", "cancelled")


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    """Files that take some seconds to import."""
    folder = tmp_path / "recordings" / "walls"
    folder.mkdir(parents=True)
    for index in range(40):
        np.savez(folder / f"{index:03d}.npz", xyz=surface(30_000, index).xyz)
    return folder


def begin(api: httpx.Client, path: Path, name: str) -> str:
    answer = api.post("/sequences", json={"path": str(path), "name": name})
    return str(answer.raise_for_status().json()["id"])


def jobs_of(api: httpx.Client) -> dict[str, dict[str, object]]:
    return {job["id"]: job for job in api.get("/jobs").raise_for_status().json()}


@pytest.mark.parametrize("end", [ServerProcess.kill, ServerProcess.stop])
def test_jobs_go_on_at_the_next_server_with_the_files_they_were_sent(
    tmp_path: Path, recording: Path, end: object
) -> None:
    settings = settings_in(tmp_path)
    short = recording / "000.npz"
    roots = {"POINTBRUSH_IMPORT_ROOTS": str(recording)}
    with running(settings.workspace, **roots) as first, first.api() as api:
        ended = begin(api, short, "short")
        eventually(lambda: jobs_of(api)[ended]["state"] == "done")
        under_way, queued = begin(api, recording, "long"), begin(api, short, "next")
        files = {"files": ("sent.npz", short.read_bytes())}
        sent = str(api.post("/sequences", files=files).raise_for_status().json()["id"])
        files = {"files": ("000.label", np.full(30_000, 40, np.uint32).tobytes())}
        answer = api.post("/sequences/short/annotations", files=files)
        labels = str(answer.raise_for_status().json()["id"])
        eventually(lambda: 0 < float(str(jobs_of(api)[under_way]["progress"])) < 1)
        end(first)  # type: ignore[operator]
    with running(settings.workspace, **roots) as second, second.api() as api:
        assert set(jobs_of(api)) == {ended, under_way, queued, sent, labels}
        assert jobs_of(api)[ended]["state"] == "done"
        eventually(lambda: all(job["state"] in ENDED for job in jobs_of(api).values()))
        assert {job["state"] for job in jobs_of(api).values()} == {"done"}, jobs_of(api)
        names = {entry["id"]: entry["frames"] for entry in api.get("/sequences").json()}
        assert names == {"short": 1, "long": 40, "next": 1, "sent": 1}
        assert len(api.get("/sequences/short/edits").json()) == 1, "labels that were sent, once"
        uploads = settings.workspace / "uploads"
        eventually(lambda: list(uploads.iterdir()) == [])


def test_a_job_of_one_server_is_seen_and_cancelled_at_another(tmp_path: Path) -> None:
    settings = settings_in(tmp_path)
    with closing(Workspace(settings)) as here, closing(Workspace(settings)) as there:
        for workspace in (here, there):
            workspace.keep_jobs()
        told: list[object] = []
        there.subscribe(told.append)
        job = here.imports.begin_sample(frames=500)
        assert there.jobs.get(job.id).state == "queued"
        eventually(lambda: any(getattr(event, "id", "") == job.id for event in told))
        there.jobs.cancel(job.id, keep=False)
        assert here.runner.wait(job.id, PATIENCE).state == "cancelled"
        eventually(lambda: there.jobs.get(job.id).state == "cancelled")
