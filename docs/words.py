"""Count the free pronouns of the documentation: a sentence names its subject.

    python docs/words.py

Code blocks, inline code and comments do not count.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
PRONOUN = re.compile(
    r"\b(what|who|whose|whom|those|nobody|somebody|everybody|whoever|whatever)\b", re.IGNORECASE
)
WORD = re.compile(r"[^\W\d_]+(?:['’-][^\W\d_]+)*")
NO_PROSE = re.compile(
    r"^(?P<fence>```+|~~~+).*?^(?P=fence)|<!--.*?-->|`[^`\n]+`|\]\([^)]*\)",
    re.DOTALL | re.MULTILINE,
)
MOST_IN_ALL = 4.0
"""Pronouns per 1,000 words of all pages together."""
MOST_IN_A_PAGE = 8.0


def pages() -> list[Path]:
    """Return the pages that a user reads."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def counts(text: str) -> tuple[int, int]:
    """Return the numbers of free pronouns and of words in the prose of a Markdown text."""
    prose = NO_PROSE.sub(" ", text)
    return len(PRONOUN.findall(prose)), len(WORD.findall(prose))


def complaints(texts: dict[str, str]) -> list[str]:
    """Return a line for each page above its bound, and for all pages together."""
    found = {name: counts(text) for name, text in texts.items()}
    lines = [_complaint(name, *each, MOST_IN_A_PAGE) for name, each in found.items()]
    pronouns, words = (sum(each[k] for each in found.values()) for k in (0, 1))
    return [
        line for line in [*lines, _complaint("all pages", pronouns, words, MOST_IN_ALL)] if line
    ]


def _complaint(name: str, pronouns: int, words: int, most: float) -> str:
    rate = 1000 * pronouns / max(words, 1)
    expected = f"expected at most {most:g} free pronouns per 1,000 words"
    return f"{name}: {expected}, got {rate:.1f} ({pronouns})" if rate > most else ""


if __name__ == "__main__":
    found = complaints(
        {page.relative_to(ROOT).as_posix(): page.read_text(encoding="utf-8") for page in pages()}
    )
    print("\n".join(found), end="\n" * bool(found))
    sys.exit(bool(found))
