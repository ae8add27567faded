"""The connection: one token, one address, jobs that are waited for."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import httpx
from tqdm import tqdm

from pointbrush import errors
from pointbrush.client.recording import Recording
from pointbrush.client.values import raise_for

POLL_SECONDS = 0.2
"""Between two looks at a job."""
ENDED = ("done", "failed", "cancelled")


class Client:
    """A pointbrush server at ``url``; a context manager, and safe to share between threads."""

    def __init__(self, url: str, token: str, *, timeout: float = 60.0) -> None:
        """``timeout`` in seconds, of one call; jobs are waited for as long as they take."""
        self.http = httpx.Client(
            base_url=f"{url.rstrip('/')}/api/v1",
            headers={"Authorization": f"Bearer {token}"},
            timeout=timeout,
        )

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
        self.http.close()

    def call(self, method: str, path: str, **options: Any) -> httpx.Response:
        """Make a call; ``path`` is below ``/api/v1``.

        Raises the errors of ``pointbrush.errors``; UnavailableError when nothing answers.
        """
        try:
            answer = self.http.request(method, path, **options)
        except httpx.HTTPError as error:
            raise errors.UnavailableError(f"url: expected a server that answers: {error}") from None
        raise_for(answer)
        return answer

    # ── recordings ───────────────────────────────────────────────────────────────────────

    def sequences(self) -> list[Recording]:
        """All recordings that can be opened, by name."""
        listed = self.call("GET", "/sequences").json()
        return [Recording(self, entry) for entry in listed if not entry.get("damaged")]

    def __getitem__(self, sequence: str) -> Recording:
        """The recording of an id; raises NotFoundError."""
        return Recording(self, self.call("GET", f"/sequences/{sequence}").json())

    def import_path(self, path: str, *, progress: bool = False, **options: Any) -> Recording:
        """Import a path that the server can read; ``options``: name, fps, format, drop_invalid."""
        job = self.call("POST", "/sequences", json={"path": path, **options}).json()
        return self[self.wait(job, progress=progress)["sequence"]]

    def import_files(
        self, files: list[Path], *, progress: bool = False, **options: str
    ) -> Recording:
        """Upload files and import them as one recording."""
        with opened(files) as parts:
            job = self.call("POST", "/sequences", files=parts, data=options).json()
        return self[self.wait(job, progress=progress)["sequence"]]

    def taxonomy(self) -> list[dict[str, Any]]:
        """The workspace's classes: number, name, color."""
        found: list[dict[str, Any]] = self.call("GET", "/taxonomy").json()["categories"]
        return found

    # ── jobs ─────────────────────────────────────────────────────────────────────────────

    def wait(self, job: dict[str, Any], *, progress: bool = False) -> dict[str, Any]:
        """Wait for a job; returns its result.  ``progress`` shows a bar.

        Raises PointbrushError with the job's sentence, CancelledError.
        """
        with tqdm(total=100, disable=not progress, unit="%", desc=job["kind"]) as bar:
            while job["state"] not in ENDED:
                time.sleep(POLL_SECONDS)
                job = self.call("GET", f"/jobs/{job['id']}").json()
                bar.update(round(100 * job["progress"]) - bar.n)
        if job["state"] == "failed":
            raise errors.PointbrushError(job["error"] or "the job failed")
        if job["state"] == "cancelled":
            raise errors.CancelledError("the job was cancelled")
        return job["result"] or {}


@contextlib.contextmanager
def opened(files: list[Path]) -> Iterator[list[tuple[str, tuple[str, Any]]]]:
    """Files as the parts of an upload."""
    with ExitStack() as stack:
        yield [("files", (path.name, stack.enter_context(Path(path).open("rb")))) for path in files]
