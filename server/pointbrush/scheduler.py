"""Jobs on a Dask cluster instead of local processes, for when one machine is not enough."""

from __future__ import annotations

import importlib
import socket
from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import Any, TypeVar
from urllib.parse import urlsplit

from pointbrush.errors import BadInputError, UnavailableError

T = TypeVar("T")
CONNECT_SECONDS = 10


class DisconnectedError(Exception):
    """The scheduler is another one by now, or away: what it was given is forgotten."""


class DaskExecutor(Executor):
    """Runs on the workers of a scheduler; they need pointbrush and the workspace's folder.

    Raises BadInputError for what is no address or without ``distributed``, UnavailableError when
    nobody answers there.
    """

    def __init__(self, address: str) -> None:
        require_address(address)
        try:
            distributed: Any = importlib.import_module("distributed")
        except ImportError:
            raise BadInputError(
                "scheduler: expected Dask to be installed: pip install 'pointbrush[dask]'"
            ) from None
        try:
            self._client = distributed.Client(
                address, timeout=CONNECT_SECONDS, set_as_default=False
            )
        except (OSError, ValueError) as error:
            raise UnavailableError(
                f"scheduler: expected a Dask scheduler at {address}: {error}"
            ) from None
        self._pool = self._client.get_executor(pure=False)

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """Run ``fn`` on a worker, once; raises DisconnectedError when the scheduler has gone."""
        if self._client.status != "running":
            raise DisconnectedError
        future: Future[T] = self._pool.submit(fn, *args, retries=0, **kwargs)
        return future

    @property
    def connected(self) -> bool:
        """Whether the scheduler is the one that the work was given to."""
        return bool(self._client.status == "running")

    def require_answer(self) -> None:
        """Raise UnavailableError unless the scheduler answers and has workers."""
        try:
            workers = self._client.scheduler_info(n_workers=-1)["workers"]
            alive = self._client.status == "running"
        except Exception:
            alive, workers = False, {}
        if not alive:
            raise UnavailableError("expected the Dask scheduler to answer; it is looked for again")
        if not workers:
            raise UnavailableError("expected workers at the Dask scheduler, there are none")

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Leave the cluster, which goes on."""
        self._pool.shutdown(wait=wait and not cancel_futures)
        self._client.close()


def require_address(address: str) -> tuple[str, int]:
    """Host and port of ``tcp://host:port`` or ``tls://host:port``; raises BadInputError."""
    parts = urlsplit(address)
    try:
        host, port = parts.hostname, parts.port
    except ValueError:
        host, port = None, None
    if parts.scheme not in ("tcp", "tls") or host is None or port is None:
        raise BadInputError(f"scheduler: expected tcp://host:port, got {address!r}")
    return host, port


def own_host(address: str) -> str:
    """This machine's address as the scheduler's neighbours see it: workers report to it."""
    host, port = require_address(address)
    try:
        family, kind, proto, _, target = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
        with socket.socket(family, kind, proto) as probe:
            probe.connect(target)  # sends nothing, only chooses the way
            return str(probe.getsockname()[0])
    except OSError as error:
        raise UnavailableError(f"scheduler: expected a way to {address}: {error}") from None
