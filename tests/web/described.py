"""Calls generated from the server's own description of itself, and what holds for every answer."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from typing import Any

import hypothesis
import numpy as np
import schemathesis
from hypothesis import HealthCheck, Phase, given, settings
from schemathesis.config import SchemathesisConfig
from schemathesis.generation import GenerationMode
from schemathesis.specs.openapi.checks import (
    ignored_auth,
    negative_data_rejection,
    positive_data_acceptance,
)

from tests.waiting import PATIENCE

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
    "POST /api/v1/sequences/{seq}/boxes",
    "PATCH /api/v1/sequences/{seq}/boxes/{id}",
    "POST /api/v1/sequences/{seq}/boxes/fit",
    "POST /api/v1/sequences/{seq}/tracking",
    "PUT /api/v1/sequences/{seq}/frames/{i}/annotation",
    "PUT /api/v1/sequences/{seq}/annotations",
    "GET /api/v1/sequences/{seq}/export",
    "POST /api/v1/sequences/{seq}/annotations",
    "PUT /api/v1/taxonomy",
    "POST /api/v1/taxonomy/{number}/merge",
    "POST /api/v1/classifiers",
    "POST /api/v1/classifiers/file",
    "POST /api/v1/projects/{p}/webhooks",
    "POST /api/v1/sequences/{seq}/palette",
    "PUT /api/v1/sequences/{seq}/palette/order",
    "POST /api/v1/sequences/{seq}/frames/{i}/copy",
    "POST /api/v1/sequences/{seq}/frames/{i}/clear",
    "PUT /api/v1/sequences/{seq}/review",
    "GET /api/v1/sequences/{seq}/checks",
    "GET /api/v1/sequences/{seq}/agreement",
    "GET /api/v1/sequences/{seq}/frames/{i}/agreement",
    "PUT /api/v1/sequences/{seq}/frames/{i}/review",
    "POST /api/v1/studies",
    "PUT /api/v1/studies/{s}",
)
"""Calls whose input is also checked for sense: an invertible matrix, directions with a length, a
host or a model that is known."""
Callers = Sequence[tuple[str, bool]]
"""Tokens, and whether each lets its owner do everything, so that no good input is refused."""
Look = Callable[[Any], object]


@schemathesis.serializer("application/x-npy")
def npy(_context: Any, _value: Any) -> bytes:
    """An array of the right length."""
    stream = io.BytesIO()
    np.save(stream, np.zeros(POINTS, np.uint16))
    return stream.getvalue()


@schemathesis.serializer("application/zip")
def npz(_context: Any, _value: Any) -> bytes:
    """An archive of an array of the right length for the first frame."""
    stream = io.BytesIO()
    np.savez(stream, **{"0": np.zeros(POINTS, np.uint16)})
    return stream.getvalue()


def described(url: str) -> Any:
    """Read a server's description."""
    return schemathesis.openapi.from_url(f"{url}/api/v1/openapi.json", config=SchemathesisConfig())


def exercise(
    operation: Any,
    mode: GenerationMode,
    callers: Callers,
    look: Look,
    *,
    examples: int = 3,
    seed: int = 0,
) -> None:
    """Call an operation with generated input by each caller; ``look`` is given each answer.

    Raises AssertionError or FailureGroup where an answer is none of the description's.
    """
    senseless = [positive_data_acceptance] if operation.label in SEMANTIC else []
    refused_without = set[str]()

    @hypothesis.seed(seed)
    @settings(
        max_examples=examples,
        database=None,
        deadline=None,
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
        # A form has text alone: what is generated as a boolean arrives as a name.
        form = [negative_data_rejection] if case.media_type == "multipart/form-data" else []
        for token, may_all in callers:
            response = case.call(headers={"Authorization": f"Bearer {token}"}, timeout=PATIENCE)
            look(response)
            refused = [] if may_all else [positive_data_acceptance]
            # The check repeats each successful call without a token and with a wrong one.
            probed = [] if may_all and token not in refused_without else [ignored_auth]
            if response.status_code < 300:
                refused_without.add(token)
            excluded = [*senseless, *form, *refused, *probed]
            case.validate_response(response, excluded_checks=excluded)

    call()
