"""The client itself: its connection, recordings, imports and jobs."""

from __future__ import annotations

import json
import os
import re
import uuid
from collections.abc import Sequence
from typing import Any, Self
from urllib.parse import parse_qs, urlsplit, urlunsplit

import httpx
from typing_extensions import Unpack

from pointbrush.client.accounts import Accounts
from pointbrush.client.answers import JobResult, read, result_of
from pointbrush.client.classifiers import Classifiers
from pointbrush.client.headset_reports import HeadsetReports
from pointbrush.client.projects import Projects
from pointbrush.client.recording import Recording
from pointbrush.client.steps import (
    PATIENCE,
    AsyncLink,
    L,
    Part,
    Request,
    Steps,
    SyncLink,
    finished,
    job_now,
    send,
    started,
    steps,
)
from pointbrush.client.uploads import AnyPath, Files, ImportKeywords, upload
from pointbrush.errors import BadInputError, ConflictError, NotFoundError
from pointbrush.values.exports import ExportFormat
from pointbrush.values.imports import Entry, ImportPreview
from pointbrush.values.jobs import Job
from pointbrush.values.recordings import Manifest
from pointbrush.values.taxonomy import BoxAttribute, Category, Taxonomy, TaxonomyChange

TIMEOUT = 60.0
"""Seconds without a byte until a call fails; a job may take longer."""
ID = re.compile(r"[a-z0-9][a-z0-9._-]{0,63}")
"""Pattern of the ids of recordings."""
URL_VARIABLE, TOKEN_VARIABLE = "POINTBRUSH_SERVER", "POINTBRUSH_TOKEN"


class Server(Part[L]):
    """The calls that ``Client`` and ``AsyncClient`` share."""

    @steps
    def call(self, /, method: str, path: str, **options: Any) -> Steps[httpx.Response]:
        """Make any call and return its answer; ``path`` is relative to ``/api/v1``.

        ``options`` are passed to httpx.  Raises the errors of ``pointbrush.errors``;
        UnavailableError if no server answers.
        """
        return (yield from send(Request(method, path, options, idempotent=method == "GET")))

    # ── recordings ───────────────────────────────────────────────────────────────────────

    @steps
    def sequences(self) -> Steps[list[Recording[L]]]:
        """Return all readable recordings, by name."""
        listed = yield from self._get(list[Manifest], "/sequences")
        return [Recording(self._link, entry) for entry in listed if entry.damaged is None]

    @steps
    def search(self, q: str = "", /, **wanted: str) -> Steps[list[Manifest]]:
        """Return the recordings with ``q`` in their name that match all criteria in ``wanted``.

        Criteria: project, class_, label, state (of a task), person.
        """
        query = {name.rstrip("_"): value for name, value in wanted.items()} | {"q": q}
        return self._get(list[Manifest], "/sequences", **query)

    @steps
    def manifests(self) -> Steps[list[Manifest]]:
        """Return the manifests of all recordings, ``damaged`` ones too, by name."""
        return self._get(list[Manifest], "/sequences")

    def _open(self, sequence: str) -> Steps[Recording[L]]:
        return Recording(self._link, (yield from self._get(Manifest, f"/sequences/{sequence}")))

    @steps
    def __getitem__(self, sequence: str) -> Steps[Recording[L]]:
        """Return a recording by its id, or else by its name.

        Raises NotFoundError, and BadInputError for a name that several recordings have.
        """
        if ID.fullmatch(sequence):
            try:
                return (yield from self._open(sequence))
            except NotFoundError:
                pass
        known = yield from self._get(list[Manifest], "/sequences")
        named = [each for each in known if each.name == sequence]
        if len(named) > 1:
            ids = ", ".join(each.id for each in named)
            raise BadInputError(
                f"sequence: expected the name of one recording, got the name of {ids}"
            )
        if not named:
            raise NotFoundError(f"sequence: expected a recording's id or name, got {sequence!r}")
        return Recording(self._link, named[0])

    @steps
    def deleted(self) -> Steps[list[Manifest]]:
        """Return the deleted recordings that can be restored, the last deleted first."""
        return self._get(list[Manifest], "/sequences", deleted="true")

    @steps
    def restore(self, sequence: str) -> Steps[Recording[L]]:
        """Restore a deleted recording by its id or identity, and return it.

        Its id changes if another recording has it now.
        """
        deleted = yield from self._get(list[Manifest], "/sequences", deleted="true")
        # Only a call by identity can be repeated: several deleted recordings may have one id.
        known = (each.identity for each in deleted if sequence in (each.id, each.identity))
        key = next(known, None)
        path = f"/sequences/{key or sequence}/restore"
        found = yield from self._change(Manifest, "POST", path, idempotent=key is not None)
        return Recording(self._link, found)

    # ── imports ──────────────────────────────────────────────────────────────────────────

    @steps
    def start_import(
        self,
        /,
        files: Files | None = None,
        *,
        server_path: AnyPath | None = None,
        patience: float = PATIENCE,
        **options: Unpack[ImportKeywords],
    ) -> Steps[Job]:
        """Start an import and return its job; arguments as of ``import_files``."""
        return _start_import(files, server_path, options, patience)

    @steps
    def import_path(
        self,
        /,
        server_path: AnyPath,
        *,
        progress: bool = False,
        patience: float = PATIENCE,
        **options: Unpack[ImportKeywords],
    ) -> Steps[Recording[L]]:
        """Import a path on the server; the same as ``import_files(server_path=...)``."""
        return self._imported(None, server_path, options, progress, patience)

    @steps
    def import_files(
        self,
        /,
        files: Files | None = None,
        *,
        server_path: AnyPath | None = None,
        progress: bool = False,
        patience: float = PATIENCE,
        **options: Unpack[ImportKeywords],
    ) -> Steps[Recording[L]]:
        """Upload files and folders of this machine, import them as one recording, and wait.

        ``server_path`` imports a path on the server instead of ``files``.  ``options``: fields of
        ``ImportOptions``; paths in them are of uploaded files.  ``progress`` shows a bar.
        ``patience``: seconds for which the server may be away.
        """
        return self._imported(files, server_path, options, progress, patience)

    def _imported(
        self,
        files: Files | None,
        server_path: AnyPath | None,
        options: ImportKeywords,
        progress: bool,
        patience: float,
    ) -> Steps[Recording[L]]:
        job = yield from _start_import(files, server_path, options, patience)
        result = yield from finished(job, progress=progress, patience=patience)
        return (yield from self._open(result["sequence"]))

    @steps
    def preview(
        self,
        /,
        files: Files | None = None,
        *,
        server_path: AnyPath | None = None,
        **options: Unpack[ImportKeywords],
    ) -> Steps[ImportPreview]:
        """Preview an import: format, frames, fps, columns, warnings and more; nothing is imported.

        Arguments as of ``import_files``.  The server keeps uploaded files for an hour: the answer's
        ``upload`` names them to an import.
        """
        request = upload("/imports/preview", files, options, server_path)
        return read(ImportPreview, (yield from send(request)).json())

    @steps
    def entries(self, server_path: AnyPath) -> Steps[list[Entry]]:
        """Return the entries of a folder on the server."""
        body = {"path": str(server_path)}
        return self._change(list[Entry], "POST", "/imports/entries", body, idempotent=False)

    # ── labels by example ────────────────────────────────────────────────────────────────

    @property
    def classifiers(self) -> Classifiers[L]:
        """The classifiers of the workspace."""
        return Classifiers(self._link)

    # ── people ───────────────────────────────────────────────────────────────────────────

    @property
    def accounts(self) -> Accounts[L]:
        """The accounts of people and their tokens, for managers."""
        return Accounts(self._link)

    @property
    def headset_reports(self) -> HeadsetReports[L]:
        """The reports of headset checks."""
        return HeadsetReports(self._link)

    @property
    def projects(self) -> Projects[L]:
        """The projects of the workspace, with their queues of tasks."""
        return Projects(self._link)

    # ── the workspace ────────────────────────────────────────────────────────────────────

    @steps
    def taxonomy(self) -> Steps[list[Category]]:
        """Return the workspace's classes, by number."""
        return list((yield from self._get(Taxonomy, "/taxonomy")).categories)

    @steps
    def box_attributes(self) -> Steps[list[BoxAttribute]]:
        """Return the attributes of boxes beside occluded, truncated and parked."""
        return list((yield from self._get(Taxonomy, "/taxonomy")).attributes)

    @steps
    def change_taxonomy(
        self,
        categories: Sequence[Category] = (),
        attributes: Sequence[BoxAttribute] | None = None,
    ) -> Steps[None]:
        """Add classes, or change the classes with the same numbers.

        ``attributes`` replaces the list of the attributes of boxes.  Labels of a class follow its
        new name.  Raises ConflictError for a change of a number's meaning.
        """
        every = None if attributes is None else tuple(attributes)
        body = TaxonomyChange(tuple(categories), every).to_json()
        yield from self._call("PUT", "/taxonomy", json=body, idempotent=True)

    @steps
    def merge_categories(self, number: int, others: Sequence[int]) -> Steps[None]:
        """Merge other classes into this one: it gets their labels, and they are deleted."""
        body = {"categories": list(others)}
        yield from self._call("POST", f"/taxonomy/{number}/merge", json=body)

    @steps
    def delete_category(self, number: int) -> Steps[None]:
        """Remove a class; raises ConflictError while labels have it."""
        yield from self._call("DELETE", f"/taxonomy/{number}", idempotent=True)

    @steps
    def templates(self) -> Steps[list[str]]:
        """Return the names of the palettes for ``Recording.add_palette``."""
        return list((yield from self._call("GET", "/templates")).json())

    @steps
    def export_formats(self) -> Steps[list[ExportFormat]]:
        """Return the export formats, with the content that each cannot hold."""
        return self._get(list[ExportFormat], "/exports")

    # ── jobs ─────────────────────────────────────────────────────────────────────────────

    @steps
    def jobs(self) -> Steps[list[Job]]:
        """Return the jobs that the server remembers, newest first."""
        return self._get(list[Job], "/jobs")

    @steps
    def job(self, job: str, *, patience: float = 0.0) -> Steps[Job]:
        """Return the current state of a job, by its id.

        ``patience``: seconds for which the server may be away.
        """
        return job_now(job, patience)

    @steps
    def cancel(self, job: str, *, keep: bool = False) -> Steps[Job]:
        """Cancel a job and return it; ``keep`` commits the labels found by a tracking run."""
        try:
            return (yield from self._change(Job, "DELETE", f"/jobs/{job}", keep=json.dumps(keep)))
        except ConflictError:
            ended = yield from job_now(job)
            if ended.state != "cancelled":  # by an earlier call with a lost answer
                raise
            return ended

    @steps
    def wait(
        self, job: Job, *, progress: bool = False, patience: float = PATIENCE
    ) -> Steps[JobResult]:
        """Wait for a job and return its result, as the call that waits for it.

        ``progress`` shows a bar.

        ``patience``: seconds for which the server may be away, such as during a restart.  Raises
        PointbrushError with the error of a failed job, CancelledError, UnavailableError.
        """
        return result_of(job, (yield from finished(job, progress=progress, patience=patience)))


class Client(Server[SyncLink]):
    """A client of a pointbrush server; a context manager, safe to share between threads."""

    def __init__(
        self, url: str = "", token: str = "", *, timeout: float = TIMEOUT, **options: Any
    ) -> None:
        """Connect to a server.

        ``url``: the server's address, with or without the token that the server printed in it.
        Defaults of ``url`` and ``token``: the variables POINTBRUSH_SERVER and POINTBRUSH_TOKEN.
        ``timeout``: seconds without a byte until a call fails.  ``options`` are passed to httpx:
        verify, proxy and others.  Raises BadInputError for no address, or no token.
        """
        super().__init__(SyncLink(httpx.Client(**_address(url, token), timeout=timeout, **options)))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the connection."""
        self._link.http.close()


class AsyncClient(Server[AsyncLink]):
    """A ``Client`` for asynchronous code: use ``async with``, and await each call."""

    def __init__(
        self, url: str = "", token: str = "", *, timeout: float = TIMEOUT, **options: Any
    ) -> None:
        """Connect to a server.

        ``url``: the server's address, with or without the token that the server printed in it.
        Defaults of ``url`` and ``token``: the variables POINTBRUSH_SERVER and POINTBRUSH_TOKEN.
        ``timeout``: seconds without a byte until a call fails.  ``options`` are passed to httpx:
        verify, proxy and others.  Raises BadInputError for no address, or no token.
        """
        http = httpx.AsyncClient(**_address(url, token), timeout=timeout, **options)
        super().__init__(AsyncLink(http))

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *error: object) -> None:
        await self.close()

    async def close(self) -> None:
        """Close the connection."""
        await self._link.http.aclose()


def _address(url: str, token: str) -> dict[str, Any]:
    given = url or os.environ.get(URL_VARIABLE, "")
    parts = urlsplit(given)
    if parts.scheme not in ("http", "https") or not parts.netloc:
        raise BadInputError(f"server: expected http(s)://HOST:PORT, got {given!r}")
    (own,) = parse_qs(parts.query).get("token", [""])
    token = token or own or os.environ.get(TOKEN_VARIABLE, "")
    if not token:
        raise BadInputError(f"token: expected one for the server: set {TOKEN_VARIABLE}")
    path = f"{parts.path.rstrip('/')}/api/v1"
    return {
        "base_url": urlunsplit((parts.scheme, parts.netloc, path, "", "")),
        "headers": {"Authorization": f"Bearer {token}"},
    }


def _start_import(
    files: Files | None, server_path: AnyPath | None, options: ImportKeywords, patience: float
) -> Steps[Job]:
    job = str(uuid.uuid4())
    request = upload("/sequences", files, {"id": job, **options}, server_path, patience=patience)
    return started(job, request)
