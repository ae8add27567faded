"""What each role may do: one table for every call and message, kept by the server and the docs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import get_args

import httpx
import pytest

from pointbrush.accounts.roles import ROLES, includes
from pointbrush.database.job import Job
from pointbrush.streaming import messages
from pointbrush.streaming.roles import MESSAGES
from pointbrush.web.app import create_app
from pointbrush.web.security.roles import CANCEL_ANY, PARTICIPANT_CALLS, PREFIX
from tests.routes import OPEN, ROUTES
from tests.serving import Served
from tests.waiting import eventually

DOCS = Path(__file__).parents[2] / "docs" / "roles.md"
UUID = "00000000-0000-4000-8000-000000000000"


def test_every_route_has_a_role_or_needs_no_token(served: Served) -> None:
    app = create_app(served.workspace, served.workspace.settings)
    calls = {
        (method, route.path.removeprefix(PREFIX))  # type: ignore[attr-defined]
        for route in app.routes
        for method in getattr(route, "methods", None) or {"WEBSOCKET"}
        if method != "HEAD"
    }
    assert calls - OPEN - ROUTES.keys() == set(), "calls without a role"
    assert OPEN - calls == set()
    assert OPEN & ROUTES.keys() == set()


def test_every_message_has_a_role() -> None:
    union, _ = get_args(messages.ClientMessage)
    types = {message.model_fields["type"].default for message in get_args(union)}
    assert types == MESSAGES.keys()


def test_the_docs_show_the_table() -> None:
    rows = re.findall(r"^\| (\w+) \|[^|]*\|([^|]*)\|([^|]*)\|$", DOCS.read_text(), re.MULTILINE)
    shown = {role: (calls, sent) for role, calls, sent in rows if role in ROLES}
    assert tuple(shown) == ROLES
    for role, (calls, sent) in shown.items():
        own = {f"{method} {path}" for (method, path), needed in ROUTES.items() if needed == role}
        assert set(re.findall(r"`([^`]+)`", calls)) == own, role
        own = {name for name, needed in MESSAGES.items() if needed == role}
        assert set(re.findall(r"`([^`]+)`", sent)) == own, role


@pytest.fixture(scope="module")
def tokens(served: Served) -> dict[str, str]:
    """A token of each role."""
    return {role: served.workspace.labels.tokens.add(role, f"the {role}") for role in ROLES}


def call(
    served: Served, secret: str, method: str, path: str, sequence: str = "none"
) -> httpx.Response:
    """A call that names nothing there is: only its role can be right."""
    for name, value in (
        ("seq", sequence),
        ("i", "0"),
        ("c", "0"),
        ("id", UUID),
        ("p", "none"),
        ("t", "1"),
        ("s", "none"),
        ("w", "0" * 16),
        ("a", "none"),
        ("n", "1"),
        ("camera", "none"),
    ):
        path = path.replace(f"{{{name}}}", value)
    path = path.replace(f"labels/{UUID}", "labels/1").replace(f"boxes/{UUID}", "boxes/1")
    return httpx.request(
        method,
        f"{served.url}{PREFIX}{path}",
        headers={"Authorization": f"Bearer {secret}"},
        params={"format": "ply", "with": "none"},
        content=b"{}" if method in ("POST", "PUT", "PATCH") else None,
    )


@pytest.mark.parametrize("needed", ROLES)
def test_a_call_below_its_role_is_refused_and_names_the_role(
    served: Served, tokens: dict[str, str], needed: str
) -> None:
    for (method, path), role in ROUTES.items():
        if role != needed or method == "WEBSOCKET" or path == "/session":
            continue
        for own in ROLES:
            allowed = includes(own, role)
            # An unknown recording is not found, whatever the role; a refused call changes nothing.
            answer = call(served, tokens[own], method, path, "none" if allowed else "wall")
            if allowed:
                assert answer.status_code != 403, (own, method, path, answer.text)
            else:
                assert answer.status_code == 403, (own, method, path, answer.text)
                assert f"expected the role {role} or higher" in answer.json()["detail"]
                assert f"this token's is {own}" in answer.json()["detail"]


def test_a_participant_may_use_no_other_call_and_sees_no_other_recording(served: Served) -> None:
    assert ROUTES.keys() >= PARTICIPANT_CALLS
    _, code = served.workspace.labels.studies.add("study", lambda _: ["desk"])
    for method, path in ROUTES:
        if method == "WEBSOCKET" or path == "/session":
            continue
        answer = call(served, code, method, path, "wall")
        if (method, path) not in PARTICIPANT_CALLS:
            assert answer.status_code == 403, (method, path, answer.text)
        elif "{seq}" in path:
            assert answer.status_code == 404, (method, path, answer.text)
        else:
            assert answer.status_code not in (401, 403, 404), (method, path, answer.text)


def test_jobs_are_cancelled_by_who_started_them_or_by_a_manager(
    served: Served, tokens: dict[str, str]
) -> None:
    workspace = served.workspace
    label = workspace.labels.create_label("wall", "somebody", name="tracked")
    stroke = {
        "label": label.id,
        "radius": 1.0,
        "samples": [{"origin": [0, 0, 3], "direction": [0, 0, -1], "t": 0}],
    }
    workspace.strokes.apply("wall", 0, stroke, "somebody")

    def start() -> str:
        answer = httpx.post(
            f"{served.url}{PREFIX}/sequences/wall/tracking",
            headers={"Authorization": f"Bearer {tokens['annotator']}"},
            json={"start": 0, "stop": 3, "labels": [label.id]},
        )
        assert answer.status_code == 202, answer.text
        return str(answer.json()["id"])

    def cancel(role: str, job: str) -> int:
        headers = {"Authorization": f"Bearer {tokens[role]}"}
        return httpx.delete(f"{served.url}{PREFIX}/jobs/{job}", headers=headers).status_code

    job = start()
    assert cancel("reviewer", job) == 403
    assert cancel("annotator", job) in (200, 409)  # 409: it has ended meanwhile
    other = start()
    assert cancel(CANCEL_ANY, other) in (200, 409)

    def ended(job_id: str) -> Job | None:
        found = workspace.jobs.get(job_id)
        return found if found.state in ("done", "cancelled", "failed") else None

    eventually(lambda: ended(job) and ended(other))
