"""The documentation as a site: builds without a warning, works from disk, fetches nothing."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from urllib.parse import unquote, urlsplit

import pytest
from playwright.sync_api import Browser, sync_playwright
from playwright.sync_api import Page as BrowserPage
from playwright.sync_api import TimeoutError as TimedOutError

from tests.e2e.chromium import COMPOSED, EXECUTABLE, FLAGS
from tests.html_page import Page
from tests.waiting import PATIENCE

ROOT = Path(__file__).parent.parent
FETCHED = re.compile(
    r"""<(?:script|img|iframe|source|video|audio)[^>]+src=["']?(?:https?:)?//"""
    r"""|<link(?![^>]+rel=["']?canonical)[^>]+href=["']?(?:https?:)?//"""
    r"""|url\(["']?(?:https?:)?//|@import\s+["'](?:https?:)?//|class=["']?mermaid"""
)
MOST_ENTRIES = 40
"""Most pages in the navigation."""
FOUND = {
    "troubleshooting": "troubleshooting",
    "slow": "troubleshooting",
    "jupyter": "examples/explore",
    "subscribe": "howto/webhooks",
    "swagger": "reference/rest",
    "keyboard": "desk",
    "shortcuts": "desk-tools",
    "undo": "labels",
    "delete a recording": "howto/care",
}
"""Words that a reader searches for, and the page that answers."""
AMONG_THE_FIRST = 3
ARTICLE = re.compile(r"<article.*?</article>", re.S)
SCROLLED = """article => {
  document.querySelector('article').outerHTML = article;
  return document.documentElement.scrollWidth;
}"""
"""Shows another article, and returns how wide the page is with it."""
NO_PAGE = "404.html"
"""A server answers with it under any address, so its links begin at the root."""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", out],
        cwd=ROOT,
        env=os.environ | {"NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
        check=False,
        timeout=240,
    )
    assert done.returncode == 0, done.stderr
    return out


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Page]:
    found = {}
    for path in site.rglob("*.html"):
        if path.name != NO_PAGE:
            found[path] = Page()
            found[path].feed(path.read_text())
    return found


def test_nothing_is_fetched(site: Path) -> None:
    for path in (*site.rglob("*.html"), *site.rglob("*.css")):
        assert not FETCHED.search(path.read_text()), path


def test_every_link_opens_a_file_from_disk(pages: dict[Path, Page]) -> None:
    lost = []
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = path if not parts.path else (path.parent / unquote(parts.path)).resolve()
            known = pages.get(target)
            if not target.is_file() or (
                parts.fragment and known and unquote(parts.fragment) not in known.anchors
            ):
                lost.append(f"{path.name}: {link}")
    assert lost == []


def test_tables_have_heads(pages: dict[Path, Page]) -> None:
    assert [path.name for path, page in pages.items() if not all(page.heads)] == []


def test_the_references_are_written_from_the_program(site: Path) -> None:
    reference = site / "reference"
    assert "import-labels" in (reference / "cli.html").read_text()
    assert "/frames/{i}/strokes" in (reference / "rest.html").read_text()
    # What code has is coloured word by word.
    palette = re.sub(r"<[^>]+>", "", (reference / "rest" / "palette.html").read_text())
    assert "HTTP/1.1 201 Created" in palette
    schemas = (reference / "rest" / "schemas.html").read_text()
    assert "<code>only_unlabeled</code>" in schemas
    python = {
        path.stem: re.sub(r"<[^>]+>", "", path.read_text())
        for path in (reference / "python").glob("*.html")
    }
    assert "timeout=30.0" in python["client"], "an example of a constructor"
    assert "if_match=values.etag" in python["frame"], "an example of a method"
    assert "quaternion" in python["boxpose"], "a field"
    assert [name for name, page in python.items() if "Steps[" in page] == []


def test_each_example_has_a_page_that_others_lead_to(pages: dict[Path, Page], site: Path) -> None:
    for example in (ROOT / "docs" / "examples").glob("[a-z]*"):
        page = site / "examples" / f"{example.stem}.html"
        assert page in pages
        linked = [
            path
            for path in (ROOT / "docs").rglob("*.md")
            if f"examples/{example.name}" in path.read_text()
        ]
        assert linked, example


def test_the_navigation_is_short_and_its_pages_list_the_others(
    site: Path, pages: dict[Path, Page]
) -> None:
    def targets(path: Path, links: set[str]) -> set[Path]:
        return {(path.parent / unquote(urlsplit(link).path)).resolve() for link in links}

    home = site / "index.html"
    navigation = targets(home, pages[home].entries)
    assert len(navigation) <= MOST_ENTRIES
    listed = set[Path]().union(*(targets(path, pages[path].links) for path in navigation))
    assert set(pages) <= listed


def test_a_list_for_language_models_has_the_pages(site: Path, pages: dict[Path, Page]) -> None:
    listed = re.findall(r"^- \[.+?\]\((.+?)\): \S", (site / "llms.txt").read_text(), re.M)
    assert {site / each for each in listed} == set(pages)


def test_search_from_disk_has_the_pages(site: Path, pages: dict[Path, Page]) -> None:
    script = (site / "search" / "search_index.js").read_text()
    found = json.loads(script.removeprefix("var __index = "))["docs"]
    assert {urlsplit(each["location"]).path or "index.html" for each in found} == {
        path.relative_to(site).as_posix() for path in pages
    }


@contextmanager
def over_http(folder: Path) -> Iterator[str]:
    """Serve a folder on loopback; yields its address."""

    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, *_: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=folder)) as server:
        serving = Thread(target=server.serve_forever)
        serving.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            server.shutdown()
            serving.join()


def search(desk: BrowserPage, address: str, wanted: Mapping[str, str]) -> None:
    """Open a page, and search from there for words, each with the page that answers."""
    desk.goto(address)
    desk.locator(".md-search__input").click()
    desk.locator(".md-search-result__meta", has_text="Type to").wait_for()
    for words, page in wanted.items():
        desk.keyboard.press("Control+A")
        desk.keyboard.type(words)
        try:
            desk.wait_for_function(
                "([page, most]) => [...document.querySelectorAll("
                "  '.md-search-result__item > a:first-child'"
                ")].slice(0, most).some(({ href }) => href.includes(page))",
                arg=[f"/{page}.html", AMONG_THE_FIRST],
                timeout=PATIENCE * 1000,
            )
        except TimedOutError:
            found = desk.locator(".md-search-result__item > a:first-child")
            pytest.fail(f"{words}: {found.evaluate_all('all => all.map(({ href }) => href)')}")


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=EXECUTABLE, args=[*FLAGS, COMPOSED])
        yield opened
        opened.close()


def test_a_browser_searches_the_site(site: Path, browser: Browser) -> None:
    desk = browser.new_page()
    complaints: list[str] = []
    desk.on("pageerror", lambda error: complaints.append(str(error)))
    search(desk, (site / "howto" / "kitti.html").as_uri(), FOUND)
    with over_http(site) as address:
        search(desk, f"{address}/howto/kitti.html", {"undo": FOUND["undo"]})
    assert complaints == []


def test_no_page_scrolls_sideways_on_a_phone(
    site: Path, pages: dict[Path, Page], browser: Browser
) -> None:
    width = 390
    phone = browser.new_page(viewport={"width": width, "height": 844}, java_script_enabled=False)
    phone.goto((site / "index.html").as_uri())
    wide = []
    for path in pages:
        # The frame around the article is the same on all pages.
        article = ARTICLE.search(path.read_text())
        assert article is not None, path
        if phone.evaluate(SCROLLED, article[0]) > width:
            wide.append(path.name)
    assert wide == []


def test_the_site_needs_few_packages(tmp_path: Path) -> None:
    command = ["make", "--dry-run", "docs", f"STAMPS={tmp_path}", f"VENV={tmp_path}"]
    planned = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert "docs.txt" in planned
    assert "dev.txt" not in planned
