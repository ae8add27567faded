"""A browser keeps its account: undo goes on after each way of opening the page again."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

import httpx
import pytest

from pointbrush.settings import Settings
from tests.serving import Served, add_sequence, serving, settings_in

LEFT, RIGHT = -1.0, 1.0


class Opened:
    """A default server (its token is a new one at each start), and browsers that visit it."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._running = ExitStack()
        self.server = self._started()
        self.server.workspace.labels.create_label("wall", "somebody", name="pin")

    def _started(self) -> Served:
        return self._running.enter_context(serving(self._settings))

    def restart(self) -> None:
        """End the server and start it again: its port and its token change."""
        before = self.server.token
        self._running.close()
        self.server = self._started()
        assert self.server.token != before

    def close(self) -> None:
        self._running.close()

    def visit(self, browser: httpx.Client) -> None:
        """Open the URL that the server prints."""
        answer = browser.get(f"{self.server.url}/", params={"token": self.server.token})
        assert answer.status_code == 303
        for line in answer.headers.get_list("set-cookie"):
            assert "HttpOnly" in line
            assert "SameSite=strict" in line

    def post(self, browser: httpx.Client, path: str, body: object = None) -> httpx.Response:
        """Call the API as the page does."""
        headers = {"Origin": self.server.url}
        return browser.post(f"{self.server.url}/api/v1{path}", json=body, headers=headers)

    def paint(self, browser: httpx.Client, x: float) -> None:
        stroke = {"label": 1, "radius": 0.4, "samples": [{"origin": [x, 0, 3]}]}
        answer = self.post(browser, "/sequences/wall/frames/0/strokes", stroke)
        assert answer.status_code == 200, answer.text
        assert answer.json()["changed"] > 0

    def undo(self, browser: httpx.Client) -> int:
        return self.post(browser, "/sequences/wall/undo").status_code

    def painted(self) -> int:
        """Number of points that are painted."""
        return int((self.server.workspace.annotations.read("wall", 0)[0] != 0).sum())


@pytest.fixture
def opened(tmp_path: Path) -> Iterator[Opened]:
    settings = settings_in(tmp_path, token="")
    add_sequence(settings, "wall", frames=1, points=2_000)
    with closing(Opened(settings)) as running:
        yield running


@contextmanager
def browser_of(opened: Opened) -> Iterator[httpx.Client]:
    with httpx.Client() as client:
        opened.visit(client)
        yield client


def _sign_out(opened: Opened, browser: httpx.Client) -> None:
    headers = {"Origin": opened.server.url}
    answer = browser.delete(f"{opened.server.url}/api/v1/session", headers=headers)
    assert answer.status_code == 204


def second_tab(opened: Opened, browser: httpx.Client) -> None:
    opened.visit(browser)


def bookmark_of_a_closed_browser(opened: Opened, browser: httpx.Client) -> None:
    kept = [cookie for cookie in browser.cookies.jar if cookie.expires is not None]
    browser.cookies.clear()
    for cookie in kept:
        browser.cookies.jar.set_cookie(cookie)
    opened.visit(browser)


def restart(opened: Opened, browser: httpx.Client) -> None:
    opened.restart()
    opened.visit(browser)


def sign_out_and_in(opened: Opened, browser: httpx.Client) -> None:
    _sign_out(opened, browser)
    token = {"token": opened.server.token}
    assert opened.post(browser, "/session", token).status_code == 200


def session_gone(opened: Opened, browser: httpx.Client) -> None:
    [name] = [name for name in browser.cookies if name.startswith("pointbrush_session")]
    browser.cookies.delete(name)
    assert opened.undo(browser) == 401  # an account alone lets nobody in
    opened.visit(browser)


@pytest.mark.parametrize(
    "again",
    [second_tab, bookmark_of_a_closed_browser, restart, sign_out_and_in, session_gone],
    ids=lambda way: way.__name__,
)
def test_undo_goes_on_after_opening_again(
    opened: Opened, again: Callable[[Opened, httpx.Client], None]
) -> None:
    with browser_of(opened) as mine, browser_of(opened) as other:
        opened.paint(mine, LEFT)
        one = opened.painted()
        opened.paint(mine, 0.0)
        assert opened.undo(mine) == 200
        assert opened.painted() == one
        opened.paint(other, RIGHT)
        both = opened.painted()
        again(opened, mine)
        assert opened.undo(mine) == 200
        assert opened.painted() == both - one
        assert opened.undo(mine) == 409
        assert opened.painted() == both - one


def test_a_script_with_the_servers_own_token_is_the_owner(opened: Opened) -> None:
    with browser_of(opened) as mine, httpx.Client() as script:
        script.headers["Authorization"] = f"Bearer {opened.server.token}"
        script.cookies = mine.cookies
        opened.paint(mine, LEFT)
        opened.paint(script, RIGHT)
        assert opened.undo(script) == 200
        assert opened.undo(script) == 409
        assert opened.server.workspace.labels.edits("wall")[1].author == "owner"


def _account_cookie(browser: httpx.Client) -> tuple[str, str]:
    [found] = [item for item in browser.cookies.items() if item[0].startswith("pointbrush_account")]
    return found


@pytest.mark.parametrize("forged", ["other account", "a token's name", "cut", "other signature"])
def test_a_forged_account_is_a_new_one(opened: Opened, forged: str) -> None:
    ada = opened.server.workspace.labels.tokens.add("annotator", "ada")
    with browser_of(opened) as victim, httpx.Client() as thief:
        opened.paint(victim, LEFT)
        with httpx.Client(headers={"Authorization": f"Bearer {ada}"}) as person:
            opened.paint(person, RIGHT)
        name, value = _account_cookie(victim)
        account, _, signature = value.rpartition(".")
        made = {
            "other account": f"browser:0.{signature}",
            "a token's name": f"ada.{signature}",
            "cut": account,
            "other signature": f"{account}.{'0' * len(signature)}",
        }[forged]
        thief.cookies.set(name, made, domain="127.0.0.1")
        assert opened.undo(thief) == 401
        thief.cookies.set(name, made, domain="127.0.0.1")
        opened.visit(thief)
        assert opened.undo(thief) == 409
        assert opened.undo(victim) == 200


def test_an_account_of_another_workspace_is_none_here(tmp_path: Path) -> None:
    folders = [tmp_path / name for name in ("here", "there")]
    with ExitStack() as stack:
        servers = []
        for folder in folders:
            settings = settings_in(folder, token="")
            add_sequence(settings, "wall", frames=1, points=2_000)
            servers.append(stack.enter_context(closing(Opened(settings))))
        here, there = servers
        browser = stack.enter_context(browser_of(here))
        here.paint(browser, LEFT)
        there.visit(browser)
        assert there.undo(browser) == 409
        here.restart()
        here.visit(browser)
        assert here.undo(browser) == 200


def test_a_session_of_before_accounts_were_kept_tells_the_account(opened: Opened) -> None:
    with browser_of(opened) as mine:
        opened.paint(mine, LEFT)
        name, _ = _account_cookie(mine)
        mine.cookies.delete(name)
        opened.visit(mine)
        assert opened.undo(mine) == 200


def test_a_browser_keeps_few_accounts_of_other_workspaces(opened: Opened) -> None:
    with httpx.Client() as browser:
        for number in range(12):
            browser.cookies.set(f"pointbrush_account_http_{number:08x}", "x", domain="127.0.0.1")
        opened.visit(browser)
        kept = [name for name in browser.cookies if name.startswith("pointbrush_account")]
        assert len(kept) == 8
        assert {f"pointbrush_account_http_{number:08x}" for number in range(5, 12)} < set(kept)
