"""A real PostgreSQL server for tests: started here, on a free loopback port, gone afterwards."""

from __future__ import annotations

import atexit
import ctypes
import os
import pwd
import shutil
import signal
import subprocess
import tempfile
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import psycopg
import pytest

from pointbrush.teamwork.store import WorkspaceStore
from tests.ports import free_port
from tests.waiting import eventually

SETTINGS = {
    "listen_addresses": "127.0.0.1",
    "unix_socket_directories": "",
    "fsync": "off",  # what is tested is our use of it, not the server's own durability
    "full_page_writes": "off",
    "shared_buffers": "32MB",
    "max_connections": "60",
    "log_min_messages": "fatal",
}
PR_SET_PDEATHSIG = 1


@dataclass
class PostgresServer:
    """A running server; ``restart`` after ``stop`` serves the same data on the same port."""

    bin: Path
    data: Path
    port: int
    user: str | None
    process: subprocess.Popen[bytes] | None = None
    _labels: str | None = None

    def url(self, database: str = "postgres") -> str:
        return f"postgresql://postgres@127.0.0.1:{self.port}/{database}"

    def start(self) -> None:
        options = [f"-c{name}={value}" for name, value in SETTINGS.items()]
        self.process = subprocess.Popen(
            [self.bin / "postgres", "-D", self.data, f"-p{self.port}", *options],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            preexec_fn=_end_with_parent,
            cwd=self.data,
            **_as_user(self.user),
        )
        eventually(lambda: self._answers() or self.process.poll() is not None, every=0.05)
        assert self.process.poll() is None, "PostgreSQL did not start"

    def _answers(self) -> bool:
        try:
            psycopg.connect(self.url(), connect_timeout=30).close()
        except psycopg.OperationalError:
            return False
        return True

    def stop(self) -> None:
        if self.process is not None:
            self.process.send_signal(signal.SIGQUIT)
            self.process.wait()
            self.process = None

    def new_database(self) -> str:
        """The URL of a new, empty database."""
        name = f"t{uuid.uuid4().hex[:12]}"
        with psycopg.connect(self.url(), autocommit=True) as connection:
            connection.execute(f"CREATE DATABASE {name}")
        return self.url(name)

    def new_labels(self) -> str:
        """The URL of a new label database, as copied from one: all migrations take long."""
        if self._labels is None:
            self._labels = self.new_database()
            WorkspaceStore(self._labels).close()
        with psycopg.connect(self.url(), autocommit=True) as connection:
            template, name = self._labels.rpartition("/")[2], f"t{uuid.uuid4().hex[:12]}"
            others = "SELECT 1 FROM pg_stat_activity WHERE datname = %s"
            eventually(lambda: connection.execute(others, [template]).fetchone() is None)
            connection.execute(f"CREATE DATABASE {name} TEMPLATE {template}")
        return self.url(name)


@cache
def _empty_cluster(binaries: Path, user: str | None) -> Path:
    """Make the files of a server without databases, once: copying them takes a tenth of that."""
    home = Path(tempfile.mkdtemp(prefix="pointbrush-cluster-"))
    atexit.register(shutil.rmtree, home, ignore_errors=True)
    if user is not None:
        shutil.chown(home, user)
    data = home / "data"
    subprocess.run(
        [binaries / "initdb", "-D", data, "-U", "postgres", "-A", "trust", "-N", "-E", "UTF8"],
        check=True,
        stdout=subprocess.DEVNULL,
        cwd=home,
        **_as_user(user),
    )
    return data


@contextmanager
def postgres() -> Iterator[PostgresServer]:
    """A running server until the context ends, or skip where no PostgreSQL is installed."""
    found = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"))
    on_path = shutil.which("initdb")
    if not found and on_path is None:
        pytest.skip("no PostgreSQL server is installed (no initdb)")
    binaries = found[-1].parent if found else Path(str(on_path)).parent
    home = Path(tempfile.mkdtemp(prefix="pointbrush-postgres-"))
    user = _server_user()
    if user is not None:
        shutil.chown(home, user)
    data = home / "data"
    subprocess.run(["cp", "-a", _empty_cluster(binaries, user), data], check=True)
    server = PostgresServer(binaries, data, free_port(), user)
    server.start()
    yield server
    server.stop()
    # Hundreds of databases are 100,000 files: nobody need wait until they are gone.
    subprocess.run(["sh", "-c", 'rm -rf "$0" &', home], check=True)


@pytest.fixture(scope="session")
def postgres_server() -> Iterator[PostgresServer]:
    """A running server, or skip where no PostgreSQL is installed."""
    with postgres() as server:
        yield server


@pytest.fixture
def postgres_url(postgres_server: PostgresServer) -> str:
    """The URL of a database of this test's own."""
    return postgres_server.new_database()


@pytest.fixture
def labels_url(postgres_server: PostgresServer) -> str:
    """The URL of a label database of this test's own, without recordings."""
    return postgres_server.new_labels()


def _server_user() -> str | None:
    """PostgreSQL refuses to run as root; its package comes with a user."""
    if os.geteuid() != 0:
        return None
    for name in ("postgres", "nobody"):
        try:
            return pwd.getpwnam(name).pw_name
        except KeyError:
            continue
    pytest.skip("PostgreSQL does not run as root, and there is no user for it")


def _as_user(user: str | None) -> dict[str, str | list[str]]:
    return {} if user is None else {"user": user, "group": user, "extra_groups": []}


def _end_with_parent() -> None:
    """The server must not outlive a test run that is killed."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGQUIT)
