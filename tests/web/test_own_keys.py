"""Keys that people give to the page's commands are theirs, whichever browser they use."""

from __future__ import annotations

from collections.abc import Iterator

import httpx
import pytest

from tests.serving import Served, serving, settings_in


@pytest.fixture(scope="module", params=["sqlite", "postgresql"])
def running(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Served]:
    postgres = request.param == "postgresql"
    database = request.getfixturevalue("postgres_server").new_labels() if postgres else ""
    with serving(settings_in(tmp_path_factory.mktemp("keys"), database=database)) as served:
        yield served


def person(served: Served, name: str) -> httpx.Client:
    token = served.workspace.labels.tokens.add("viewer", name)
    headers = {"Authorization": f"Bearer {token}"}
    return httpx.Client(base_url=f"{served.url}/api/v1/me", headers=headers)


def test_keys_are_a_persons_and_replaced_as_a_whole(running: Served) -> None:
    with person(running, "ada") as ada, person(running, "bob") as bob:
        assert ada.get("/keys").json() == {"keys": None}
        for keys in ({"Loop": "v", "Größer": "ctrl+ö"}, {"Undo": "ctrl+u"}, {}):
            assert ada.put("/keys", json={"keys": keys}).status_code == 204
            assert ada.get("/keys").json() == {"keys": keys}
        assert bob.get("/keys").json() == {"keys": None}


def test_what_are_no_keys_is_refused_and_changes_nothing(running: Served) -> None:
    with person(running, "eve") as eve:
        eve.put("/keys", json={"keys": {"Loop": "v"}})
        wrong: list[object] = [
            None, {"Loop": 7}, {"Loop": ""}, {"": "v"}, {"Loop": "x" * 33}, {"x" * 129: "v"},
            {str(n): "v" for n in range(257)}, ["v"],
        ]  # fmt: skip
        for keys in wrong:
            answer = eve.put("/keys", json={"keys": keys})
            assert answer.status_code == 422, keys
            assert "keys" in answer.json()["detail"]
        assert eve.get("/keys").json() == {"keys": {"Loop": "v"}}
