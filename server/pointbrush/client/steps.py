"""Calls written once for blocking and for asynchronous code.

A method of the client is a generator of steps: it yields a request or a pause and receives the
answer.  ``SyncLink`` runs the steps and blocks, ``AsyncLink`` awaits them.
"""

from __future__ import annotations

import asyncio
import itertools
import logging
import sys
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Coroutine, Generator, Mapping
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import partial, wraps
from pathlib import Path
from typing import Any, Concatenate, Generic, ParamSpec, TypeAlias, cast, overload

import httpx
from tqdm import tqdm
from typing_extensions import TypeVar

from pointbrush import errors
from pointbrush.client.answers import raise_for, read
from pointbrush.values.base import Body
from pointbrush.values.jobs import Job

log = logging.getLogger(__name__)

ATTEMPTS = 4
"""Attempts of a call that has no answer, or an answer of a status in ``LATER``."""
PATIENCE = 300.0
"""Seconds to wait for a job while its server does not answer, such as during a restart."""
FIRST_WAIT = 0.2
"""Seconds before the second attempt; doubled before each further attempt."""
LONGEST_WAIT = 5.0
"""Maximum seconds between two attempts, also if the server asks for more."""
LATER = (429, 503)
"""Statuses of an answer to a call without effect; another attempt may succeed."""
UNREACHABLE = (502, 504)
"""Statuses of a proxy without its server; the call may have had its effect."""
POLL_SECONDS = 0.2
"""Seconds between two polls of a job."""
ENDED = ("done", "failed", "cancelled")


@dataclass(frozen=True, slots=True)
class Request:
    """A call; ``into``: file for the body of a successful answer.

    ``idempotent``: the call is repeated if the connection is lost before the answer.
    ``patience``: minimum seconds in which the call is repeated, beyond ``ATTEMPTS`` too.
    """

    method: str
    path: str
    options: dict[str, Any] = field(default_factory=dict)
    into: Path | None = None
    idempotent: bool = False
    patience: float = 0.0


@dataclass(frozen=True, slots=True)
class Pause:
    """A pause of some seconds."""

    seconds: float


class LostError(errors.UnavailableError):
    """No answer came; the call may have had its effect."""


T = TypeVar("T")
P = ParamSpec("P")
Step: TypeAlias = Request | Pause
Steps: TypeAlias = Generator[Step, httpx.Response | None, T]
"""Steps of a method that returns a ``T``: from ``Client`` directly, from AsyncClient awaited."""


def send(request: Request) -> Steps[httpx.Response]:
    """Make a call, repeated where that is safe, and return the answer.

    Raises the errors of ``pointbrush.errors``; LostError if no server answers.
    """
    wait, retried_statuses = FIRST_WAIT, (*LATER, *UNREACHABLE) if request.idempotent else LATER
    deadline = time.monotonic() + request.patience
    for attempt in itertools.count(1):
        last = attempt >= ATTEMPTS and time.monotonic() >= deadline
        try:
            answer = yield request
        except httpx.HTTPError as error:
            reason = str(error) or type(error).__name__
            if not request.idempotent or last:
                raise LostError(f"url: expected a server that answers: {reason}") from None
        else:
            assert answer is not None  # noqa: S101 – links answer requests
            if answer.status_code not in retried_statuses or last:
                raise_for(answer)
                return answer
            reason = f"{answer.status_code} {answer.reason_phrase}"
            wait = max(wait, _seconds(answer.headers.get("Retry-After", "")))
        if attempt == ATTEMPTS:
            log.warning("the server does not answer; the call is repeated: %s", reason)
        yield Pause(min(wait, LONGEST_WAIT))
        wait *= 2
    raise AssertionError("the last attempt returns or raises")


def _seconds(text: str) -> float:
    return float(text) if text.isdecimal() else 0.0


class _Link(ABC):
    """Runs steps to their end, on a blocking or an asynchronous connection."""

    async def _take(self, steps: Steps[T]) -> T:
        with closing(steps):
            resume: Callable[[], Step] = partial(next, steps)
            while True:
                try:
                    step = resume()
                except StopIteration as end:
                    return cast(T, end.value)
                resume = partial(steps.send, None)
                if isinstance(step, Pause):
                    await self._pause(step.seconds)
                    continue
                try:
                    resume = partial(steps.send, await self._answer(step))
                except httpx.HTTPError as error:
                    resume = partial(steps.throw, error)

    @abstractmethod
    async def _pause(self, seconds: float) -> None:
        """Pause for some seconds."""

    @abstractmethod
    async def _answer(self, request: Request) -> httpx.Response:
        """Make a call and return its answer, read whole or written to the request's file."""


class SyncLink(_Link):
    """A connection that blocks the calling thread; safe to share between threads."""

    def __init__(self, http: httpx.Client) -> None:
        self.http = http

    def run(self, steps: Steps[T]) -> T:
        """Run steps to their end and return their result."""
        taking = self._take(steps)
        try:
            taking.send(None)  # runs to the end: its awaits block and never suspend
        except StopIteration as end:
            return cast(T, end.value)
        raise AssertionError("a connection that blocks never waits")

    async def _pause(self, seconds: float) -> None:
        time.sleep(seconds)  # blocks, as the other methods do

    async def _answer(self, request: Request) -> httpx.Response:
        with self.http.stream(request.method, request.path, **request.options) as answer:
            if request.into is None or not answer.is_success:
                answer.read()
            else:
                with request.into.open("wb") as file:
                    for block in answer.iter_bytes():
                        file.write(block)
        return answer


class AsyncLink(_Link):
    """A connection that awaits in the running event loop."""

    def __init__(self, http: httpx.AsyncClient) -> None:
        self.http = http

    async def run(self, steps: Steps[T]) -> T:
        """Run steps to their end and return their result."""
        return await self._take(steps)

    async def _pause(self, seconds: float) -> None:
        await asyncio.sleep(seconds)

    async def _answer(self, request: Request) -> httpx.Response:
        async with self.http.stream(request.method, request.path, **request.options) as answer:
            if request.into is None or not answer.is_success:
                await answer.aread()
            else:
                with request.into.open("wb") as file:
                    async for block in answer.aiter_bytes():
                        file.write(block)
        return answer


L = TypeVar("L", bound=SyncLink | AsyncLink, default=SyncLink)


class Part(Generic[L]):
    """A part of the client, which reaches the server by a link; its paths begin with ``place``."""

    def __init__(self, link: L, place: str = "") -> None:
        self._link: L = link
        self._place = place

    def _call(
        self,
        method: str,
        path: str = "",
        *,
        params: Mapping[str, Any] | None = None,
        into: Path | None = None,
        idempotent: bool = False,
        **options: Any,
    ) -> Steps[httpx.Response]:
        """Make a call; parameters that are None are left out, ``options`` are passed to httpx."""
        options["params"] = {n: value for n, value in (params or {}).items() if value is not None}
        repeated = idempotent or method == "GET"
        return send(Request(method, self._place + path, options, into, repeated))

    def _get(self, kind: type[T], path: str = "", **query: Any) -> Steps[T]:
        """Return an answer as a value of ``kind``; the query as of ``_call``."""
        return read(kind, (yield from self._call("GET", path, params=query)).json())

    def _change(
        self,
        kind: type[T],
        method: str,
        path: str = "",
        body: Body | Mapping[str, Any] | None = None,
        *,
        idempotent: bool = True,
        **query: Any,
    ) -> Steps[T]:
        """Make a call with a body as JSON, and return the answer as a value of ``kind``."""
        given = body.to_json() if isinstance(body, Body) else body
        answer = yield from self._call(
            method, path, params=query, idempotent=idempotent, json=given
        )
        return read(kind, answer.json())


class steps(Generic[P, T]):  # noqa: N801 – a decorator
    """Turn a generator of steps into a blocking method or a coroutine, as its object's link is."""

    def __init__(self, function: Callable[Concatenate[Any, P], Steps[T]]) -> None:
        self.function = function
        self.__doc__ = function.__doc__

    @overload
    def __get__(self, part: Part[SyncLink], owner: Any) -> Callable[P, T]: ...
    @overload
    def __get__(self, part: Part[AsyncLink], owner: Any) -> Callable[P, Coroutine[Any, Any, T]]: ...
    @overload
    def __get__(self, part: None, owner: Any) -> Callable[Concatenate[Any, P], Steps[T]]: ...
    def __get__(self, part: Any, owner: Any) -> Any:
        """Bind to an object; return the generator function for the class."""
        if part is None:
            return self.function

        @wraps(self.function)
        def method(*args: P.args, **kwargs: P.kwargs) -> Any:
            return part._link.run(self.function(part, *args, **kwargs))

        return method


def job_now(job: str, patience: float = 0.0) -> Steps[Job]:
    """Return the current state of a job; ``patience`` as of ``Request``."""
    answer = yield from send(Request("GET", f"/jobs/{job}", idempotent=True, patience=patience))
    return read(Job, answer.json())


def started(job: str, request: Request) -> Steps[Job]:
    """Start a job by a call with the job's id in it, and return the job.

    If the connection is lost before the answer, the server is asked for the job, and the call is
    repeated once if the server has none.  Files are uploaded at most twice.
    """
    try:
        return read(Job, (yield from send(replace(request, idempotent=False))).json())
    except LostError:
        try:
            return (yield from job_now(job, request.patience))
        except errors.NotFoundError:
            return read(Job, (yield from send(replace(request, idempotent=False))).json())


def finished(job: Job, *, progress: bool, patience: float) -> Steps[dict[str, Any]]:
    """Wait for a job and return its result.  ``progress`` shows a bar on a terminal or in Jupyter.

    ``patience``: seconds for which the server may be away.  Raises PointbrushError with the job's
    error, CancelledError, UnavailableError.
    """
    shown = progress and (sys.stderr.isatty() or "ipykernel" in sys.modules)
    with tqdm(total=100, disable=not shown, unit="%", desc=job.kind) as bar:
        while job.state not in ENDED:
            yield Pause(POLL_SECONDS)
            job = yield from job_now(job.id, patience)
            bar.update(round(100 * job.progress) - bar.n)
    if job.state == "failed":
        raise errors.PointbrushError(job.error or "the job failed")
    if job.state == "cancelled":
        raise errors.CancelledError("the job was cancelled")
    return job.result or {}
