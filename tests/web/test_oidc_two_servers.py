"""Sign-in with a provider at two servers of one PostgreSQL database, behind one address."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import httpx
import pytest

from tests.serving import Served, add_sequence, serving, settings_in
from tests.waiting import eventually
from tests.web.oidc_provider import CLIENT, SECRET, Provider, providing

API = "/api/v1"
BALANCER = "lab.example"
"""Name by which a browser reaches either server."""


class Browser:
    """A browser whose calls go to either server, as a load balancer sends them."""

    def __init__(self, client: httpx.Client) -> None:
        self.client = client

    def get(self, server: Served, path: str) -> httpx.Response:
        return self.client.get(f"{server.url}{path}", headers={"Host": BALANCER})

    def provider_answer(self, server: Served) -> str:
        """Begin to sign in at a server; the path with the provider's answer."""
        begun = self.get(server, f"{API}/oidc/login")
        assert begun.status_code == 303, begun.text
        address = urlsplit(httpx.get(begun.headers["location"]).headers["location"])
        assert address.netloc == BALANCER
        return f"{address.path}?{address.query}"

    def sign_in(self, here: Served, there: Served) -> httpx.Response:
        """Begin at one server, and come back to the other."""
        return self.get(there, self.provider_answer(here))

    def who(self, server: Served) -> dict[str, Any]:
        answer = self.get(server, f"{API}/session")
        return dict(answer.json()) if answer.status_code == 200 else {}


@pytest.fixture
def servers(
    tmp_path: Path,
    labels_url: str,
) -> Iterator[tuple[Served, Served, Provider]]:
    (tmp_path / "secret").write_text(f"{SECRET}\n")
    with ExitStack() as stack:
        provider = stack.enter_context(providing())
        settings = settings_in(
            tmp_path, database=labels_url, allowed_hosts=BALANCER, oidc_issuer=provider.url,
            oidc_client_id=CLIENT, oidc_client_secret_file=str(tmp_path / "secret"),
            oidc_roles_claim="lab.roles",
        )  # fmt: skip
        add_sequence(settings, "wall", frames=1, points=500)
        here, there = (stack.enter_context(serving(settings)) for _ in range(2))
        yield here, there, provider


@pytest.fixture
def browsers() -> Iterator[tuple[Browser, Browser]]:
    with httpx.Client() as one, httpx.Client() as other:
        yield Browser(one), Browser(other)


def test_a_sign_in_begun_at_one_server_ends_at_the_other(
    servers: tuple[Served, Served, Provider], browsers: tuple[Browser, Browser]
) -> None:
    here, there, provider = servers
    ada, other = browsers
    provider.person = {"sub": "1", "preferred_username": "ada", "lab": {"roles": ["annotator"]}}
    answer = ada.provider_answer(here)
    assert other.get(there, answer).status_code == 401, "another browser"
    assert ada.get(there, answer).status_code == 303
    assert ada.get(here, answer).status_code == 401, "an answer counts once at both"
    for server in (here, there):
        assert ada.who(server) == {"author": "ada", "role": "annotator"}

    def roles() -> list[str | None]:
        return [ada.who(server).get("role") for server in (here, there)]

    # Each sign-in changes the role of all sessions of the account, at both servers.
    for role in ("viewer", "reviewer"):
        provider.person["lab"] = {"roles": [role]}
        assert other.sign_in(there, here).status_code == 303
        eventually(lambda role=role: roles() == [role, role])
    provider.person["lab"] = {"roles": ["boss"]}
    assert other.sign_in(here, there).status_code == 403

    tokens = here.workspace.labels.tokens
    [mine] = [token for token in tokens.list() if token.account == "ada"]
    tokens.revoke(mine.id)
    eventually(lambda: roles() == [None, None])
    provider.person["lab"] = {"roles": ["viewer"]}
    for begun, ended in ((here, there), (there, here)):
        assert other.sign_in(begun, ended).status_code == 403, "revoked at both"
