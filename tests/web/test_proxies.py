"""A server behind a proxy: the client's scheme counts, if a trusted proxy tells it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
from websockets.sync.client import connect

from pointbrush.streaming.schema import subprotocol
from tests.serving import TOKEN, Served, serving, settings_in

TLS = {"X-Forwarded-For": "203.0.113.7", "X-Forwarded-Proto": "https"}


@pytest.fixture(scope="module")
def behind(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A server that trusts a proxy on this machine, and lets an address try two wrong tokens."""
    folder = tmp_path_factory.mktemp("behind")
    options = {"trusted_proxies": "127.0.0.1", "wrong_tokens_per_minute": 2}
    with serving(settings_in(folder, **options)) as running:
        yield running


def signed_in(url: str, **headers: str) -> str:
    """The cookie that a sign-in sets."""
    body = {"token": TOKEN}
    answer = httpx.post(f"{url}/api/v1/session", json=body, headers=headers)
    return answer.raise_for_status().headers["set-cookie"]


def test_the_cookie_is_secure_behind_tls_of_a_trusted_proxy(behind: Served) -> None:
    assert "; Secure" in signed_in(behind.url, **TLS)
    assert "; Secure" not in signed_in(behind.url, **TLS | {"X-Forwarded-Proto": "http"})
    assert "; Secure" not in signed_in(behind.url), "as the connection itself is"
    # What a client wrote into the header stands before what its proxy adds.
    assert "; Secure" not in signed_in(behind.url, **TLS | {"X-Forwarded-Proto": "https, http"})


def test_anybody_else_cannot_tell(tmp_path: Path) -> None:
    with serving(settings_in(tmp_path, trusted_proxies="203.0.113.0/24")) as running:
        assert "; Secure" not in signed_in(running.url, **TLS)


def test_its_page_calls_and_opens_the_socket(behind: Served) -> None:
    place = behind.url.partition("://")[2]
    cookie = signed_in(behind.url, **TLS).partition(";")[0]
    page = {**TLS, "Origin": f"https://{place}", "Cookie": cookie}
    stream = f"ws://{place}/api/v1/stream"
    with connect(stream, subprotocols=[subprotocol()], additional_headers=page) as socket:
        assert socket.subprotocol == subprotocol()
    call = f"{behind.url}/api/v1/session"
    for origin in (f"http://{place}", "https://elsewhere"):
        headers = page | {"Origin": origin}
        assert httpx.delete(call, headers=headers).status_code == 403, "another site's page"
    assert httpx.delete(call, headers=page).status_code == 204
    # Without a port in the address, the name tells the cookie from that of plain HTTP.
    named = signed_in(behind.url, **TLS, Host="localhost", Origin="https://localhost")
    assert named.startswith("pointbrush_session_https=")


def test_each_client_behind_it_has_tries_of_its_own(behind: Served) -> None:
    def tried(address: str) -> int:
        headers = {**TLS, "X-Forwarded-For": address, "Authorization": "Bearer wrong"}
        return httpx.get(f"{behind.url}/api/v1/me", headers=headers).status_code

    assert [tried("203.0.113.8") for _ in range(3)] == [401, 401, 429]
    assert tried("203.0.113.9") == 401
