"""Import by a path of the server: who may, from where, and what the answers tell."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

from pointbrush.web.security.clients import FORWARDING, Clients
from tests.serving import Served, serving, settings_in
from tests.waiting import eventually

SECRET = "root:x:0:0:swordfish"


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Home and current folder of the server, with a file of points and one of secrets."""
    folder = tmp_path / "home"
    folder.mkdir()
    (folder / "points.xyz").write_text("1 2 3\n4 5 6\n")
    for name in ("secret.txt", "secret.ply", "secret.npy", "secret.pcd", "secret.bin"):
        (folder / name).write_text(f"{SECRET}\n{SECRET}\n")
    monkeypatch.setenv("HOME", str(folder))
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def own(home: Path, tmp_path: Path) -> Iterator[Served]:
    """A server on loopback without import roots."""
    with serving(settings_in(tmp_path)) as running:
        yield running


def post(served: Served, path: Path | str, token: str = "", **headers: str) -> httpx.Response:
    headers = {"Authorization": f"Bearer {token or served.token}", **headers}
    url = f"{served.url}/api/v1/sequences"
    return httpx.post(url, json={"path": str(path)}, headers=headers)


def ended(served: Served, answer: httpx.Response) -> dict[str, object]:
    assert answer.status_code == 202, answer.text
    url = f"{served.url}/api/v1/jobs/{answer.json()['id']}"

    def job() -> dict[str, object] | None:
        found: dict[str, object] = httpx.get(url, headers=served.headers).json()
        return found if found["state"] in ("done", "failed") else None

    return eventually(job)  # type: ignore[no-any-return]


def test_without_roots_only_the_admin_token_imports_from_home(own: Served, home: Path) -> None:
    assert ended(own, post(own, home / "points.xyz"))["state"] == "done"
    assert post(own, home / "none.xyz").status_code == 404
    answers = set()
    for role in ("manager", "admin"):
        token = own.workspace.labels.tokens.add(role, role)
        for path in (home / "points.xyz", home / "none.xyz", "/etc/passwd", "/etc/none"):
            answer = post(own, path, token)
            answers.add((answer.status_code, answer.text))
    assert len(answers) == 1
    assert answers.pop()[0] == 403


@pytest.mark.parametrize("header", FORWARDING)
def test_a_forwarded_request_does_not_count_as_this_machine(
    own: Served, home: Path, header: str
) -> None:
    assert post(own, home / "points.xyz", **{header: "127.0.0.1"}).status_code == 403


def test_nor_does_one_by_a_trusted_proxy_or_to_a_server_of_the_network(
    home: Path, tmp_path: Path
) -> None:
    for options in ({"trusted_proxies": "127.0.0.1"}, {"host": "0.0.0.0"}):
        with serving(settings_in(tmp_path, **options)) as running:
            assert post(running, home / "points.xyz").status_code == 403
            assert post(running, home / "none.xyz").status_code == 403


def test_named_roots_are_for_every_manager_and_for_nothing_else(home: Path, tmp_path: Path) -> None:
    inbox = tmp_path / "inbox"
    (inbox / ".hidden").mkdir(parents=True)
    for name in ("points.xyz", ".hidden/points.xyz"):
        (inbox / name).write_text("1 2 3\n")
    (inbox / "link").symlink_to(home)
    with serving(settings_in(tmp_path, import_roots=str(inbox))) as running:
        manager = running.workspace.labels.tokens.add("manager", "Mia")
        assert ended(running, post(running, inbox / "points.xyz", manager))["state"] == "done"
        assert post(running, inbox / "none.xyz", manager).status_code == 404
        texts = set()
        for path in (
            home / "points.xyz", home / "none", inbox / "link", inbox / "link" / "points.xyz",
            inbox / "link" / "none", inbox / ".hidden" / "points.xyz", inbox / ".none", "/",
        ):  # fmt: skip
            for token in (manager, running.token):
                answer = post(running, path, token)
                assert answer.status_code == 403, (path, answer.text)
                texts.add(answer.json()["detail"])
        assert len(texts) == 1


@pytest.mark.parametrize("name", ["txt", "ply", "npy", "pcd", "bin"])
def test_an_error_does_not_quote_the_file(own: Served, home: Path, name: str) -> None:
    job = ended(own, post(own, home / f"secret.{name}"))
    assert job["state"] == "failed"
    for word in ("root", "swordfish"):
        assert word not in str(job), job


@pytest.mark.parametrize(
    ("peer", "header", "trusted", "address"),
    [
        ("9.9.9.9", "1.1.1.1", "", "9.9.9.9"),
        ("9.9.9.9", "1.1.1.1", "9.9.9.9", "1.1.1.1"),
        ("9.9.9.9", "1.1.1.1, 2.2.2.2", "9.9.9.0/24", "2.2.2.2"),
        ("9.9.9.9", "1.1.1.1, 9.9.9.8", "9.9.9.0/24", "1.1.1.1"),
        ("9.9.9.9", "nonsense", "9.9.9.9", "9.9.9.9"),
        ("::1", "[2001:db8::5]", "::1", "2001:db8::5"),
        ("9.9.9.9", "", "9.9.9.9", "9.9.9.9"),
    ],
)
def test_forwarded_addresses_are_believed_from_trusted_proxies_only(
    peer: str, header: str, trusted: str, address: str
) -> None:
    from starlette.requests import HTTPConnection

    headers = [(b"x-forwarded-for", header.encode())] if header else []
    scope = {"type": "http", "client": (peer, 1), "headers": headers}
    assert Clients(trusted).address(HTTPConnection(scope)) == address
