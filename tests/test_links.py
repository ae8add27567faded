"""Links between Markdown files lead to files and headings, as a code host shows them."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from urllib.parse import unquote, urlsplit

import markdown
import pytest

from tests.html_page import Page

ROOT = Path(__file__).parent.parent
FILES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
EXTENSIONS = ("attr_list", "fenced_code", "tables", "toc")
MERGE_MARKER = re.compile(r"^(<{7}|\|{7}|={7}|>{7})( |$)", re.M)


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def slug(heading: str, separator: str) -> str:
    """Return the anchor of a heading as code hosts make it; the site's differ in runs of spaces."""
    return re.sub(r"[^\w\s-]", "", heading.lower()).replace(" ", separator)


@cache
def rendered(path: Path) -> Page:
    page = Page()
    text = path.read_text(encoding="utf-8")
    slugs = {"toc": {"slugify": slug}}
    page.feed(markdown.markdown(text, extensions=EXTENSIONS, extension_configs=slugs))
    return page


def dead_links(path: Path) -> list[str]:
    """Return the relative links of a file that lead to no file, or to no heading of it."""
    dead = []
    for link in rendered(path).links:
        parts = urlsplit(link)
        if parts.scheme or parts.netloc:
            continue
        target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
        anchored = parts.fragment and target.suffix == ".md" and target.is_file()
        if not target.exists() or (
            anchored and unquote(parts.fragment) not in rendered(target).anchors
        ):
            dead.append(link)
    return dead


@pytest.mark.parametrize("path", FILES, ids=name_of)
def test_every_link_leads_to_a_file_and_its_heading(path: Path) -> None:
    assert dead_links(path) == []


def test_the_readme_is_merged() -> None:
    marker = MERGE_MARKER.search((ROOT / "README.md").read_text(encoding="utf-8"))
    assert not marker, f"expected no merge markers, got {marker and marker[0]!r}"
