"""Accounts and tokens over REST: made by managers, shown once, and revoked."""

from __future__ import annotations

from typing import Any

import httpx
import pytest

from tests.serving import Served


class Api:
    """Calls with a token."""

    def __init__(self, served: Served, secret: str) -> None:
        self._url, self._headers = f"{served.url}/api/v1", {"Authorization": f"Bearer {secret}"}

    def call(self, method: str, path: str, **options: Any) -> httpx.Response:
        return httpx.request(method, f"{self._url}{path}", headers=self._headers, **options)

    def get(self, path: str) -> httpx.Response:
        return self.call("GET", path)

    def post(self, path: str, **body: Any) -> httpx.Response:
        return self.call("POST", path, json=body)

    def role(self) -> Any:
        """Role of the token's person, None if the token is refused."""
        return self.get("/session").json().get("role")


@pytest.fixture
def api(served: Served) -> Api:
    return Api(served, served.workspace.labels.tokens.add("manager"))


def listed(api: Api, account: str) -> Any:
    return next((e for e in api.get("/accounts").json() if e["account"] == account), None)


def test_a_manager_makes_an_account_whose_token_lets_its_person_in(
    served: Served, api: Api
) -> None:
    made = api.post("/accounts", account="zoë", role="reviewer", days=2)
    assert made.status_code == 201, made.text
    person = Api(served, made.json()["token"])
    assert person.get("/session").json() == {"author": "zoë", "role": "reviewer"}
    known = listed(api, "zoë")
    assert (known["role"], [token["valid"] for token in known["tokens"]]) == ("reviewer", [True])
    assert made.json()["token"] not in api.get("/accounts").text
    again = api.post("/accounts", account="zoë")
    assert (again.status_code, again.json()["title"]) == (409, "Conflict")

    more = api.post("/accounts/zoë/tokens").json()
    assert more["role"] == "reviewer"
    other = Api(served, more["token"])
    ended = api.call("DELETE", "/accounts/zoë/tokens", params={"id": more["id"]})
    assert ended.status_code == 204
    assert (other.role(), person.role()) == (None, "reviewer")
    assert api.call("DELETE", "/accounts/zoë/tokens").status_code == 204
    assert person.role() is None
    assert listed(api, "zoë")["role"] is None
    assert [token["valid"] for token in api.get("/accounts/zoë/tokens").json()] == [False, False]
    assert api.post("/accounts", account="zoë").status_code == 201, "access given anew"


def test_no_caller_gives_or_takes_a_role_above_their_own(served: Served, api: Api) -> None:
    served.workspace.labels.tokens.add("admin", "root")
    for method, path, body in (
        ("POST", "/accounts", {"account": "eve", "role": "admin"}),
        ("POST", "/accounts/root/tokens", {"role": "viewer"}),
        ("DELETE", "/accounts/root/tokens", None),
    ):
        answer = api.call(method, path, json=body)
        assert (answer.status_code, "the role admin" in answer.text) == (403, True), path
    assert listed(api, "eve") is None
    assert listed(api, "root")["role"] == "admin"


@pytest.mark.parametrize("account", ["owner", "token 7", "a:b", "a/b", " ", "\u202eada"])
def test_names_that_no_account_may_have_are_refused(api: Api, account: str) -> None:
    assert api.post("/accounts", account=account).status_code in (400, 422)


def test_an_unknown_account_or_token_is_not_found(api: Api) -> None:
    api.post("/accounts", account="ida")
    assert api.get("/accounts/nobody/tokens").status_code == 404
    assert api.post("/accounts/nobody/tokens").status_code == 404
    wrong = api.call("DELETE", "/accounts/ida/tokens", params={"id": "0" * 8})
    assert wrong.status_code == 404
    assert listed(api, "ida")["role"] == "annotator"
