"""Who gets in: tokens, roles, the page's cookie, Origin, Host."""

from __future__ import annotations

import time

import httpx
import pytest

from tests.serving import TOKEN, Served

PROBLEM = "application/problem+json"


def problem(response: httpx.Response, status: int) -> str:
    assert response.status_code == status, response.text
    assert response.headers["content-type"] == PROBLEM
    body = response.json()
    assert body["status"] == status
    assert body["title"]
    return str(body["detail"])


@pytest.mark.parametrize("token", ["", "wrong", TOKEN[:-1], TOKEN + "x", "é"])
def test_every_call_needs_a_token(anyone: httpx.Client, token: str) -> None:
    headers = {"Authorization": f"Bearer {token}".encode()} if token else {}
    response = anyone.get("/api/v1/sequences", headers=headers)  # type: ignore[arg-type]
    problem(response, 401)
    assert response.headers["www-authenticate"].startswith("Bearer")


def test_all_described_calls_need_a_token(anyone: httpx.Client) -> None:
    paths = anyone.get("/api/v1/openapi.json").json()["paths"]
    for path, item in paths.items():
        for verb in item:
            if path.endswith("/session") and verb == "post":
                continue
            url = path.replace("{seq}", "wall").replace("{i}", "0").replace("{c}", "0")
            url = url.replace("{id}", "1") + "?format=ply"
            response = anyone.request(verb, url, json={"name": "x", "start": 0, "stop": 1})
            assert response.status_code in (401, 422), (verb, path, response.text)


def test_health_needs_none(anyone: httpx.Client) -> None:
    assert anyone.get("/healthz").json()["status"] == "ok"
    assert anyone.get("/metrics").status_code == 401


@pytest.mark.parametrize(
    ("role", "may_paint", "may_delete"),
    [("viewer", False, False), ("annotator", True, False), ("admin", True, True)],
)
def test_a_role_may_do_what_it_is_for_and_no_more(
    served: Served, role: str, may_paint: bool, may_delete: bool
) -> None:
    secret = served.workspace.labels.tokens.add(role, f"a {role}")
    headers = {"Authorization": f"Bearer {secret}"}
    with httpx.Client(base_url=f"{served.url}/api/v1", headers=headers) as client:
        assert client.get("/me").json()["role"] == role
        assert client.get("/sequences/wall").status_code == 200
        created = client.post("/sequences/wall/labels", json={"name": f"by {role}"})
        assert created.status_code == (201 if may_paint else 403)
        assert client.delete("/sequences/wall/floor").status_code == (200 if may_paint else 403)
        patched = client.patch("/sequences/wall", json={"fps": 30.0})
        assert patched.status_code == (200 if may_delete else 403)


def test_expired_and_revoked_tokens(served: Served) -> None:
    tokens = served.workspace.labels.tokens
    expired = tokens.add("admin", "old", expires=time.time() - 1)
    revoked = tokens.add("admin", "gone")
    tokens.revoke(next(token.id for token in tokens.list() if token.name == "gone"))
    for secret in (expired, revoked):
        response = httpx.get(
            f"{served.url}/api/v1/me", headers={"Authorization": f"Bearer {secret}"}
        )
        problem(response, 401)


def test_url_token_becomes_a_cookie_and_leaves_the_address(anyone: httpx.Client) -> None:
    response = anyone.get(f"/?token={TOKEN}&sequence=wall")
    assert response.status_code == 303
    assert response.headers["location"] == "/?sequence=wall"
    cookie = response.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    assert anyone.get("/api/v1/me").json() | {"schema": 0, "version": 0} == {
        "author": "owner", "role": "admin", "schema": 0, "version": 0,
    }  # fmt: skip


def test_a_wrong_token_in_the_address_is_refused(anyone: httpx.Client) -> None:
    problem(anyone.get("/?token=wrong"), 401)


def test_a_session_lasts_from_sign_in_to_sign_out(anyone: httpx.Client) -> None:
    problem(anyone.post("/api/v1/session", json={"token": "wrong"}), 401)
    assert anyone.post("/api/v1/session", json={"token": TOKEN}).json()["role"] == "admin"
    assert anyone.get("/api/v1/session").status_code == 200
    assert anyone.delete("/api/v1/session").status_code == 204
    assert anyone.get("/api/v1/session").status_code == 401


def test_another_sites_page_cannot_use_the_cookie(served: Served, anyone: httpx.Client) -> None:
    anyone.get(f"/?token={TOKEN}")
    body = {"name": "forged"}
    url = "/api/v1/sequences/wall/labels"
    for headers in (
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Origin": served.url.replace("127.0.0.1", "localhost")},
        {"Sec-Fetch-Site": "cross-site"},
    ):
        problem(anyone.post(url, json=body, headers=headers), 403)
    assert anyone.post(url, json=body, headers={"Origin": served.url}).status_code == 201


@pytest.mark.parametrize(
    ("host", "known"),
    [
        ("localhost:8080", True),
        ("LOCALHOST", True),
        ("192.168.1.7:8080", True),
        ("[::1]:8080", True),
        ("evil.example", False),
        ("localhost.evil.example", False),
        ("", False),
    ],
)
def test_rebound_names_are_refused(anyone: httpx.Client, host: str, known: bool) -> None:
    response = anyone.get("/healthz", headers={"Host": host})
    assert response.status_code == (200 if known else 403)


def test_answers_forbid_foreign_scripts_and_frames(anyone: httpx.Client) -> None:
    headers = anyone.get("/healthz").headers
    policy = headers["content-security-policy"]
    assert "default-src 'self'" in policy
    assert "script-src 'self' 'wasm-unsafe-eval'" in policy
    assert "frame-ancestors 'none'" in policy
    assert "unsafe-inline" not in policy
    assert headers["x-content-type-options"] == "nosniff"
    assert "xr-spatial-tracking=(self)" in headers["permissions-policy"]
    assert headers["cross-origin-opener-policy"] == "same-origin"
    assert "server" not in headers


@pytest.mark.parametrize(
    "path", ["/../app.py", "/%2e%2e/app.py", "/..%2fapp.py", "/assets/../../auth.py", "/%00"]
)
def test_page_files_stay_inside_the_page(anyone: httpx.Client, path: str) -> None:
    assert anyone.get(path).status_code == 404
