"""The links, anchors and table heads of an HTML page."""

from __future__ import annotations

from dataclasses import dataclass, field
from html.parser import HTMLParser


@dataclass
class Page(HTMLParser):
    """Collects the addresses that a page links to, its anchors and its table heads."""

    links: set[str] = field(default_factory=set)
    entries: set[str] = field(default_factory=set)
    """Links of the site's navigation."""
    anchors: set[str] = field(default_factory=set)
    heads: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()
        self._head = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.links |= {value for name in ("href", "src") if (value := given.get(name))}
        if "md-nav__link" in (given.get("class") or "").split() and (link := given.get("href")):
            self.entries.add(link)
        self.anchors |= {value for name in ("id", "name") if (value := given.get(name))}
        if tag == "th":
            self.heads.append("")
        self._head = tag == "th" or (self._head and tag != "td")

    def handle_endtag(self, tag: str) -> None:
        self._head = self._head and tag != "th"

    def handle_data(self, data: str) -> None:
        if self._head:
            self.heads[-1] += data.strip()
