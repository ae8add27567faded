"""Every described call, with generated good and bad input: no 5xx, nothing undescribed."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, given, settings
from schemathesis.config import SchemathesisConfig
from schemathesis.core.failures import FailureGroup
from schemathesis.generation import GenerationMode
from schemathesis.specs.openapi.checks import negative_data_rejection, positive_data_acceptance

from tests.serving import TOKEN, add_sequence, serving, settings_in

POINTS = 300
SEMANTIC = (
    "POST /api/v1/sequences",
    "POST /api/v1/imports/preview",
    "PATCH /api/v1/sequences/{seq}",
    "POST /api/v1/sequences/{seq}/floor",
    "POST /api/v1/sequences/{seq}/frames/{i}/strokes",
    "POST /api/v1/sequences/{seq}/frames/{i}/object",
    "POST /api/v1/sequences/{seq}/labels/{id}/merge",
    "POST /api/v1/sequences/{seq}/labels/{id}/split",
    "POST /api/v1/sequences/{seq}/tracking",
    "PUT /api/v1/sequences/{seq}/frames/{i}/annotation",
    "GET /api/v1/sequences/{seq}/export",
    "POST /api/v1/sequences/{seq}/annotations",
    "PUT /api/v1/taxonomy",
    "POST /api/v1/sequences/{seq}/palette",
    "PUT /api/v1/sequences/{seq}/palette/order",
    "POST /api/v1/sequences/{seq}/frames/{i}/copy",
    "POST /api/v1/sequences/{seq}/frames/{i}/clear",
    "PUT /api/v1/sequences/{seq}/review",
    "GET /api/v1/sequences/{seq}/checks",
    "GET /api/v1/sequences/{seq}/agreement",
    "GET /api/v1/sequences/{seq}/frames/{i}/agreement",
    "PUT /api/v1/sequences/{seq}/frames/{i}/review",
)
"""Calls whose input is also checked for sense: an invertible matrix, directions with a length."""


@schemathesis.serializer("application/x-npy")
def npy(_context: Any, _value: Any) -> bytes:
    """An array of the right length."""
    stream = io.BytesIO()
    np.save(stream, np.zeros(POINTS, np.uint16))
    return stream.getvalue()


@pytest.fixture(scope="module")
def described(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
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
        yield schemathesis.openapi.from_url(
            f"{served.url}/api/v1/openapi.json", config=SchemathesisConfig()
        )


@pytest.mark.parametrize("mode", list(GenerationMode))
def test_every_call_keeps_to_its_description(described: Any, mode: GenerationMode) -> None:
    failures = []
    for result in described.get_all_operations():
        try:
            exercise(result.ok(), mode)
        except (AssertionError, FailureGroup) as error:
            failures.append(f"{result.ok().label}: {error}")
    assert not failures, "\n".join(failures)


def exercise(operation: Any, mode: GenerationMode) -> None:
    @settings(
        max_examples=10,
        derandomize=True,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(case=operation.as_strategy(generation_mode=mode))
    def call(case: Any) -> None:
        if mode is GenerationMode.POSITIVE and case.path_parameters:
            # The recording that is there, so that calls get past 404.
            known = {"seq": "wall", "i": 0, "c": 0}
            case.path_parameters |= {k: known[k] for k in known if k in case.path_parameters}
            if operation.label == "DELETE /api/v1/sequences/{seq}":
                case.path_parameters = {"seq": "spare"}
        response = case.call(headers={"Authorization": f"Bearer {TOKEN}"})
        assert response.status_code < 500, response.text
        excluded = [positive_data_acceptance] if operation.label in SEMANTIC else []
        if case.media_type == "multipart/form-data":
            # A form has text alone: what is generated as a boolean arrives as a name.
            excluded.append(negative_data_rejection)
        case.validate_response(response, excluded_checks=excluded)

    call()
