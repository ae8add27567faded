"""Fixtures that every part's tests share."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import httpx
import pytest
from httpx._config import DEFAULT_TIMEOUT_CONFIG
from hypothesis import HealthCheck, settings

from pointbrush import worker
from tests.forked import FORKSERVER
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

# Workers of this process are forked, too; those of servers in processes of their own are spawned.
worker.START_METHOD = FORKSERVER.get_start_method()

TESTS = Path(__file__).parent
SHARED = TESTS.parent.parent / "shared"
SLOW = frozenset(
    {
        *("e2e", "faults", "samples"),
        *(
            "test_cli.py",
            "test_docs.py",
            "test_examples.py",
            "test_remote.py",
            "test_jobs.py",
            "test_workspace.py",
        ),
        *("labels/test_durability.py", "labels/test_model.py", "sequences/test_large.py"),
        *("streaming/test_links.py", "web/test_ending.py", "web/test_hostile.py"),
        *("web/test_schemathesis.py", "web/test_server.py", "work/test_prepare.py"),
        "work/test_sequence_store.py",
        *("formats/test_corpus.py", "work/test_tracking.py"),
        *("tracking/test_group.py", "tracking/test_jumps.py", "tracking/test_carried.py"),
        *("work/test_deletion.py", "work/test_exports_come_back.py", "work/test_sensor_kind.py"),
        *("streaming/test_long_strokes.py", "streaming/test_socket_people.py"),
    }
)
"""Folders and files that `make quick` leaves out: each takes about ten seconds or more."""


@pytest.fixture
def api(served: Served) -> Iterator[httpx.Client]:
    """A client with the owner's token of the server that a module's tests are about."""
    with httpx.Client(base_url=f"{served.url}/api/v1", headers=served.headers) as client:
        yield client


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        path = item.path.relative_to(TESTS)
        if path.parts[0] in SLOW or path.as_posix() in SLOW:
            item.add_marker(pytest.mark.slow)


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of real recordings beside the checkout."""
    if not (SHARED / "realdata").is_dir():
        pytest.skip("the real recordings (../shared) are not on this machine")
    return SHARED
