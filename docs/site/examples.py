"""Examples of the references: calls of the client, and what went to and fro by them."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import httpx

HERE = Path(__file__).parent
CALLS = HERE / "calls.py"
EXCHANGES = HERE / "exchanges.json"
"""A request and an answer of each call of REST, as a server gave it, without texts and bytes.

Written by ``WRITE_EXCHANGES=docs/site/exchanges.json pytest tests/test_reference.py``.
"""
WITHOUT_ONE = {
    "POST /api/v1/sequences/{seq}/source-labels": (
        "The recordings of the examples have no labels in their files, so the call answers 409."
    ),
    "POST /api/v1/sequences/{seq}/sensors/align": (
        "The recordings of the examples have one sensor, so the call answers 409."
    ),
    "POST /api/v1/projects/{p}/merge": (
        "The answer is an edit, or 409 before three people have submitted their copies."
    ),
}
"""Calls whose exchange the examples cannot record, and why."""
MOST_ENTRIES = 2
"""Objects of a list that are kept."""
MOST_VALUES = 16
"""Numbers and texts of a list that are kept: a matrix stays whole."""
OPENING = re.compile(r"^# ((?:[A-Z]\w+)(?:\.\w+)?|rest)$", re.M)


def calls() -> dict[str, str]:
    """Return the example of each method by ``Class.method``, and of classes."""
    parts = OPENING.split(CALLS.read_text(encoding="utf-8"))[1:]
    return {
        name: text.strip()
        for name, text in zip(parts[::2], parts[1::2], strict=True)
        if name != "rest"
    }


def shortened(value: Any) -> Any:
    """Return JSON whose long lists end early."""
    if isinstance(value, dict):
        return {name: shortened(each) for name, each in value.items()}
    if isinstance(value, list):
        most = MOST_ENTRIES if any(isinstance(each, dict | list) for each in value) else MOST_VALUES
        return [shortened(each) for each in value[:most]]
    return value


class Recorder:
    """Keeps the first good exchange of each call; ``paths``: those of the OpenAPI description."""

    def __init__(self, paths: Mapping[str, Any]) -> None:
        self.found: dict[str, Any] = {}
        # The longest first: fixed words go before parameters.
        forms = sorted(paths, key=lambda path: (path.count("{"), path))
        self._forms = [(re.compile(re.sub(r"{\w+}", "[^/]+", path)), path) for path in forms]

    def __call__(self, answer: httpx.Response) -> None:
        """Take an answer: a hook of httpx."""
        path = next(path for form, path in self._forms if form.fullmatch(answer.url.path))
        name = f"{answer.request.method} {path}"
        answer.read()
        if not answer.is_success or name in self.found:
            return
        target = answer.url.raw_path.decode()
        self.found[name] = {"target": target, "status": answer.status_code} | {
            part: shortened(json.loads(message.content))
            for part, message in (("request", answer.request), ("answer", answer))
            if message.headers.get("Content-Type", "").startswith("application/json")
            and message.content
        }
