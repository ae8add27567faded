"""Sign-in by OpenID Connect, against a provider that is right, and one that is not."""

from __future__ import annotations

import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import httpx
import pytest
from cryptography.hazmat.primitives.asymmetric import rsa

from pointbrush.errors import BadInputError
from pointbrush.web.app import create_app
from pointbrush.web.security import oidc
from pointbrush.web.security.sign_ins import FROM_ONE_ADDRESS
from pointbrush.workspace import Workspace
from tests.serving import Served, add_sequence, serving, settings_in
from tests.waiting import PATIENCE, eventually
from tests.web.oidc_provider import CLIENT, SECRET, Provider, providing

ADA = {"sub": "1", "email": "ada@lab.example", "email_verified": True}
HTML = {"Accept": "text/html"}


@pytest.fixture(scope="module", params=["sqlite", "postgresql"])
def running(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tuple[Served, Provider]]:
    folder = tmp_path_factory.mktemp("oidc")
    postgres = request.param == "postgresql"
    database = request.getfixturevalue("postgres_server").new_labels() if postgres else ""
    (folder / "secret").write_text(f"{SECRET}\n")
    with providing() as provider:
        settings = settings_in(
            folder, database=database, oidc_issuer=provider.url, oidc_client_id=CLIENT,
            oidc_client_secret_file=str(folder / "secret"), oidc_roles_claim="lab.roles",
        )  # fmt: skip
        add_sequence(settings, "wall", frames=1, points=500)
        with serving(settings) as served:
            yield served, provider


@pytest.fixture
def provider(running: tuple[Served, Provider]) -> Provider:
    found = running[1]
    found.wrong, found.header, found.signing = {}, {"alg": "RS256", "kid": "one"}, None
    found.person = ADA | {"lab": {"roles": ["annotator"]}}
    return found


@pytest.fixture
def browser(running: tuple[Served, Provider], provider: Provider) -> Iterator[httpx.Client]:
    with httpx.Client(base_url=running[0].url) as client:
        yield client


def answered(browser: httpx.Client) -> str:
    """Begin to sign in; the address with the provider's answer."""
    begun = browser.get("/api/v1/oidc/login")
    assert begun.status_code == 303
    return httpx.get(begun.headers["location"]).headers["location"]


def sign_in(browser: httpx.Client) -> httpx.Response:
    return browser.get(answered(browser))


def who(browser: httpx.Client) -> dict[str, Any]:
    answer = browser.get("/api/v1/session")
    return answer.json() if answer.status_code == 200 else {}


def test_a_person_signs_in_and_is_an_account(
    running: tuple[Served, Provider], browser: httpx.Client
) -> None:
    assert browser.get("/api/v1/oidc").json()["name"].startswith("127.0.0.1:")
    answer = sign_in(browser)
    assert (answer.status_code, answer.headers["location"]) == (303, "/")
    assert who(browser) == {"author": "ada@lab.example", "role": "annotator"}
    made = browser.post(
        "/api/v1/sequences/wall/labels", json={"name": "pin"}, headers={"Origin": running[0].url}
    )
    assert made.status_code in (200, 201), made.text
    assert browser.delete("/api/v1/session").status_code in (204, 403)


def test_the_role_follows_the_provider_and_revoking_keeps_them_out(
    running: tuple[Served, Provider], provider: Provider, browser: httpx.Client
) -> None:
    provider.person = {"sub": "2", "preferred_username": "bo", "lab": {"roles": ["x", "reviewer"]}}
    sign_in(browser)
    assert who(browser) == {"author": "bo", "role": "reviewer"}
    provider.person["lab"] = {"roles": "viewer"}
    with httpx.Client(base_url=running[0].url) as other:
        sign_in(other)
    assert who(browser)["role"] == "viewer"
    provider.person["lab"] = {"roles": ["boss"]}
    assert sign_in(browser).status_code == 403
    provider.person["lab"] = {"roles": ["viewer"]}
    tokens = running[0].workspace.labels.tokens
    [mine] = [token for token in tokens.list() if token.account == "bo"]
    tokens.revoke(mine.id)
    assert who(browser) == {}
    assert sign_in(browser).status_code == 403


def test_nobody_becomes_another_account_by_a_name(
    running: tuple[Served, Provider], provider: Provider, browser: httpx.Client
) -> None:
    running[0].workspace.labels.tokens.add("manager", "grace")
    names = {"preferred_username": "grace", "email": "grace", "email_verified": False}
    provider.person |= names | {"sub": "3"}
    sign_in(browser)
    assert who(browser)["author"] == "3"
    provider.person |= names | {"preferred_username": "owner", "sub": "a:b"}
    sign_in(browser)
    assert who(browser)["author"].startswith("person ")


@pytest.mark.parametrize(
    "wrong",
    [
        {"nonce": "another"},
        {"nonce": None},
        {"aud": "somebody else"},
        {"aud": [CLIENT, "somebody else"]},
        {"iss": "https://elsewhere.example"},
        {"exp": time.time() - 3600},
        {"exp": "soon"},
        {"iat": time.time() + 3600},
        {"sub": ""},
        {"azp": "somebody else"},
    ],
    ids="-".join,  # a time is another in each process
)
def test_a_token_with_a_wrong_claim_lets_nobody_in(
    provider: Provider, browser: httpx.Client, wrong: dict[str, Any]
) -> None:
    provider.wrong = wrong
    answer = sign_in(browser)
    assert answer.status_code == 401
    assert "ID token" in answer.json()["detail"]
    assert who(browser) == {}


def test_a_token_that_no_key_of_the_provider_signed_lets_nobody_in(
    provider: Provider, browser: httpx.Client
) -> None:
    provider.signing = rsa.generate_private_key(65537, 2048)
    assert sign_in(browser).status_code == 401
    provider.signing = None
    for algorithm in ("none", "HS256", "RS1"):
        provider.header = {"alg": algorithm, "kid": "one"}
        assert sign_in(browser).status_code == 401
    assert who(browser) == {}


def test_a_new_key_of_the_provider_counts(
    provider: Provider, browser: httpx.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    sign_in(browser)
    monkeypatch.setattr(oidc, "RETRY_SECONDS", 0.0)
    old, provider.key = provider.key, rsa.generate_private_key(65537, 2048)
    provider.header = {"alg": "RS256", "kid": "two"}
    assert sign_in(browser).status_code == 303
    provider.key, provider.header = old, {"alg": "RS256", "kid": "one"}
    assert sign_in(browser).status_code == 303


def test_an_answer_counts_once_and_in_its_own_browser_alone(
    running: tuple[Served, Provider], browser: httpx.Client
) -> None:
    answer = answered(browser)
    with httpx.Client(base_url=running[0].url) as other:
        assert "state" in other.get(answer).json()["detail"]
        answered(other)
        assert other.get(answer).status_code == 401
        assert who(other) == {}
    answer = answered(browser)
    kept = dict(browser.cookies)
    assert browser.get(answer).status_code == 303
    assert browser.get(answer).status_code == 401, "the browser has forgotten the sign-in"
    browser.cookies.clear()
    browser.cookies.update(kept)
    replayed = browser.get(answer)
    assert replayed.status_code == 401
    assert "code" in replayed.json()["detail"]


def test_a_sign_in_ends_in_time(browser: httpx.Client, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(oidc, "FLOW_SECONDS", -1)
    assert sign_in(browser).status_code == 401


def test_a_browser_is_told_on_the_page(browser: httpx.Client) -> None:
    refused = browser.get("/api/v1/oidc/callback?error=access_denied", headers=HTML)
    assert (refused.status_code, refused.headers["location"]) == (303, "/?sign-in=failed")


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("oidc_issuer", "http://login.example.org"),
        ("oidc_client_id", ""),
        ("oidc_role", "boss"),
        ("oidc_client_secret_file", "/none"),
    ],
)
def test_settings_that_cannot_be_right_are_refused(tmp_path: Path, option: str, value: str) -> None:
    good = {"oidc_issuer": "https://login.example.org", "oidc_client_id": "me"}
    settings = settings_in(tmp_path, **good | {option: value})
    workspace = Workspace(settings)
    try:
        with pytest.raises(BadInputError, match=option):
            create_app(workspace, settings)
    finally:
        workspace.close()


def test_strangers_with_codes_that_hang_delay_no_other_call(
    running: tuple[Served, Provider], provider: Provider, monkeypatch: pytest.MonkeyPatch
) -> None:
    served = running[0]
    strangers = 45  # more than the threads that answer REST
    monkeypatch.setattr(oidc, "BOUNDS", replace(oidc.BOUNDS, seconds=PATIENCE))
    begun = []
    for _ in range(strangers):
        login = httpx.get(f"{served.url}/api/v1/oidc/login")
        begun.append((login.cookies, httpx.URL(login.headers["location"]).params["state"]))
    provider.answering.clear()

    def try_code(number: int) -> int:
        cookies, state = begun[number]
        with httpx.Client(base_url=served.url, cookies=cookies, timeout=PATIENCE) as client:
            query = {"code": "made up", "state": state}
            return client.get("/api/v1/oidc/callback", params=query).status_code

    with ThreadPoolExecutor(strangers) as threads:
        tries = [threads.submit(try_code, number) for number in range(strangers)]
        try:
            eventually(lambda: sum(each.done() for each in tries) == strangers - FROM_ONE_ADDRESS)
            answer = httpx.get(f"{served.url}/api/v1/sequences/wall", headers=served.headers)
        finally:
            provider.answering.set()
    assert answer.status_code == 200
    states = sorted(each.result() for each in tries)
    assert states == [401] * FROM_ONE_ADDRESS + [429] * (strangers - FROM_ONE_ADDRESS)


def test_without_a_provider_there_is_none(anyone: httpx.Client) -> None:
    assert anyone.get("/api/v1/oidc").json() == {"name": None}
    assert anyone.get("/api/v1/oidc/login").status_code == 404
