"""Runs the app: one uvicorn server, one line when it is ready, an orderly end."""

from __future__ import annotations

import contextlib
import ctypes
import gc
import os
import signal
import socket
import sys
import tempfile
import threading
from pathlib import Path

import uvicorn

from pointbrush.errors import BadInputError
from pointbrush.labels import Commit
from pointbrush.settings import Settings
from pointbrush.web.app import create_app
from pointbrush.web.idle_timeout import idle_timeout_protocol
from pointbrush.web.log_limits import limit_lines
from pointbrush.web.logs import FORMATS, log_events, write_json
from pointbrush.web.security.clients import is_loopback
from pointbrush.web.security.tls import Certificate, certificate, fingerprint
from pointbrush.web.websocket_protocol import WebSocketProtocol
from pointbrush.work.events import Event
from pointbrush.workspace import Workspace

DRAIN_SECONDS = 3
"""Time for received edits, and again for requests; with the end of jobs, less than 10 s."""
BACKLOG = 512
MOST_FILES = 65_536
SWITCH_SECONDS = 0.0005
READY_AFTER = 1.5
"""Seconds from the first edit to the start of a worker, so that first strokes are not slowed."""
M_MMAP_THRESHOLD, M_ARENA_MAX = -3, -8
"""glibc's numbers of these options (malloc.h)."""
MAPPED_BYTES = 4 << 20
"""Blocks from this size on are mapped separately: copies of frames, not temporary arrays."""
ARENAS = 4
"""Heaps that threads share."""


def run(workspace: Workspace, settings: Settings) -> None:
    """Serve until interrupted.

    Prints ``pointbrush ready at URL`` once it listens, and on a network also a QR code of it.
    Raises BadInputError if the address is unavailable or not allowed.
    """
    # By default, threads switch the GIL every 5 ms; a stroke's commit in a thread takes the GIL
    # dozens of times, while the event loop sends all the time.
    sys.setswitchinterval(SWITCH_SECONDS)
    if settings.log_format not in FORMATS:
        raise BadInputError(
            f"log_format: expected {' or '.join(FORMATS)}, got {settings.log_format[:20]!r}"
        )
    app = create_app(workspace, settings)
    limit_lines()
    if settings.log_format == "json":
        write_json(app.state.token)
        log_events(workspace)
    keep_off_memory(app.state.uploads.temporary)
    tls = certificate(settings)
    require_safe(settings, tls)
    app.state.certificate = tls
    allow_many_sockets()
    listener = listen(settings.host, settings.port)
    # A token set by the operator is neither printed nor logged.
    token = "" if settings.admin_token else app.state.token
    url = page_url(settings, listener.getsockname()[1], token, secure=tls is not None)
    wide = tls is not None or not is_loopback(settings.host)
    authority = None if tls is None else tls.authority
    app.state.ready = lambda: announce(url, code=wide, authority=authority)
    if threading.current_thread() is threading.main_thread():
        # uvicorn drains, then raises the signal again: it must raise an exception instead of ending
        # the process, so that the workspace is closed and its worker processes end.
        signal.signal(signal.SIGTERM, signal.default_int_handler)
    settle_memory()
    workspace.loops.begin()
    expect_tracking(workspace)
    try:
        Server(config(app, settings, tls)).run([listener])
    finally:
        listener.close()


class Server(uvicorn.Server):
    """A server that prints its URL when it listens."""

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start, then announce the URL."""
        await super().startup(sockets)
        ready = getattr(self.config.app, "state", None)
        if self.started and ready is not None and hasattr(ready, "ready"):
            ready.ready()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Answer all received edits, then close; uvicorn itself waits for REST only."""
        probe = getattr(getattr(self.config.app, "state", None), "ready_probe", None)
        if probe is not None:
            probe.stopping = True  # proxies stop sending requests here
        hub = getattr(getattr(self.config.app, "state", None), "hub", None)
        if hub is not None:
            self.config.app.state.watching.end()  # type: ignore[union-attr]
            await hub.drain(DRAIN_SECONDS)
        await super().shutdown(sockets)


def config(app: object, settings: Settings, tls: Certificate | None) -> uvicorn.Config:
    """uvicorn's options, with the reasons in docs/streaming.md."""
    return uvicorn.Config(
        app,  # type: ignore[arg-type]
        http=idle_timeout_protocol(settings.stall_seconds),
        ws=WebSocketProtocol,
        ws_per_message_deflate=False,
        ws_max_size=settings.max_message,
        ws_ping_interval=20,
        ws_ping_timeout=20,
        log_level="warning",
        access_log=False,
        server_header=False,
        proxy_headers=False,
        backlog=BACKLOG,
        timeout_keep_alive=30,
        timeout_graceful_shutdown=DRAIN_SECONDS,
        ssl_certfile=None if tls is None else str(tls.certfile),
        ssl_keyfile=None if tls is None else str(tls.keyfile),
    )


def listen(host: str, port: int) -> socket.socket:
    """Return a listening socket; raise BadInputError if the address is in use or not local."""
    try:
        family, kind, proto, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        listener = socket.socket(family, kind, proto)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
    except OSError as error:
        raise BadInputError(
            f"expected a free address to listen on, got {host}:{port}: {error.strerror or error}"
        ) from None
    return listener


def require_safe(settings: Settings, tls: Certificate | None) -> None:
    """Refuse to serve plain HTTP to a network unless the settings allow it."""
    if is_loopback(settings.host) or tls is not None or settings.insecure:
        return
    raise BadInputError(
        f"host: expected a loopback address, or --tls, or --insecure; got {settings.host} with "
        "neither: tokens and labels would cross the network in the clear"
    )


def page_url(settings: Settings, port: int, token: str, *, secure: bool) -> str:
    """The URL a person opens, with the token if it is to be shown."""
    host = settings.host
    if host in ("0.0.0.0", "::"):  # noqa: S104 – compared, not bound
        host = lan_address()
    if ":" in host:
        host = f"[{host}]"
    query = f"/?token={token}" if token else ""
    return f"{'https' if secure else 'http'}://{host}:{port}{query}"


def lan_address() -> str:
    """This machine's address on its network; no packet is sent to find it."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))
        except OSError:
            return socket.gethostname()
        address: str = probe.getsockname()[0]
        return address


def announce(url: str, *, code: bool, authority: Path | None = None) -> None:
    """Print the URL; on a network also a QR code, and how to trust the certificate."""
    print(f"pointbrush ready at {url}", flush=True)
    if code:
        import segno

        segno.make(url, micro=False).terminal(out=sys.stdout, compact=True)
    if authority is not None:
        trust = url.partition("/?")[0] + "/trust"
        print(f"the headset's warning about the certificate is explained at {trust}")
        print(f"fingerprint of its authority: {fingerprint(authority)}")
    sys.stdout.flush()


def keep_off_memory(temporary: Path) -> None:
    """Put temporary files, of worker processes too, on the workspace's disk.

    The system's folder for them is often in memory, which an upload would fill.  An operator can
    set another folder by TMPDIR.
    """
    if "TMPDIR" not in os.environ:
        with contextlib.suppress(OSError):  # read-only: nothing is uploaded
            temporary.mkdir(parents=True, exist_ok=True)
        os.environ["TMPDIR"] = str(temporary)
        tempfile.tempdir = None
    # Called now, because it writes a file, for which the disk may have no space later.
    tempfile.gettempdir()


def settle_memory() -> None:
    """Exclude permanent objects from garbage collection, and return freed memory to the system.

    Modules and models are 160,000 objects: a collection of all of them blocks the server for
    0.1 s.
    """
    give_large_blocks_back()
    gc.freeze()  # without a collection: imports leave hardly any garbage


def give_large_blocks_back() -> None:
    """Make glibc map each large block separately, and share few heaps among the threads.

    By default glibc raises its mapping threshold to the largest freed block: copies of frames then
    come from the heaps of many threads, which keep free memory between used blocks
    (``benchmarks/bench_annotators.py``: 75 MiB a minute).
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None) if sys.platform == "linux" else None
    if mallopt is not None:
        mallopt(M_MMAP_THRESHOLD, MAPPED_BYTES)
        mallopt(M_ARENA_MAX, ARENAS)


def expect_tracking(workspace: Workspace, after: float = READY_AFTER) -> None:
    """Start a worker some seconds ``after`` the first edit: tracking usually follows."""

    def labelled(event: Event) -> None:
        if isinstance(event, Commit):
            undo()
            begin = threading.Timer(after, lambda: workspace.tracking.expect())
            begin.daemon = True
            begin.start()

    undo = workspace.subscribe(labelled)


def allow_many_sockets() -> None:
    """Use as many file descriptors as this process may: idle viewers keep one each."""
    if sys.platform == "win32":
        return
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = MOST_FILES if hard == resource.RLIM_INFINITY else min(MOST_FILES, hard)
    if soft < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
