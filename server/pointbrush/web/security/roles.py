"""The role that each call needs, stated at its route; a call without one is refused.

``docs/roles.md`` shows all of them; a test compares it with the routes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from fastapi import Depends, Response
from starlette.routing import BaseRoute

from pointbrush.accounts.roles import Role
from pointbrush.web.problems import BINARY, responses

PREFIX = "/api/v1"
DECIDE: Role = "reviewer"
"""Role that may accept and reject frames, and revert an acceptance."""
ASSIGN: Role = "manager"
"""Role that may give frames to people."""
CANCEL_ANY: Role = "manager"
"""Role that may cancel jobs of other people."""


_OWN = "/sequences/{seq}"
PARTICIPANT_CALLS = frozenset({
    ("GET", "/session"), ("DELETE", "/session"), ("GET", "/me"), ("GET", "/me/keys"),
    ("GET", "/sequences"),
    *(("GET", f"{_OWN}{call}") for call in (
        "", "/labels", "/labels/{id}", "/palette", "/categories", "/boxes", "/boxes/{id}", "/edits",
        "/tracks", "/frames/{i}/points", "/frames/{i}/thumbnail", "/frames/{i}/annotation",
        "/frames/{i}/chunks", "/frames/{i}/chunks/{c}", "/frames/{i}/cameras",
        "/frames/{i}/images/{camera}", "/frames/{i}/placements",
    )),
    *(("POST", f"{_OWN}{call}") for call in (
        "/undo", "/redo", "/frames/{i}/strokes", "/frames/{i}/object", "/frames/{i}/copy",
        "/frames/{i}/clear",
    )),
})  # fmt: skip
"""Calls of a study's participant, besides those with the code: for their own copies alone."""


class _Needed:
    """A dependency of a route that holds the role; ``auth.caller`` checks it."""

    def __init__(self, role: Role) -> None:
        self.role = role

    async def __call__(self) -> None:
        """Do nothing."""


def role_of(route: BaseRoute) -> Role | None:
    """Return the role that calls of a route need; None: the route states none."""
    parts: Iterable[Any] = getattr(route, "dependencies", ())
    stated = (part.dependency for part in parts)
    return next((each.role for each in stated if isinstance(each, _Needed)), None)


def needs(
    role: Role, *problems: int, answers: Mapping[int | str, dict[str, Any]] | None = None
) -> dict[str, Any]:
    """Return the arguments of a route for its role and its OpenAPI entries.

    ``problems``: statuses of problem responses beside the common ones; ``answers``: other entries.
    """
    entries = {**(answers or {}), **responses(*problems)}
    return {"dependencies": [Depends(_Needed(role))], "responses": entries}


def needs_for_file(
    role: Role,
    description: str,
    *media_types: str,
    problems: Iterable[int] = (404,),
    cached: bool = False,
) -> dict[str, Any]:
    """Return the arguments of a route that answers with bytes; ``role`` as of ``needs``.

    ``cached``: it answers 304 to a client that has the bytes.
    """
    content = dict.fromkeys(media_types, BINARY)
    answers: dict[int | str, dict[str, Any]] = {
        200: {"description": description, "content": content}
    }
    if cached:
        answers[304] = {"description": "Not modified"}
    return {"response_class": Response, **needs(role, *problems, answers=answers)}
