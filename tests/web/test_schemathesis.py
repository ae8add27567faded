"""Every described call, with generated good and bad input: no 5xx, nothing undescribed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import httpx
import pytest
from schemathesis.core.failures import FailureGroup
from schemathesis.generation import GenerationMode

from tests.serving import TOKEN, add_sequence, serving, settings_in
from tests.web.described import POINTS, described, exercise


@pytest.fixture(scope="module")
def description(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    folder = tmp_path_factory.mktemp("described")
    (folder / "inbox").mkdir()
    chosen = settings_in(
        folder,
        import_roots=str(folder / "inbox"),
        requests_per_second=1_000_000,
        wrong_tokens_per_minute=1_000_000,
    )
    for name in ("wall", "spare"):
        add_sequence(chosen, name, frames=2, points=POINTS)
    with serving(chosen) as served:
        labels = f"{served.url}/api/v1/sequences/wall/labels"
        httpx.post(labels, json={"name": "pin"}, headers=served.headers)
        yield described(served.url)


def require_no_fault(response: Any) -> None:
    assert response.status_code < 500, response.text


@pytest.mark.parametrize("mode", list(GenerationMode))
def test_every_call_keeps_to_its_description(description: Any, mode: GenerationMode) -> None:
    failures = []
    for result in description.get_all_operations():
        try:
            exercise(result.ok(), mode, [(TOKEN, True)], require_no_fault)
        except (AssertionError, FailureGroup) as error:
            failures.append(f"{result.ok().label}: {error}")
    assert not failures, "\n".join(failures)
