"""Fixtures that every part's tests share."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import httpx
import pytest
from httpx._config import DEFAULT_TIMEOUT_CONFIG
from httpx._transports import default as transports
from hypothesis import HealthCheck, settings

from pointbrush.jobs import worker
from tests import measured
from tests.forked import FORKSERVER
from tests.postgres import labels_url, postgres_server, postgres_url  # noqa: F401  # fixtures
from tests.stores import empty_url, filled, store, url  # noqa: F401  # fixtures
from tests.waiting import PATIENCE

if TYPE_CHECKING:
    from tests.serving import Served

# A busy machine must fail no test: how long something takes is the benchmarks' concern.
anywhere = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
# `--hypothesis-profile thorough` looks at more examples than each run of all tests can.
settings.register_profile("thorough", anywhere, max_examples=500)
settings.register_profile("short", anywhere, max_examples=25)
settings.load_profile("short")
# A call without a timeout of its own would give the server up after 5 s.
for phase in ("connect", "read", "write", "pool"):
    setattr(DEFAULT_TIMEOUT_CONFIG, phase, PATIENCE)
# Each client would read the certificates of this machine, which takes longer than a call.
transports.create_ssl_context = cache(transports.create_ssl_context)

# Workers of this process are forked, too; those of servers in processes of their own are spawned.
worker.START_METHOD = FORKSERVER.get_start_method()

TESTS = Path(__file__).parent
SHARED = TESTS.parent.parent / "shared"


@pytest.fixture
def api(served: Served) -> Iterator[httpx.Client]:
    """A client with the owner's token of the server that a module's tests are about."""
    with httpx.Client(base_url=f"{served.url}/api/v1", headers=served.headers) as client:
        yield client


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--measure", action="store_true", help="note how long each file takes")


def pytest_configure(config: pytest.Config) -> None:
    if config.getoption("measure") and not hasattr(config, "workerinput"):
        config.pluginmanager.register(measured.Measuring())


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    measured.arrange(items)


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of real recordings beside the checkout."""
    if not (SHARED / "realdata").is_dir():
        pytest.skip("the real recordings (../shared) are not on this machine")
    return SHARED
