"""The connection: one token, one address, recordings and jobs."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import httpx

from pointbrush.client.recording import Recording
from pointbrush.client.steps import (
    AsyncLink,
    L,
    Part,
    Request,
    Steps,
    SyncLink,
    finished,
    job_now,
    send,
    steps,
)
from pointbrush.client.values import Category, Job, Manifest, parts_of, read

TIMEOUT = 60.0
"""Seconds of one call without a byte; jobs are waited for as long as they take."""


class Server(Part[L]):
    """Calls of a server that ``Client`` and ``AsyncClient`` share."""

    @steps
    def call(self, /, method: str, path: str, **options: Any) -> Steps[httpx.Response]:
        """Make any call; ``path`` is below ``/api/v1``, ``options`` are those of httpx.

        Raises the errors of ``pointbrush.errors``; UnavailableError when nothing answers.
        """
        return (yield from send(Request(method, path, options, again=method == "GET")))

    # ── recordings ───────────────────────────────────────────────────────────────────────

    @steps
    def sequences(self) -> Steps[list[Recording[L]]]:
        """Return all recordings that can be opened, by name."""
        listed = yield from self._manifests()
        return [Recording(self._link, entry) for entry in listed if entry.damaged is None]

    @steps
    def manifests(self) -> Steps[list[Manifest]]:
        """Return the facts of all recordings, also of ``damaged`` ones, by name."""
        return (yield from self._manifests())

    def _manifests(self, query: str = "") -> Steps[list[Manifest]]:
        answer = yield from send(Request("GET", f"/sequences{query}", again=True))
        return [read(Manifest, entry) for entry in answer.json()]

    def _open(self, sequence: str) -> Steps[Recording[L]]:
        answer = yield from send(Request("GET", f"/sequences/{sequence}", again=True))
        return Recording(self._link, read(Manifest, answer.json()))

    @steps
    def __getitem__(self, sequence: str) -> Steps[Recording[L]]:
        """Return the recording of an id; raises NotFoundError."""
        return (yield from self._open(sequence))

    @steps
    def deleted(self) -> Steps[list[Manifest]]:
        """Return deleted recordings that can be restored, newest first."""
        return (yield from self._manifests("?deleted=true"))

    @steps
    def restore(self, sequence: str) -> Steps[Recording[L]]:
        """Bring a deleted recording back by its id or identity; its id may be another one now."""
        answer = yield from send(Request("POST", f"/sequences/{sequence}/restore"))
        return Recording(self._link, read(Manifest, answer.json()))

    # ── imports ──────────────────────────────────────────────────────────────────────────

    @steps
    def start_import(self, /, files: Sequence[Path] | str, **options: Any) -> Steps[Job]:
        """Start what ``import_path`` and ``import_files`` wait for; returns the job."""
        return read(Job, (yield from _import("/sequences", files, options)).json())

    @steps
    def import_path(
        self, /, path: str, *, progress: bool = False, **options: Any
    ) -> Steps[Recording[L]]:
        """Import a path that the server can read, and wait; ``progress`` shows a bar.

        ``options``: name, fps, format, columns, delimiter, scale, up, topic, poses, drop_invalid.
        """
        return (yield from self._imported(path, options, progress=progress))

    @steps
    def import_files(
        self, /, files: Sequence[Path], *, progress: bool = False, **options: Any
    ) -> Steps[Recording[L]]:
        """Upload files and folders, import them as one recording, and wait."""
        return (yield from self._imported(files, options, progress=progress))

    def _imported(
        self, files: Sequence[Path] | str, options: dict[str, Any], *, progress: bool
    ) -> Steps[Recording[L]]:
        job = read(Job, (yield from _import("/sequences", files, options)).json())
        result = yield from finished(job, progress=progress)
        return (yield from self._open(result["sequence"]))

    @steps
    def preview(self, /, files: Sequence[Path] | str, **options: Any) -> Steps[dict[str, Any]]:
        """Return what an import would do: format, frames, fps, columns, warnings, ….

        Uploaded files wait an hour for an import that names them as ``upload``.
        """
        found: dict[str, Any] = (yield from _import("/imports/preview", files, options)).json()
        return found

    # ── the workspace ────────────────────────────────────────────────────────────────────

    @steps
    def taxonomy(self) -> Steps[list[Category]]:
        """Return the workspace's classes, by number."""
        answer = yield from send(Request("GET", "/taxonomy", again=True))
        return [read(Category, entry) for entry in answer.json()["categories"]]

    @steps
    def templates(self) -> Steps[list[str]]:
        """Return the names of palettes that ``Recording.add_palette`` takes."""
        return list((yield from send(Request("GET", "/templates", again=True))).json())

    # ── jobs ─────────────────────────────────────────────────────────────────────────────

    @steps
    def jobs(self) -> Steps[list[Job]]:
        """Return all remembered jobs, newest first."""
        answer = yield from send(Request("GET", "/jobs", again=True))
        return [read(Job, entry) for entry in answer.json()]

    @steps
    def job(self, job: str) -> Steps[Job]:
        """Return a job as it is now, by its id."""
        return (yield from job_now(job))

    @steps
    def cancel(self, job: str, *, keep: bool = False) -> Steps[Job]:
        """Ask a job to stop; ``keep`` commits what a tracking run has found."""
        query = {"keep": json.dumps(keep)}
        answer = yield from send(Request("DELETE", f"/jobs/{job}", {"params": query}))
        return read(Job, answer.json())

    @steps
    def wait(self, job: Job, *, progress: bool = False) -> Steps[dict[str, Any]]:
        """Wait for a job; returns its result.  ``progress`` shows a bar.

        Raises PointbrushError with the job's sentence, CancelledError.
        """
        return (yield from finished(job, progress=progress))


class Client(Server[SyncLink]):
    """A pointbrush server at ``url``; a context manager, and safe to share between threads."""

    def __init__(self, url: str, token: str, *, timeout: float = TIMEOUT, **options: Any) -> None:
        """``timeout`` in seconds, of one call; ``options`` go to httpx: verify, proxy, …."""
        super().__init__(SyncLink(httpx.Client(**_address(url, token), timeout=timeout, **options)))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the connection."""
        self._link.http.close()


class AsyncClient(Server[AsyncLink]):
    """The same for code that awaits: ``async with``, and every call of ``Client`` a coroutine."""

    def __init__(self, url: str, token: str, *, timeout: float = TIMEOUT, **options: Any) -> None:
        """``timeout`` in seconds, of one call; ``options`` go to httpx: verify, proxy, …."""
        http = httpx.AsyncClient(**_address(url, token), timeout=timeout, **options)
        super().__init__(AsyncLink(http))

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self.close()

    async def close(self) -> None:
        """Close the connection."""
        await self._link.http.aclose()


def _address(url: str, token: str) -> dict[str, Any]:
    return {
        "base_url": f"{url.rstrip('/')}/api/v1",
        "headers": {"Authorization": f"Bearer {token}"},
    }


def _import(
    path: str, files: Sequence[Path] | str, options: dict[str, Any]
) -> Steps[httpx.Response]:
    given = {name: value for name, value in options.items() if value is not None}
    if isinstance(files, str):
        return send(Request("POST", path, {"json": {"path": files, **given}}))
    texts = {name: _text(value) for name, value in given.items()}
    return send(Request("POST", path, {"files": parts_of(files), "data": texts}))


def _text(value: Any) -> str:
    """Return an option as a form has it."""
    if isinstance(value, str):
        return value
    return ",".join(value) if isinstance(value, list | tuple) else json.dumps(value)
