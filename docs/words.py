"""Count the free pronouns of the documentation and of comments: a sentence names its subject.

    python docs/words.py

Code blocks, inline code and comments of a page do not count.
"""

from __future__ import annotations

import ast
import io
import re
import sys
import tokenize
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
SERVER = Path("server", "pointbrush")
PAGE = Path("webxr_client", "src")
PRONOUN = re.compile(
    r"\b(what|who|whose|whom|those|nobody|somebody|everybody|whoever|whatever)\b", re.IGNORECASE
)
WORD = re.compile(r"[^\W\d_]+(?:['’-][^\W\d_]+)*")
NO_PROSE = re.compile(
    r"^(?P<fence>```+|~~~+).*?^(?P=fence)|<!--.*?-->|`[^`\n]+`|\]\([^)]*\)",
    re.DOTALL | re.MULTILINE,
)
PAGE_COMMENT = re.compile(r"/\*.*?\*/|(?<!:)//[^\n]*", re.DOTALL)
MOST_IN_ALL = 4.0
"""Pronouns per 1,000 words of all pages together."""
MOST_IN_A_PAGE = 8.0
MOST_IN_COMMENTS = 3.0
"""Pronouns per 1,000 words of the comments of one package."""


def pages() -> list[Path]:
    """Return the pages that a user reads."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def counts(text: str) -> tuple[int, int]:
    """Return the numbers of free pronouns and of words in the prose of a Markdown text."""
    prose = NO_PROSE.sub(" ", text)
    return len(PRONOUN.findall(prose)), len(WORD.findall(prose))


def comments(path: Path) -> str:
    """Return the comments and docstrings of a module of the server or the page."""
    source = path.read_text(encoding="utf-8")
    if path.suffix != ".py":
        return "\n".join(PAGE_COMMENT.findall(source))
    return "\n".join([*_comments(source), *_docstrings(source)])


def _comments(source: str) -> Iterator[str]:
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            yield token.string


def _docstrings(source: str) -> Iterator[str]:
    # Docstrings of attributes stand as expressions, like all others.
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            yield str(node.value.value)


def packages() -> dict[str, str]:
    """Return the comments of each package of the server and each folder of the page."""
    texts: dict[str, list[str]] = defaultdict(list)
    for top in (SERVER, PAGE):
        for path in sorted([*(ROOT / top).rglob("*.py"), *(ROOT / top).rglob("*.ts*")]):
            inside = path.relative_to(ROOT / top).parts[:-1]
            texts[Path(top, *inside[:1]).as_posix()].append(comments(path))
    return {package: "\n".join(each) for package, each in texts.items()}


def complaints(texts: dict[str, str]) -> list[str]:
    """Return a line for each page above its bound, and for all pages together."""
    found = {name: counts(text) for name, text in texts.items()}
    lines = [_complaint(name, *each, MOST_IN_A_PAGE) for name, each in found.items()]
    pronouns, words = (sum(each[k] for each in found.values()) for k in (0, 1))
    return [
        line for line in [*lines, _complaint("all pages", pronouns, words, MOST_IN_ALL)] if line
    ]


def complaints_of_comments(texts: dict[str, str]) -> list[str]:
    """Return a line for each package whose comments are above their bound."""
    lines = [
        _complaint(f"comments of {name}", *counts(text), MOST_IN_COMMENTS)
        for name, text in texts.items()
    ]
    return [line for line in lines if line]


def _complaint(name: str, pronouns: int, words: int, most: float) -> str:
    rate = 1000 * pronouns / max(words, 1)
    expected = f"expected at most {most:g} free pronouns per 1,000 words"
    return f"{name}: {expected}, got {rate:.1f} ({pronouns})" if rate > most else ""


if __name__ == "__main__":
    found = complaints(
        {page.relative_to(ROOT).as_posix(): page.read_text(encoding="utf-8") for page in pages()}
    ) + complaints_of_comments(packages())
    print("\n".join(found), end="\n" * bool(found))
    sys.exit(bool(found))
