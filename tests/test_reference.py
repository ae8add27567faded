"""The references' examples: calls of the client, and what REST was asked and answered."""

from __future__ import annotations

import inspect
import json
import os
import socket
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import jsonschema
import pytest

from pointbrush import client as package
from pointbrush.client import Client
from pointbrush.client.steps import Part, steps
from tests.services import example_service
from tests.serving import TOKEN, serving
from tests.test_docs import ROOT, Place, place  # noqa: F401 – a fixture

sys.path.insert(0, str(ROOT / "docs" / "site"))

from examples import CALLS, EXCHANGES, WITHOUT_ONE, Recorder, calls
from rest_pages import description

GETADDRINFO = socket.getaddrinfo


@pytest.fixture(scope="module")
def described() -> dict[str, Any]:
    return description()


def resolved(host: str, *rest: Any, **options: Any) -> Any:
    """Resolve a name; that of an example is never called, and has to be public."""
    name = "1.1.1.1" if str(host).endswith("example.org") else host
    return GETADDRINFO(name, *rest, **options)


def methods() -> set[str]:
    """Return ``Class.method`` of everything that the client can be asked."""
    kinds = [kind for name in package.__all__ if isinstance(kind := getattr(package, name), type)]
    parts = [kind for kind in kinds if issubclass(kind, Part) and kind.__name__ != "AsyncClient"]
    return {
        f"{kind.__name__}.{name}"
        for kind in parts
        for name in dir(kind)
        if isinstance(inspect.getattr_static(kind, name), steps)
    }


def test_each_method_has_an_example() -> None:
    assert methods() - set(calls()) == set()
    own = {"Client", "AsyncClient", "Recording", "Frames", "Project"}
    assert {name.split(".")[0] for name in calls()} - own <= {n.split(".")[0] for n in methods()}


@pytest.mark.parametrize("place", [CALLS], indirect=True)
def test_the_examples_run_and_ask_for_every_route(
    place: Place,  # noqa: F811
    described: dict[str, Any],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(place.folder)
    recorder = Recorder(described["paths"])
    init = Client.__init__

    def recorded(self: Client, *args: Any, **options: Any) -> None:
        init(self, *args, event_hooks={"response": [recorder]}, **options)

    monkeypatch.setattr(Client, "__init__", recorded)
    # Neither is here: pandas, and the host of a webhook.
    frames = SimpleNamespace(DataFrame=lambda rows, **_: rows)
    monkeypatch.setitem(sys.modules, "pandas", frames)
    monkeypatch.setattr("socket.getaddrinfo", resolved)
    with (
        example_service("mask_server.py") as address,
        serving(replace(place.settings, mask_models=f"toy={address}")) as served,
        Client(served.url, TOKEN) as client,
    ):
        names = {"client": client, "url": served.url, "token": TOKEN, "Path": Path}
        exec(compile(CALLS.read_text(), str(CALLS), "exec"), names)
    asked = {
        f"{verb.upper()} {path}" for path, verbs in described["paths"].items() for verb in verbs
    }
    assert asked - set(recorder.found) == set(WITHOUT_ONE)
    if "WRITE_EXCHANGES" in os.environ:
        target = ROOT / os.environ["WRITE_EXCHANGES"]
        target.write_text(json.dumps(recorder.found, indent=1, sort_keys=True) + "\n")


def test_what_is_shown_of_rest_fits_its_schemas(described: dict[str, Any]) -> None:
    exchanges = json.loads(EXCHANGES.read_text())
    paths = described["paths"].items()
    named = {f"{v.upper()} {path}" for path, verbs in paths for v in verbs}
    assert named - set(exchanges) == set(WITHOUT_ONE)
    for name, shown in exchanges.items():
        verb, path = name.split()
        call = described["paths"][path][verb.lower()]
        answers = call["responses"][str(shown["status"])].get("content", {})
        for part, content in (
            ("request", call.get("requestBody", {}).get("content", {})),
            ("answer", answers),
        ):
            if part in shown:
                schema = content["application/json"]["schema"]
                jsonschema.validate(shown[part], {**schema, "components": described["components"]})
