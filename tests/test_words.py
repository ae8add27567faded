"""Docstrings of the server and comments of the page say what the code does, in plain words."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pointbrush

ROOT = Path(pointbrush.__file__).parent
PAGE = Path(__file__).parents[1] / "webxr_client" / "src"
RIDDLE = re.compile(r"\W*(what|who|whose|which|where|those|how|why|when)\b", re.IGNORECASE)
RIDDLE_BEHIND = re.compile(
    r"\W*(return|yield|tell|say|give|show|list|find|choose|note|know|record|take|answer|measure|learn)s?"
    r"\s+(?:out\s+)?(what|who|whose|whom|which|how|where|why|when)\b",
    re.IGNORECASE,
)
COMMENT = re.compile(r"/\*\*[\s*]*([^\n]*)|(?:^|\n)[ \t]*//([^\n]*(?:\n[ \t]*//[^\n]*)*)")
PERSON = re.compile(r"\b(he|his|him|himself)\b", re.IGNORECASE)


def test_no_docstring_opens_with_a_riddle_and_a_person_is_they() -> None:
    found = []
    for path in ROOT.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            # Docstrings of attributes stand as expressions, like all others.
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
                text = str(node.value.value)
                if RIDDLE.match(text) or PERSON.search(text):
                    found.append((path.relative_to(ROOT).as_posix(), text.splitlines()[0]))
    assert found == []


def test_no_docstring_hides_a_riddle_behind_a_verb_and_nothing_returns_none() -> None:
    found = []
    for path in ROOT.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if not isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                continue
            text, returns = ast.get_docstring(node) or "", getattr(node, "returns", None)
            nothing = isinstance(returns, ast.Constant) and returns.value is None
            if RIDDLE_BEHIND.match(text) or (nothing and text.startswith("Return")):
                found.append((path.relative_to(ROOT).as_posix(), text.splitlines()[0]))
    assert found == []


def test_no_comment_of_the_page_opens_with_a_riddle() -> None:
    found = []
    for path in PAGE.rglob("*.ts*"):
        for comment in COMMENT.finditer(path.read_text()):
            text = comment[1] or comment[2]
            if RIDDLE.match(text or ""):
                found.append((path.relative_to(PAGE).as_posix(), text.splitlines()[0]))
    assert found == []
